#pragma once

#include <optional>
#include <vector>

#include "render/drawn_levels.hpp"
#include "render/gl_functions.hpp"

namespace holdfast {

/// The mesh, or a level of it, as the driver holds it.
struct Geometry {
  GLuint vertex_array = 0;
  std::vector<Batch> batches;
  double deviation = 0;  ///< from the mesh, metres
};

/// Leaves its vertex array bound.
Geometry upload_geometry(const GlFunctions& gl, const DrawnLevel& level);

/// Of the geometry whose vertex array is bound.
void draw_triangles(const GlFunctions& gl, const Batch& batch);

/// A mesh to draw, and ever coarser levels of it to draw in its place where they are as good.
class GlGeometry {
 public:
  /// `levels`: the mesh, then coarser levels of it; `shapes`: those of its shape, which depth alone is drawn of, or of
  /// the mesh, if there are none; without: of `levels` too.
  GlGeometry(const GlFunctions& gl, const std::vector<DrawnLevel>& levels,
             const std::optional<std::vector<DrawnLevel>>& shapes);

  /// The coarsest that deviates by so many metres at most.
  const Geometry& view(double deviation) const;
  /// The same for depth alone, where a view may deviate by so much.
  const Geometry& silhouette(double deviation) const;

 private:
  std::vector<Geometry> levels_, shapes_;
};

}  // namespace holdfast
