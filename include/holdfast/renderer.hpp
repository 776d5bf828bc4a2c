#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "holdfast/camera.hpp"
#include "holdfast/export.hpp"
#include "holdfast/image_view.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"
#include "holdfast/renderer_choice.hpp"

namespace holdfast {

/// Where render() puts a view: host memory of the caller, at least roi.height rows. A null pointer: not wanted.
struct RenderTarget {
  std::uint8_t* rgba = nullptr;  ///< 4 bytes a pixel; alpha is 255 where the surface has a known texture or colour
  float* depth = nullptr;        ///< window depth, 1 where nothing was drawn; see DepthRange
  int stride = 0;                ///< pixels from a row to the next, of both buffers; 0: roi.width
};

/// Turns window depth d into metric depth: Z = near far / (far - d (far - near)) (equation 2 in docs/math.md).
struct DepthRange {
  double near_plane = 0;  ///< metres
  double far_plane = 0;   ///< metres

  /// Z in metres of a window depth below 1.
  double metric(double window) const {
    return near_plane * far_plane / (far_plane - window * (far_plane - near_plane));
  }
};

struct RendererOptions {
  int texture_samples = 4;  ///< bilinear samples a pixel: 1, or 4 averaged as light, at four times the cost
  /// A mesh of many triangles is drawn with fewer, as long as surface and texture stay where they are within this many
  /// pixels (root of the mean square where it is worst); 0: with all of them.
  double deviation_pixels = 0;
  bool lit = false;           ///< set_shading() is going to be used: shaders for it are made at once
  bool silhouettes = false;   ///< depth alone is going to be asked for: drawn of the shape, at twice the deviation
  bool light_texels = false;  ///< set_light_texels() is going to be used: textures for it are made too
  RendererChoice choice = RendererChoice::automatic;
};

/// Draws one mesh with OSMesa or EGL (loaded at run time), without a screen. One OpenGL context each; an object may be
/// used from one thread at a time, any thread. A context of the caller's that is current by EGL stays so.
class HOLDFAST_EXPORT Renderer {
 public:
  /// `max_width` x `max_height`: the largest region that render() will be asked for, pixels.
  /// Throws Error(renderer) when neither is there or it does not draw, Error(model) for a mesh that cannot be drawn,
  /// Error(invalid_argument) for a size or an option out of range.
  Renderer(const Mesh& mesh, int max_width, int max_height, const RendererOptions& options = {});
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  /// Draws the pixels `roi` (may reach outside the camera's frame) of the view at `T_camera_object`; rows from the top
  /// down; lens distortion is not drawn. Textures are sampled linearly within mipmaps of half a pixel a texel,
  /// nearest between them.
  /// Returns the depth range of this view. When the object is not in front of the camera nothing is drawn.
  /// Throws Error(invalid_argument) for a region that is empty, larger than the maximum or wider than the stride,
  /// Error(pose) for a pose that is not finite, Error(renderer) when OpenGL fails.
  DepthRange render(const Pose& T_camera_object, const Camera& camera, const Rect& roi, const RenderTarget& target);

  /// Replaces the texture of a material (same or another size) without touching the mesh.
  /// Throws Error(invalid_argument) for an index out of range, a texture whose size and bytes do not match or a mesh
  /// without texture coordinates, Error(model) for a texture larger than OpenGL takes.
  void set_texture(std::size_t material, const Texture& texture);

  /// What a distant light adds: surface with the unit normal n (camera axes, towards the camera) is drawn
  /// (1 + shading . n) / (1 + |shading|) times as bright as its texture, from now on. Shorter than 1; zero, as at
  /// first: as bright as its texture.
  void set_shading(const Eigen::Vector3d& shading);

  /// Whether texels are averaged and interpolated as the light that they stand for (sRGB), as a camera does it, from
  /// now on; otherwise, and at first, as their encoded values, as many a renderer does it. Edges between bright and
  /// dark texels lie elsewhere then. Throws Error(invalid_argument) when the option light_texels was not given.
  void set_light_texels(bool light);

  /// "OSMesa" or "EGL", GL_RENDERER, GL_VERSION of the context, for reports.
  std::string description() const;
  /// Why it is this one: "the first choice", "asked for", or what was wrong with the first choice.
  std::string reason() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace holdfast
