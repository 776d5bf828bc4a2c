#pragma once

#include <Eigen/Core>
#include <vector>

#include "holdfast/mesh.hpp"

namespace holdfast {

/// A piece of surface as the frame shows it.
struct LitPatch {
  Eigen::Vector3d normal;  ///< unit, towards the camera, camera axes
  double brightness = 0;   ///< of the frame over the texture's
  double weight = 0;       ///< pixels
};

/// Whether most of the surface is made of a few flat faces. Only on these may light be drawn into the view: on what is
/// curved it has a gradient that does not turn with the surface, and the rows would take it for texture.
bool has_flat_faces(const Mesh& mesh);

/// How light depends on where surface faces, (1 + b . n) / (1 + |b|) times the texture's brightness (equation 15a of
/// docs/math.md). Faces that meet at an edge are lit differently: drawn into the view, that is no error of the model.
class Shading {
 public:
  const Eigen::Vector3d& direction() const { return b_; }
  double of(const Eigen::Vector3d& normal) const { return (1 + b_.dot(normal)) / (1 + b_.norm()); }

  /// Takes the patches of one more frame into account. Where they do not tell, the direction stays what it was.
  void learn(const std::vector<LitPatch>& patches);

 private:
  Eigen::Vector3d b_ = Eigen::Vector3d::Zero();
  bool known_ = false;
};

}  // namespace holdfast
