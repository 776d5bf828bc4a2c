#pragma once

#include <vector>

#include "holdfast/mesh.hpp"

namespace holdfast {

/// Cosine of the angle between faces that is a crease, else they are one smooth surface: 30 degrees.
inline constexpr float kCreaseCosine = 0.866F;

/// A place on an edge of the model, object frame, metres.
struct EdgeSample {
  Eigen::Vector3f p_object = Eigen::Vector3f::Zero();
  Eigen::Vector3f along = Eigen::Vector3f::Zero();  ///< unit vector
  /// Unit normals of the faces on both sides; the second is zero at the border of an open surface.
  Eigen::Vector3f first = Eigen::Vector3f::Zero(), second = Eigen::Vector3f::Zero();
  int chain = 0;  ///< samples of one chain follow each other along a smooth line
};

/// Samples, at most `most` and evenly along them, of the edges that a picture of the mesh may show whatever its
/// colours: creases (faces that meet at an angle), borders of open surfaces and, without texture, of materials. Edges
/// end to end make a chain while they go straight on; chains that are short beside the mesh are left out.
std::vector<EdgeSample> model_edges(const Mesh& mesh, std::size_t most);

}  // namespace holdfast
