#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "holdfast/mesh.hpp"
#include "holdfast/renderer.hpp"

/// Views drawn by the renderer, and what a ray caster that knows nothing of it says they should be.
namespace holdfast::test {

// Odd size, fx != fy, principal point off the centre.
inline const Camera kRenderCamera{147, 101, 190.3, 214.7, 61.37, 58.81, {}};

struct View {
  Rect roi;
  std::vector<std::uint8_t> rgba;
  std::vector<float> window_depth;
  DepthRange range;

  std::size_t index(int column, int row) const { return static_cast<std::size_t>(row) * roi.width + column; }
  bool drawn(int column, int row) const { return window_depth[index(column, row)] < 1; }
  double depth(int column, int row) const {
    const double n = range.near_plane;
    const double f = range.far_plane;
    return n * f / (f - window_depth[index(column, row)] * (f - n));
  }
  const std::uint8_t* pixel(int column, int row) const { return rgba.data() + 4 * index(column, row); }
  long drawn_count() const {
    return std::count_if(window_depth.begin(), window_depth.end(), [](float depth) { return depth < 1; });
  }
  long known_count() const {
    long count = 0;
    for (std::size_t i = 3; i < rgba.size(); i += 4) {
      count += rgba[i] == 255 ? 1 : 0;
    }
    return count;
  }
};

View draw(Renderer& renderer, const Pose& pose, const Camera& camera, const Rect& roi);
/// The whole frame.
View draw(Renderer& renderer, const Pose& pose, const Camera& camera = kRenderCamera);

/// A view against the ray caster. Pixels whose centre lies within 0.01 px of an edge (rays 0.01 px away see something
/// else) are left out; `compared` says how many remain. A depth is right that lies between those of these rays:
/// graphics processors put corners on a grid of 1/256 px.
struct Comparison {
  long pixels = 0;
  long compared = 0;        ///< of the mask
  long mask_errors = 0;     ///< among these
  long surface_pixels = 0;  ///< on a triangle, off its edges
  long known = 0;           ///< of these, with a known colour
  long colors = 0;          ///< of these, with a magnified texture
  long alpha_errors = 0;
  double depth_error = 0;  ///< relative, beyond what is right, largest
  double color_error = 0;  ///< grey levels, largest
};

/// `repeat` says what texture coordinates do at the border, `texture_samples` how often the renderer reads the texture.
Comparison compare(const Mesh& mesh, const Pose& pose, const Camera& camera, const View& view, bool repeat = false,
                   int texture_samples = 4);

/// Mask, alpha and depth are right, and hardly a pixel was too near an edge to be compared.
void check_geometry(const Comparison& comparison);

Texture random_texture(int width, int height, unsigned seed);
Texture plain_texture(int size, const std::array<std::uint8_t, 4>& color);

/// 0.2 m square in the plane Z = 0, its top (v = 1) towards -y, which is up in the image at the identity rotation.
Mesh quad(const Texture& texture, float repeats = 1);

/// A box whose six faces have two textured materials, one without texture, and vertex colours.
Mesh colored_box();

Pose pose_at(const Eigen::Vector3d& translation, const Eigen::Vector3d& rotation = Eigen::Vector3d::Zero());

}  // namespace holdfast::test
