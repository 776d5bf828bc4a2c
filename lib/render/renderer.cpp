#include "holdfast/renderer.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <future>
#include <optional>
#include <utility>
#include <vector>

#include "base/closed_surface.hpp"
#include "render/drawn_levels.hpp"
#include "render/gl_checks.hpp"
#include "render/gl_context.hpp"
#include "render/gl_framebuffers.hpp"
#include "render/gl_geometry.hpp"
#include "render/gl_programs.hpp"
#include "render/gl_textures.hpp"
#include "render/renderer_error.hpp"

namespace holdfast {
namespace {

Eigen::AlignedBox3d bounding_box(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& position : mesh.positions) {
    box.extend(position.cast<double>());
  }
  return box;
}

void fill_empty(const Rect& roi, const RenderTarget& target, int stride) {
  for (int row = 0; row < roi.height; ++row) {
    const std::size_t offset = static_cast<std::size_t>(row) * stride;
    if (target.rgba != nullptr) {
      std::fill_n(target.rgba + offset * 4, static_cast<std::size_t>(roi.width) * 4, std::uint8_t{0});
    }
    if (target.depth != nullptr) {
      std::fill_n(target.depth + offset, roi.width, 1.0F);
    }
  }
}

// Camera frame to OpenGL's clip space for the pixels of `roi`. OpenGL's first row is its lowest; here it is the top row
// of the image, so that pixels come out from the top down without turning them over. Window depth is equation 2 of
// docs/math.md.
Eigen::Matrix4d projection(const Camera& camera, const Rect& roi, const DepthRange& range) {
  const double n = range.near_plane;
  const double f = range.far_plane;
  Eigen::Matrix4d P = Eigen::Matrix4d::Zero();
  P(0, 0) = 2 * camera.fx / roi.width;
  P(0, 2) = 2 * (camera.cx + 0.5 - roi.x) / roi.width - 1;
  P(1, 1) = 2 * camera.fy / roi.height;
  P(1, 2) = 2 * (camera.cy + 0.5 - roi.y) / roi.height - 1;
  P(2, 2) = (f + n) / (f - n);
  P(2, 3) = -2 * f * n / (f - n);
  P(3, 2) = 1;
  return P;
}

void check(const RendererOptions& options) {
  if (options.texture_samples != 1 && options.texture_samples != 4) {
    fail_rendering(ErrorCode::invalid_argument,
                   "texture_samples is " + std::to_string(options.texture_samples) + "; it must be 1 or 4");
  }
  if (!(options.deviation_pixels >= 0)) {
    fail_rendering(ErrorCode::invalid_argument,
                   "deviation_pixels is " + std::to_string(options.deviation_pixels) + "; it must be 0 or more");
  }
}

/// Where what is wanted differs from what a new context has.
void set_up(const GlFunctions& gl) {
  gl.enable(GL_DEPTH_TEST);
  gl.disable(GL_DITHER);
  gl.front_face(GL_CW);  // rows run downwards (see projection())
}

/// The mesh and, where fewer triangles may be drawn, ever coarser levels of it.
std::vector<DrawnLevel> view_levels(const Mesh& mesh, const Eigen::Vector3d& center, bool coarser) {
  std::vector<DrawnLevel> levels;
  levels.push_back(drawn_mesh(mesh, center));
  if (coarser) {
    for (DrawnLevel& level : coarser_levels(mesh, MeshAspect::appearance, center)) levels.push_back(std::move(level));
  }
  return levels;
}

}  // namespace

struct Renderer::Impl {
  static std::unique_ptr<Impl> make(const Mesh& mesh, int max_width, int max_height, const RendererOptions& options);

  DepthRange render(const Pose& T_camera_object, const Camera& camera, const Rect& roi, const RenderTarget& target);
  void set_texture(std::size_t material, const Texture& texture);
  void warm_up();
  Appearance appearance(std::size_t material) const;
  void draw(const Eigen::Matrix4f& clip_from_object, const Pose& T_camera_center, double pixel) const;
  void draw_depth(const Eigen::Matrix4f& clip_from_object, double pixel) const;

  std::unique_ptr<GlContext> context;
  const GlFunctions& gl;
  std::string description;
  GlFramebuffers framebuffers;
  GlPrograms programs;
  GlGeometry geometry;
  GlTextures textures;
  bool has_colors;
  bool is_closed;           ///< backs of triangles are never seen
  double deviation_pixels;  ///< that a coarser level may cost
  bool lit;                 ///< shading is going to be set
  Eigen::Vector3d center;
  Eigen::Vector3d half_extent;
  bool light_texels = false;  ///< are what is drawn
  Eigen::Vector3f shading = Eigen::Vector3f::Zero();
};

std::unique_ptr<Renderer::Impl> Renderer::Impl::make(const Mesh& mesh, int max_width, int max_height,
                                                     const RendererOptions& options) {
  std::unique_ptr<GlContext> context = create_gl_context(options.choice);
  const GlFunctions& gl = context->gl();
  const CurrentGlContext current(*context);
  std::string description = describe(*context);
  GlFramebuffers framebuffers(gl, max_width, max_height);
  check(options);

  const Eigen::AlignedBox3d box = bounding_box(mesh);
  const Eigen::Vector3d center = box.center(), half_extent = box.sizes() / 2;
  const bool is_closed = is_closed_outward(mesh);
  // Half a pixel where the object is as large as it is drawn in full.
  const double texel_length = half_extent.norm() / std::max(max_width, max_height);
  GlTextures textures(gl, mesh, options.light_texels, texel_length);
  // While shaders are compiled and the mesh is simplified; a thread only where there is something to make.
  std::future<std::vector<LightTexture>> light_textures = std::async(
      options.light_texels ? std::launch::async : std::launch::deferred, [&] { return textures.light_textures(mesh); });
  const bool simplified = options.deviation_pixels > 0;
  std::future<std::vector<DrawnLevel>> shape_levels = std::async(
      options.silhouettes && simplified ? std::launch::async : std::launch::deferred,
      [&] { return simplified ? coarser_levels(mesh, MeshAspect::shape, center) : std::vector<DrawnLevel>{}; });

  GlPrograms programs(gl, options.texture_samples);
  set_up(gl);
  check_drawing(gl, description, framebuffers, programs);
  const std::vector<DrawnLevel> levels = view_levels(mesh, center, simplified);
  std::optional<std::vector<DrawnLevel>> shapes;
  if (options.silhouettes) shapes = shape_levels.get();
  GlGeometry geometry(gl, levels, shapes);
  textures.upload(mesh, std::move(light_textures));
  check_errors(gl, description, "uploading the model");
  return std::unique_ptr<Impl>(new Impl{.context = std::move(context),
                                        .gl = gl,
                                        .description = std::move(description),
                                        .framebuffers = std::move(framebuffers),
                                        .programs = programs,
                                        .geometry = std::move(geometry),
                                        .textures = std::move(textures),
                                        .has_colors = !mesh.colors.empty(),
                                        .is_closed = is_closed,
                                        .deviation_pixels = options.deviation_pixels,
                                        .lit = options.lit,
                                        .center = center,
                                        .half_extent = half_extent});
}

// The driver compiles its code for a material at the first draw: here, not in somebody's first frame.
void Renderer::Impl::warm_up() {
  constexpr int kSize = GlFramebuffers::kSmallest;
  std::vector<std::uint8_t> rgba(std::size_t{kSize} * kSize * 4);
  std::vector<float> depth(std::size_t{kSize} * kSize);
  Camera camera{kSize, kSize, kSize, kSize, 0, 0, {}};
  camera.cx = camera.cy = (kSize - 1) / 2.0;
  Pose T_camera_object = Pose::Identity();
  T_camera_object.translation() = Eigen::Vector3d(0, 0, 4 * half_extent.norm()) - center;
  const auto draw = [&] { render(T_camera_object, camera, {0, 0, kSize, kSize}, {rgba.data(), depth.data(), kSize}); };
  draw();
  render(T_camera_object, camera, {0, 0, kSize, kSize}, {nullptr, depth.data(), kSize});
  if (textures.has_light()) {
    light_texels = !light_texels;
    draw();
    light_texels = !light_texels;
  }
  if (!lit) return;
  const Eigen::Vector3f before = std::exchange(shading, Eigen::Vector3f(0, 0, -0.5F));
  draw();
  shading = before;
}

Appearance Renderer::Impl::appearance(std::size_t material) const {
  if (textures.has_texture(material)) return Appearance::textured;
  return has_colors ? Appearance::vertex_colored : Appearance::unknown;
}

void Renderer::Impl::draw(const Eigen::Matrix4f& clip_from_object, const Pose& T_camera_center, double pixel) const {
  gl.clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  const Geometry& level = geometry.view(deviation_pixels * pixel);
  gl.bind_vertex_array(level.vertex_array);
  const Eigen::Matrix4f camera_from_object = T_camera_center.matrix().cast<float>();
  const bool shaded = !shading.isZero();
  for (const Batch& batch : level.batches) {
    const Appearance look = appearance(batch.material);
    const Program& program = programs.of(look, shaded);
    gl.use_program(program.name);
    gl.uniform_matrix4(program.clip_from_object, 1, GL_FALSE, clip_from_object.data());
    if (shaded) {
      gl.uniform_matrix4(program.camera_from_object, 1, GL_FALSE, camera_from_object.data());
      gl.uniform3(program.shading, 1, shading.data());
    }
    if (look == Appearance::textured) textures.bind(batch.material, light_texels);
    draw_triangles(gl, batch);
  }
}

void Renderer::Impl::draw_depth(const Eigen::Matrix4f& clip_from_object, double pixel) const {
  gl.clear(GL_DEPTH_BUFFER_BIT);
  const Geometry& level = geometry.silhouette(deviation_pixels * pixel);
  gl.bind_vertex_array(level.vertex_array);
  const Program& program = programs.of(Appearance::unknown);
  gl.use_program(program.name);
  gl.uniform_matrix4(program.clip_from_object, 1, GL_FALSE, clip_from_object.data());
  gl.color_mask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  for (const Batch& batch : level.batches) draw_triangles(gl, batch);
  gl.color_mask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

DepthRange Renderer::Impl::render(const Pose& T_camera_object, const Camera& camera, const Rect& roi,
                                  const RenderTarget& target) {
  const int stride = target.stride == 0 ? roi.width : target.stride;
  if (roi.empty() || roi.width > framebuffers.max_width() || roi.height > framebuffers.max_height() ||
      stride < roi.width) {
    fail_rendering(ErrorCode::invalid_argument,
                   "a region of " + size_text(roi.width, roi.height) + " pixels with a stride of " +
                       std::to_string(stride) + " was asked for; it must fit in " +
                       size_text(framebuffers.max_width(), framebuffers.max_height()) + " and in the stride");
  }
  if (!T_camera_object.matrix().allFinite()) {
    fail_rendering(ErrorCode::pose, "the pose holds NaN or infinity; give a rigid motion");
  }

  const Pose T_camera_center = T_camera_object * Eigen::Translation3d(center);
  const double z = T_camera_center.translation().z();
  // The box's extent along the optical axis, a little more so that rounding cannot clip its outermost vertices.
  const double reach = 1.001 * T_camera_center.linear().row(2).cwiseAbs().dot(half_extent) + 1e-6 * std::abs(z) +
                       1e-3 * half_extent.norm();
  DepthRange range;
  range.far_plane = z + reach;
  range.near_plane = std::max(z - reach, 1e-3 * range.far_plane);
  if (!(range.far_plane > 0)) {
    fill_empty(roi, target, stride);
    return {1e-3 * half_extent.norm(), half_extent.norm()};
  }

  const CurrentGlContext current(*context);
  // Backs need not be shaded, unless the near plane cuts the object open.
  const bool cut = range.near_plane > z - reach;
  if (is_closed && !cut) {
    gl.enable(GL_CULL_FACE);
  } else {
    gl.disable(GL_CULL_FACE);
  }
  framebuffers.bind(roi.width, roi.height);
  gl.viewport(0, 0, roi.width, roi.height);
  const Eigen::Matrix4f clip_from_object =
      (projection(camera, roi, range) * T_camera_center.matrix()).eval().cast<float>();
  // Where the object is nearest a metre is the most pixels.
  const double pixel = range.near_plane / std::max(camera.fx, camera.fy);
  if (target.rgba == nullptr) {
    draw_depth(clip_from_object, pixel);
  } else {
    draw(clip_from_object, T_camera_center, pixel);
  }
  framebuffers.read(roi.width, roi.height, stride, target);
  check_errors(gl, description, "rendering");
  return range;
}

void Renderer::Impl::set_texture(std::size_t material, const Texture& texture) {
  {
    const CurrentGlContext current(*context);
    textures.replace(material, texture);
  }
  warm_up();
}

Renderer::Renderer(const Mesh& mesh, int max_width, int max_height, const RendererOptions& options) {
  mesh.validate();
  impl_ = Impl::make(mesh, max_width, max_height, options);
  impl_->warm_up();
}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

DepthRange Renderer::render(const Pose& T_camera_object, const Camera& camera, const Rect& roi,
                            const RenderTarget& target) {
  return impl_->render(T_camera_object, camera, roi, target);
}

void Renderer::set_texture(std::size_t material, const Texture& texture) { impl_->set_texture(material, texture); }

void Renderer::set_shading(const Eigen::Vector3d& shading) {
  if (!(shading.norm() < 1)) {
    fail_rendering(ErrorCode::invalid_argument, "the shading's direction must be shorter than 1");
  }
  impl_->shading = shading.cast<float>();
}

void Renderer::set_light_texels(bool light) {
  if (light && !impl_->textures.has_light()) {
    fail_rendering(ErrorCode::invalid_argument,
                   "light texels are asked for, but the option light_texels was not given");
  }
  impl_->light_texels = light;
}

std::string Renderer::description() const { return impl_->description; }
std::string Renderer::reason() const { return impl_->context->reason(); }

}  // namespace holdfast
