#include "detection/focal_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace holdfast::detection {
namespace {

/// Deviations: of the principal point from the middle, in widths; of k1; of the model's lengths, share; of its parts,
/// in radii, which are cubes of so many radii.
constexpr double kOffCenter = 0.02, kDistortion = 0.1, kStretch = 0.03, kShift = 0.02, kPart = 0.15;
/// Standard deviation of the focal length's logarithm, around one width of the picture, as most cameras have it.
constexpr double kUsual = 0.5;
/// Matches that say the same: features of all sizes overlap.
constexpr double kRepeated = 4;
/// Turns, radians, between frames below which they show the same: so do their matches then.
constexpr double kSameView = 0.05;
constexpr int kMostSteps = 30;
constexpr double kFirstDamping = 1e-3, kMoreDamping = 5, kMostDamping = 1e6;
/// Step of the logarithm of the focal length that ends the search.
constexpr double kSettled = 1e-4;
/// Pixels that a match is off at least.
constexpr double kLeastPixels = 0.3;

using Matrix3 = Eigen::Matrix3d;
using Vector3 = Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Moved by a small motion in camera axes.
Pose moved(const Pose& T_camera_object, const Vector6& motion) {
  Pose T = T_camera_object;
  const Vector3 turn = motion.tail<3>();
  T.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * T.linear();
  T.translation() += motion.head<3>();
  return renormalized(T);
}

/// Inverse variances of what is shared, but for the focal length.
Eigen::Matrix<double, 10, 1> prior() {
  Eigen::Matrix<double, 10, 1> deviations;
  deviations << 1, kOffCenter, kOffCenter, kDistortion, kStretch, kStretch, kStretch, kStretch, kStretch, kStretch;
  Eigen::Matrix<double, 10, 1> information = deviations.cwiseAbs2().cwiseInverse();
  information(0) = 0;
  return information;
}

/// Frames a view that differs from the others.
double frames_of_a_view(const std::vector<Consensus>& frames) {
  std::vector<Matrix3> views;
  for (const Consensus& frame : frames) {
    const Matrix3 R = frame.T_camera_object.linear();
    const auto same = [&](const Matrix3& view) { return rotation_angle(R * view.transpose()) < kSameView; };
    if (std::none_of(views.begin(), views.end(), same)) views.push_back(R);
  }
  return static_cast<double>(frames.size()) / static_cast<double>(std::max<std::size_t>(1, views.size()));
}

}  // namespace

/// Normal equations, pixels: of what is shared and the poses, and of each part with its rows of the coupling.
struct FocalFit::Sums {
  struct OfPart {
    Matrix3 A = Matrix3::Zero();
    Vector3 h = Vector3::Zero();
    std::map<Eigen::Index, Eigen::Matrix<double, 6, 3>> poses;  ///< coupling, by the pose's first row
    Eigen::Matrix<double, kShared, 3> shared = Eigen::Matrix<double, kShared, 3>::Zero();

    /// Calls use(row, block) for each block of the coupling.
    template <class Use>
    void for_each_block(const Use& use) const {
      use(Eigen::Index{0}, Eigen::MatrixXd(shared));
      for (const auto& [row, block] : poses) use(row, Eigen::MatrixXd(block));
    }
  };
  Eigen::MatrixXd A;
  Eigen::VectorXd h;
  std::map<Part, OfPart> parts;
  double square = 0, rows = 0;
};

FocalFit::FocalFit(double focal, const Eigen::Vector2d& center, double width, double radius)
    : focal_(focal), center_(center), width_(width), radius_(radius) {}

FocalFit::Sums FocalFit::sums(const std::vector<Consensus>& frames) const {
  Sums sums;
  const Eigen::Index size = kShared + 6 * static_cast<Eigen::Index>(frames.size());
  sums.A.setZero(size, size);
  sums.h.setZero(size);
  const auto stretch = offsets_.tail<6>();
  Matrix3 S;
  S << stretch(0), stretch(3), stretch(4), stretch(3), stretch(1), stretch(5), stretch(4), stretch(5), stretch(2);
  S += Matrix3::Identity();
  const Eigen::Vector2d center = center_ + width_ * offsets_.segment<2>(1);
  const double k1 = offsets_(3);
  Eigen::Index row = kShared;
  for (const Consensus& frame : frames) {
    const Matrix3 R = frame.T_camera_object.linear();
    for (std::size_t i = 0; i < frame.places.size(); ++i) {
      const Vector3 q(frame.places[i].x, frame.places[i].y, frame.places[i].z);
      Part part;
      for (int axis = 0; axis < 3; ++axis) {
        part[static_cast<std::size_t>(axis)] = static_cast<int>(std::floor(q(axis) / (kPart * radius_)));
      }
      const auto shift = shifts_.find(part);
      const Vector3 moved_place = S * q + radius_ * (shift == shifts_.end() ? Vector3::Zero().eval() : shift->second);
      const Vector3 turned = R * moved_place, p = turned + frame.T_camera_object.translation();
      const Eigen::Vector2d n = p.head<2>() / p.z();
      const double far = n.squaredNorm(), bent = 1 + k1 * far;
      const Eigen::Vector2d residual =
          Eigen::Vector2d(frame.pixels[i].x, frame.pixels[i].y) - center - focal_ * bent * n;
      Eigen::Matrix<double, 2, 3> of_point;  // the pixel's change with p
      of_point << 1, 0, -n.x(), 0, 1, -n.y();
      of_point = focal_ / p.z() * (bent * Eigen::Matrix2d::Identity() + 2 * k1 * n * n.transpose()) * of_point;
      const Eigen::Matrix<double, 2, 3> of_place = of_point * R, of_shift = radius_ * of_place;
      Eigen::Matrix<double, 2, kShared> of_shared;
      of_shared.col(0) = focal_ * bent * n;
      of_shared.middleCols<2>(1) = width_ * Eigen::Matrix2d::Identity();
      of_shared.col(3) = focal_ * far * n;
      for (int axis = 0; axis < 3; ++axis) of_shared.col(4 + axis) = of_place.col(axis) * q(axis);
      of_shared.col(7) = of_place.col(0) * q.y() + of_place.col(1) * q.x();
      of_shared.col(8) = of_place.col(0) * q.z() + of_place.col(2) * q.x();
      of_shared.col(9) = of_place.col(1) * q.z() + of_place.col(2) * q.y();
      Eigen::Matrix<double, 2, 6> of_pose;
      of_pose << of_point, of_point.rowwise().cross(-turned.transpose());
      sums.A.topLeftCorner<kShared, kShared>() += of_shared.transpose() * of_shared;
      sums.A.block<kShared, 6>(0, row) += of_shared.transpose() * of_pose;
      sums.A.block<6, 6>(row, row) += of_pose.transpose() * of_pose;
      sums.h.head<kShared>() += of_shared.transpose() * residual;
      sums.h.segment<6>(row) += of_pose.transpose() * residual;
      Sums::OfPart& own = sums.parts[part];
      own.A += of_shift.transpose() * of_shift;
      own.h += of_shift.transpose() * residual;
      own.shared += of_shared.transpose() * of_shift;
      own.poses.try_emplace(row, Eigen::Matrix<double, 6, 3>::Zero()).first->second += of_pose.transpose() * of_shift;
      sums.square += residual.squaredNorm();
    }
    sums.rows += 2 * static_cast<double>(frame.places.size()) - 6;
    row += 6;
  }
  sums.A.bottomLeftCorner(size - kShared, kShared) = sums.A.topRightCorner(kShared, size - kShared).transpose();
  return sums;
}

double FocalFit::cost(const Sums& sums, double noise) const {
  const double unusual = std::log(focal_ / width_) / kUsual;
  double result = sums.square / noise + offsets_.cwiseAbs2().dot(prior()) + unusual * unusual;
  for (const auto& [part, shift] : shifts_) result += shift.squaredNorm() / (kShift * kShift);
  return result;
}

void FocalFit::fit(std::vector<Consensus>& frames) {
  double damping = kFirstDamping;
  const double repeated = kRepeated * frames_of_a_view(frames);
  Sums here = sums(frames);
  for (const auto& [part, own] : here.parts) shifts_.try_emplace(part, Vector3::Zero());
  for (int i = 0; i < kMostSteps && damping < kMostDamping; ++i) {
    const double noise = repeated * std::max(kLeastPixels * kLeastPixels, here.square / std::max(1.0, here.rows));
    Eigen::MatrixXd A = here.A / noise;
    Eigen::VectorXd h = here.h / noise;
    A.diagonal().head<kShared>() += prior();
    h.head<kShared>() -= prior().cwiseProduct(offsets_);
    A(0, 0) += 1 / (kUsual * kUsual);
    h(0) -= std::log(focal_ / width_) / (kUsual * kUsual);
    std::map<Part, Matrix3> inverses;
    for (const auto& [part, of_part] : here.parts) {
      const Sums::OfPart& own = of_part;  // Clang before 16 lets no lambda have a structured binding
      const Matrix3 inverse = (own.A / noise + Matrix3::Identity() / (kShift * kShift)).inverse();
      inverses[part] = inverse;
      const Vector3 right = own.h / noise - shifts_[part] / (kShift * kShift);
      own.for_each_block([&](Eigen::Index row, const Eigen::MatrixXd& block) {
        const Eigen::MatrixXd reduced = block * inverse / noise;
        h.segment(row, block.rows()) -= reduced * right;
        own.for_each_block([&](Eigen::Index column, const Eigen::MatrixXd& other) {
          A.block(row, column, block.rows(), other.rows()) -= reduced * other.transpose() / noise;
        });
      });
    }
    const Eigen::Index poses = A.rows() - kShared;
    const Eigen::MatrixXd solved = A.bottomRightCorner(poses, poses).ldlt().solve(A.bottomLeftCorner(poses, kShared));
    variance_ = (A.topLeftCorner<kShared, kShared>() - A.topRightCorner(kShared, poses) * solved).inverse()(0, 0);
    A.diagonal() *= 1 + damping;
    const Eigen::VectorXd step = A.ldlt().solve(h);
    FocalFit next = *this;
    next.focal_ *= std::exp(std::clamp(step(0), -0.3, 0.3));
    next.offsets_.tail<kShared - 1>() += step.segment<kShared - 1>(1);
    for (const auto& [part, own] : here.parts) {
      Vector3 right = own.h / noise - shifts_[part] / (kShift * kShift);
      own.for_each_block([&](Eigen::Index row, const Eigen::MatrixXd& block) {
        right -= block.transpose() * step.segment(row, block.rows()) / noise;
      });
      next.shifts_[part] += inverses[part] * right;
    }
    std::vector<Consensus> next_frames = frames;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      next_frames[k].T_camera_object =
          moved(frames[k].T_camera_object, step.segment<6>(kShared + 6 * static_cast<Eigen::Index>(k)));
    }
    Sums there = next.sums(next_frames);
    if (!(next.cost(there, noise) < cost(here, noise))) {
      damping *= kMoreDamping;
      continue;
    }
    damping /= kMoreDamping;
    next.variance_ = variance_;
    *this = std::move(next);
    frames = std::move(next_frames);
    here = std::move(there);
    if (std::abs(step(0)) < kSettled) break;
  }
}

}  // namespace holdfast::detection
