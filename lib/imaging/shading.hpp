#pragma once

#include <Eigen/Core>
#include <span>

#include "holdfast/mesh.hpp"

namespace holdfast {

/// A piece of surface as the frame shows it.
struct LitPatch {
  Eigen::Vector3d normal;  ///< unit, towards the camera, camera axes
  double brightness = 0;   ///< of the frame over the texture's
  double weight = 0;       ///< relative
};

/// Whether most of the surface is made of a few flat faces, at whose edges light steps.
bool has_flat_faces(const Mesh& mesh);

/// How light depends on where surface faces, (1 + b . n) / (1 + |b|) times the texture's brightness (equation 15a of
/// docs/math.md). Drawn into the view, the step where faces meet and the fall-off on curved surface are no errors of
/// the model.
class Shading {
 public:
  const Eigen::Vector3d& direction() const { return b_; }
  double of(const Eigen::Vector3d& normal) const { return (1 + b_.dot(normal)) / (1 + b_.norm()); }

  /// Takes the patches of one more frame into account. Where they do not tell, the direction stays what it was.
  void learn(std::span<const LitPatch> patches);

 private:
  Eigen::Vector3d b_ = Eigen::Vector3d::Zero();
  /// Normal equations of b from the frames so far, the older the less.
  Eigen::Matrix3d A_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d h_ = Eigen::Vector3d::Zero();
};

}  // namespace holdfast
