#include "baking/candidate_views.hpp"

#include <algorithm>
#include <cmath>

namespace holdfast::baking {
namespace {

constexpr std::size_t kMostViews = 512;

}  // namespace

CandidateViews::CandidateViews(const Mesh& mesh, const Camera& camera, double confirming_motion)
    : p_center_(mesh.center()), radius_(mesh.radius()), camera_(camera), confirming_motion_(confirming_motion) {}

bool CandidateViews::full() const { return poses_.size() == kMostViews; }

std::uint16_t CandidateViews::add(const Pose& T_camera_object) {
  moved_.resize(poses_.size());
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    moved_[i] = corner_motion(poses_[i], T_camera_object) >= confirming_motion_;
  }
  poses_.push_back(T_camera_object);
  moved_.push_back(false);
  return static_cast<std::uint16_t>(poses_.size() - 1);
}

double CandidateViews::corner_motion(const Pose& T_a, const Pose& T_b) const {
  const double side = radius_ / std::sqrt(3.0);
  double farthest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d offset((corner & 1) != 0 ? side : -side, (corner & 2) != 0 ? side : -side,
                                 (corner & 4) != 0 ? side : -side);
    const Eigen::Vector3d a = T_a * (p_center_ + offset);
    const Eigen::Vector3d b = T_b * (p_center_ + offset);
    if (a.z() > 0 && b.z() > 0) {
      farthest = std::max(farthest, (camera_.project(a) - camera_.project(b)).norm());
    }
  }
  return farthest;
}

}  // namespace holdfast::baking
