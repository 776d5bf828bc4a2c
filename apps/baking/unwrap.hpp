#pragma once

#include "holdfast/mesh.hpp"

namespace holdfast::baking {

struct UnwrapOptions {
  double texels_per_metre = 1000;  ///< of the surface
  int padding = 4;                 ///< texels of its own round each chart, at least
  int largest_size = 4096;         ///< texels; a surface that does not fit gets fewer texels a metre
  double cone = 0.6;               ///< radians: how far a triangle of a chart may be turned from the chart's plane
};

struct Unwrapped {
  Mesh mesh;       ///< with texture coordinates and one material without a texture; triangles without area are left out
  int width = 0;   ///< of the texture that the coordinates are made for, texels
  int height = 0;  ///< texels
  int charts = 0;
  double texels_per_metre = 0;  ///< less than asked for where that would not fit
};

/// Gives a mesh texture coordinates of its own: connected triangles that face nearly the same way make a chart, which
/// is laid flat in its plane at the surface's scale, and the charts are packed side by side. No two triangles share a
/// place in the texture. Vertices at the border of charts are repeated; materials, textures, vertex colours and
/// coordinates that the mesh had are dropped.
/// Throws Error(model) for a mesh that validate() refuses or that has no area, Error(invalid_argument) for options.
Unwrapped unwrap(const Mesh& mesh, const UnwrapOptions& options = {});

}  // namespace holdfast::baking
