#include "imaging/shading.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <functional>

namespace holdfast {
namespace {

/// What the last direction weighs, a share of a frame's pixels, and what light from everywhere weighs before the first.
constexpr double kPriorShare = 0.02, kFirstPriorShare = 0.002;
/// Of what earlier frames told, what counts on in the next: the less, the more pixels tell of this one.
constexpr double kLeastMemory = 0.7, kMostMemory = 0.95, kForgettingPixels = 4000;
/// Largest share of the light that has a direction, so that no surface that faces away becomes black.
constexpr double kMostDirection = 0.8;
/// Share that pixels usually differ by.
constexpr double kUsualDeviation = 0.15;
constexpr int kRounds = 5;
constexpr std::size_t kLeastPatches = 10;
/// Light from everywhere, what surface that faces away from the other still has.
constexpr double kLeastFacing = 1 - kMostDirection;
/// Of triangles of one face; the faces that may make up an object, and the share of its surface that they must hold.
constexpr double kSameNormal = 0.998;  // the cosine of 3.6 degrees
constexpr std::size_t kMostNormals = 64, kMostFaces = 16;
constexpr double kFlatShare = 0.9;

/// How much less a patch counts that is off by so much of the mean brightness: highlights, shadows, what is in front,
/// texture that is not where it is drawn.
double doubt(double deviation) {
  const double unusual = deviation / kUsualDeviation;
  return 1 + unusual * unusual;
}

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
  std::ranges::sort(faces, std::greater{}, &Face::area);
  double flat = 0;
  for (std::size_t i = 0; i < std::min(kMostFaces, faces.size()); ++i) flat += faces[i].area;
  return flat >= kFlatShare * total;
}

void Shading::learn(std::span<const LitPatch> patches) {
  if (patches.size() < kLeastPatches) return;
  double total = 0, mean = 0;
  Eigen::Vector3d facing = Eigen::Vector3d::Zero();
  for (const LitPatch& patch : patches) {
    total += patch.weight;
    mean += patch.weight * patch.brightness;
    facing += patch.weight * patch.normal;
  }
  if (total <= 0 || mean <= 0) return;
  mean /= total;
  facing /= total;
  const auto pixels = static_cast<double>(patches.size());
  const Eigen::Matrix3d prior = (A_.isZero() ? kFirstPriorShare : kPriorShare) * pixels * Eigen::Matrix3d::Identity();
  Eigen::Vector3d b = b_;
  Eigen::Matrix3d A;
  Eigen::Vector3d h;
  for (int round = 0; round < kRounds; ++round) {
    // Of the mean brightness a (1 + b . n) is light, a of it from everywhere. How bright all of it is changes with the
    // exposure: each frame has its own a, which is eliminated.
    const double a = 1 / std::max(kLeastFacing, 1 + b.dot(facing));
    double weights = 0, brightness = 0;
    Eigen::Vector3d normals = Eigen::Vector3d::Zero();
    A.setZero();
    h.setZero();
    for (const LitPatch& patch : patches) {
      const double relative = patch.brightness / mean;
      const double deviation = relative - a * (1 + b.dot(patch.normal));
      const double weight = patch.weight * (pixels / total) / (round > 0 ? doubt(deviation) : 1);
      weights += weight;
      brightness += weight * relative;
      normals += weight * patch.normal;
      A += weight * patch.normal * patch.normal.transpose();
      h += weight * relative * patch.normal;
    }
    A = (a * a * (A - normals * normals.transpose() / weights)).eval();
    h = (a * (h - normals * brightness / weights)).eval();
    b = (A_ + A + prior).ldlt().solve(h_ + h + prior * b_);
    if (!b.allFinite()) return;
    if (b.norm() > kMostDirection) b *= kMostDirection / b.norm();
  }
  const double memory = std::clamp(1 - pixels / kForgettingPixels, kLeastMemory, kMostMemory);
  A_ = memory * (A_ + A);
  h_ = memory * (h_ + h);
  b_ = b;
}

}  // namespace holdfast
