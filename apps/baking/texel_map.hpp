#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "holdfast/mesh.hpp"

namespace holdfast::baking {

/// A texel and the point of the surface that its centre lies on.
struct SurfaceTexel {
  Eigen::Vector3f p_object;  ///< metres
  std::uint32_t texel;       ///< counted through all textures
};

/// Which texels of a mesh's textures lie on its surface, and where. Texels are counted through the textures of all
/// materials, row by row from the top.
struct TexelMap {
  std::vector<cv::Size> sizes;           ///< of each material's texture, texels
  std::vector<std::uint32_t> first;      ///< of each material: its first texel; then their number
  std::vector<SurfaceTexel> surface;     ///< by triangle
  std::vector<std::uint32_t> triangles;  ///< triangle t owns surface[triangles[t]] up to surface[triangles[t + 1]]
  std::vector<float> area;               ///< a triangle: surface area that one of its texels stands for, square metres
  std::vector<std::uint8_t> shared;      ///< of each texel: 1 where another place of the surface lies on it too

  /// Texels off the surface, and the nearest one on it: filtering at a chart's border must not meet another chart, nor
  /// nothing.
  struct Padding {
    std::uint32_t texel;
    std::uint32_t source;
  };
  std::vector<Padding> padding;

  std::uint32_t count() const { return first.back(); }
};

/// `sizes`: of each material's texture, texels. Throws Error(model) when the mesh has no texture coordinates, or
/// coordinates that leave [0, 1], so that one texel stands for many places.
TexelMap map_texels(const Mesh& mesh, const std::vector<cv::Size>& sizes);

/// Texture sizes for a mesh with texture coordinates of its own: as many texels a metre of surface (in the mean) as
/// asked for, of the shape of the textures that it has, no side above `largest_size`.
std::vector<cv::Size> texture_sizes(const Mesh& mesh, double texels_per_metre, int largest_size);

}  // namespace holdfast::baking
