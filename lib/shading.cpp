#include "shading.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace holdfast {
namespace {

/// Weight of a new frame.
constexpr double kMemory = 0.3;
/// What the last direction weighs: a share of the patches, and, once there is one, as many pixels.
constexpr double kPriorShare = 1e-3, kPriorPixels = 500;
/// Of the light, so that none that faces away becomes black.
constexpr double kMostDirection = 0.8;
/// Patches that differ by more than about this share (highlights, shadows, what is in front) count for little.
constexpr double kUsualDeviation = 0.05;
constexpr int kRounds = 5;
constexpr std::size_t kLeastPatches = 10;
/// Of triangles of one face; the faces that may make up an object, and the share of its surface that they must hold.
constexpr double kSameNormal = 0.998;  // the cosine of 3.6 degrees
constexpr std::size_t kMostNormals = 64, kMostFaces = 16;
constexpr double kFlatShare = 0.9;

}  // namespace

bool has_flat_faces(const Mesh& mesh) {
  struct Face {
    Eigen::Vector3d normal;
    double area = 0;
  };
  std::vector<Face> faces;
  double total = 0;
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3d a = mesh.positions[triangle[0]].cast<double>(),
                          b = mesh.positions[triangle[1]].cast<double>(),
                          c = mesh.positions[triangle[2]].cast<double>();
    const Eigen::Vector3d cross = (b - a).cross(c - a);
    const double area = 0.5 * cross.norm();
    if (area <= 0) continue;
    total += area;
    const Eigen::Vector3d normal = cross.normalized();
    auto face = std::find_if(faces.begin(), faces.end(),
                             [&](const Face& other) { return other.normal.dot(normal) > kSameNormal; });
    if (face == faces.end()) {
      if (faces.size() == kMostNormals) continue;
      face = faces.insert(face, {normal, 0});
    }
    face->area += area;
  }
  std::sort(faces.begin(), faces.end(), [](const Face& one, const Face& other) { return one.area > other.area; });
  double flat = 0;
  for (std::size_t i = 0; i < std::min(kMostFaces, faces.size()); ++i) flat += faces[i].area;
  return flat >= kFlatShare * total;
}

void Shading::learn(const std::vector<LitPatch>& patches) {
  if (patches.size() < kLeastPatches) return;
  // a (1 + b . n) = a + c . n, linear in a and c; c is drawn to what it was at the mean brightness.
  double total = 0, mean = 0;
  for (const LitPatch& patch : patches) {
    total += patch.weight;
    mean += patch.weight * patch.brightness;
  }
  if (total <= 0 || mean <= 0) return;
  mean /= total;
  Eigen::Vector4d x(mean, mean * b_.x(), mean * b_.y(), mean * b_.z());
  const Eigen::Vector4d before(0, mean * b_.x(), mean * b_.y(), mean * b_.z());
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix4d A = Eigen::Vector4d(0, 1, 1, 1).asDiagonal();
    A *= kPriorShare * total + (known_ ? kPriorPixels : 0);
    Eigen::Vector4d h = A * before;
    for (const LitPatch& patch : patches) {
      const Eigen::Vector4d row(1, patch.normal.x(), patch.normal.y(), patch.normal.z());
      const double deviation = (patch.brightness - row.dot(x)) / (kUsualDeviation * mean);
      const double weight = patch.weight / (1 + (round > 0 ? deviation * deviation : 0));
      A += weight * row * row.transpose();
      h += weight * patch.brightness * row;
    }
    x = A.ldlt().solve(h);
  }
  if (!x.allFinite() || x(0) <= 0.1 * mean) return;
  Eigen::Vector3d found = x.tail<3>() / x(0);
  if (found.norm() > kMostDirection) found *= kMostDirection / found.norm();
  b_ += (known_ ? kMemory : 1) * (found - b_);
  known_ = true;
}

}  // namespace holdfast
