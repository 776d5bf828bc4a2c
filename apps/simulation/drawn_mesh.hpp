#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "holdfast/mesh.hpp"
#include "simulation/mip_texture.hpp"

namespace holdfast::simulation {

/// A mesh made ready for drawing: normals (smooth across edges below 40 degrees), textures in linear light.
class DrawnMesh {
 public:
  /// Throws Error(model) when the mesh cannot be drawn.
  explicit DrawnMesh(const Mesh& mesh);

  struct Triangle {
    std::array<Eigen::Vector3d, 3> positions;  // object frame
    std::array<Eigen::Vector3d, 3> normals;    // object frame, unit
    std::array<Eigen::Vector2d, 3> texels;     // pixel coordinates of the texture (centres at integers)
    std::array<Eigen::Vector3f, 3> colors;     // linear BGR, where there is no texture
    int texture = -1;                          // index, or -1
  };
  const std::vector<Triangle>& triangles() const { return triangles_; }
  const std::vector<MipTexture>& textures() const { return textures_; }
  bool repeats() const { return repeats_; }

 private:
  std::vector<Triangle> triangles_;
  std::vector<MipTexture> textures_;
  bool repeats_ = false;
};

}  // namespace holdfast::simulation
