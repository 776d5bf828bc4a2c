#include "holdfast/renderer.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <future>
#include <optional>
#include <utility>
#include <vector>

#include "closed_surface.hpp"
#include "drawn_levels.hpp"
#include "embedded_text.hpp"
#include "enlarged_texture.hpp"
#include "gl_context.hpp"
#include "holdfast/error.hpp"
#include "light_levels.hpp"
#include "texture_levels.hpp"

namespace holdfast {
namespace {

/// Where a surface's colour comes from; each has its own variant of the shaders.
enum class Appearance { textured, vertex_colored, unknown };
constexpr std::size_t kAppearances = 3;

struct Program {
  GLuint name = 0;
  GLint clip_from_object = -1;
  GLint camera_from_object = -1;
  GLint shading = -1;
  GLint spread = -1;
};

/// The mesh, or a level of it, as the driver holds it.
struct Geometry {
  GLuint vertex_array = 0;
  std::vector<Batch> batches;
  double deviation = 0;  ///< from the mesh, metres
};

struct MaterialState {
  GLuint texture = 0;        ///< 0: none
  GLuint light_texture = 0;  ///< averaged as light; 0: none
  bool repeat = false;
  double density = 0;  ///< of texture coordinates on the surface, a square metre
};

/// A material's texture averaged as light.
struct LightTexture {
  Texture enlarged;  ///< empty: the texture as it is
  std::vector<Texture> levels;
};

constexpr int kSmallestClass = 64;  // pixels
constexpr double kMostLensBlur = 4;
/// Deviation allowed of what only silhouettes are drawn of, in that of views: their places average over many pixels.
constexpr double kOfSilhouettes = 2;
/// Square pixels that a sharp pixel's samples are spread by: a quarter pixel off the centre, of texels of half a pixel
/// with linear interpolation between them.
constexpr double kSharpVariance = 0.125;

[[noreturn]] void fail(ErrorCode code, const std::string& message) { throw Error(code, "renderer: " + message); }

std::string size_text(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

// Few sizes, so that a small region clears and reads little and still all buffers exist after a few frames.
std::vector<int> size_classes(int maximum) {
  std::vector<int> sizes;
  for (int size = kSmallestClass; size < maximum; size *= 2) {
    sizes.push_back(size);
    if (size / 2 * 3 < maximum) sizes.push_back(size / 2 * 3);
  }
  sizes.push_back(std::max(maximum, kSmallestClass));
  return sizes;
}

std::size_t class_of(const std::vector<int>& sizes, int size) {
  return static_cast<std::size_t>(std::lower_bound(sizes.begin(), sizes.end(), size) - sizes.begin());
}

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

}  // namespace

struct Renderer::Impl {
  Impl(const Mesh& mesh, int max_width, int max_height, const RendererOptions& options);

  DepthRange render(const Pose& T_camera_object, const Camera& camera, const Rect& roi, const RenderTarget& target);
  void set_texture(std::size_t material, const Texture& texture);

  GLuint compile(GLenum kind, const char* file, const std::string& variant) const;
  Program link(const std::string& variant) const;
  GLuint upload_geometry(const std::vector<Vertex>& vertices, const std::vector<std::uint32_t>& indices) const;
  LightTexture light_texture(std::size_t material, const Texture& texture) const;
  void upload_texture(std::size_t material, const Texture& texture, const LightTexture& light);
  /// Into `name`, which is made if it is 0.
  void upload_levels(GLuint& name, const Texture& base, const std::vector<Texture>& levels, bool repeat) const;
  void bind_framebuffer(int width, int height);
  void read(int width, int height, int stride, const RenderTarget& target) const;
  void check_drawing();
  void warm_up();
  void check_errors(const char* action) const;
  Appearance appearance(std::size_t material) const;
  /// The coarsest that deviates by so many metres at most.
  static const Geometry& level_of(const std::vector<Geometry>& levels, double deviation);
  void draw(const Eigen::Matrix4f& clip_from_object, const Pose& T_camera_center, double pixel) const;
  void draw_depth(const Eigen::Matrix4f& clip_from_object, double pixel) const;
  void draw_triangles(const Batch& batch) const;

  std::unique_ptr<GlContext> context;
  const GlFunctions& gl;
  std::string description;
  GLint max_texture_size = 0;
  std::vector<int> widths;
  std::vector<int> heights;
  std::vector<GLuint> framebuffers;  ///< one a pair of size classes, widths first; 0: not made yet
  std::array<Program, kAppearances> programs, lit_programs;
  /// The mesh, then ever coarser levels of it; the same of its shape, for depth alone.
  std::vector<Geometry> geometries, shapes;
  std::vector<MaterialState> materials;
  bool has_texture_coordinates = false;
  bool has_colors = false;
  bool is_closed = false;                 ///< backs of triangles are never seen
  double deviation_pixels = 0;            ///< that a coarser level may cost
  bool lit = false;                       ///< shading is going to be set
  bool light_texels = false;              ///< are what is drawn
  std::optional<LightEncoding> encoding;  ///< of light texels, where they are going to be asked for
  float spread = 1;                       ///< of a pixel's samples, beside that of a sharp one
  double texel_length = 0;                ///< metres that texels may be long where light is interpolated between them
  Eigen::Vector3d center;
  Eigen::Vector3f shading = Eigen::Vector3f::Zero();
  Eigen::Vector3d half_extent;
};

Renderer::Impl::Impl(const Mesh& mesh, int max_width, int max_height, const RendererOptions& options)
    : context(create_gl_context()),
      gl(context->gl()),
      has_texture_coordinates(!mesh.texture_coordinates.empty()),
      has_colors(!mesh.colors.empty()),
      is_closed(is_closed_outward(mesh)),
      deviation_pixels(options.deviation_pixels),
      lit(options.lit) {
  const CurrentGlContext current(*context);
  const auto* renderer = reinterpret_cast<const char*>(gl.get_string(GL_RENDERER));
  const auto* version = reinterpret_cast<const char*>(gl.get_string(GL_VERSION));
  if (renderer == nullptr || version == nullptr) {
    fail(ErrorCode::renderer, "OpenGL calls do not reach OSMesa (no GL_RENDERER); reinstall the package libosmesa6");
  }
  description = std::string(renderer) + ", OpenGL " + version;

  GLint max_size = 0;
  gl.get_integer(GL_MAX_RENDERBUFFER_SIZE, &max_size);
  gl.get_integer(GL_MAX_TEXTURE_SIZE, &max_texture_size);
  if (max_width <= 0 || max_height <= 0 || max_width > max_size || max_height > max_size) {
    fail(ErrorCode::invalid_argument, "the largest region is given as " + size_text(max_width, max_height) +
                                          " pixels; both sides must be in 1 to " + std::to_string(max_size));
  }
  if (options.texture_samples != 1 && options.texture_samples != 4) {
    fail(ErrorCode::invalid_argument,
         "texture_samples is " + std::to_string(options.texture_samples) + "; it must be 1 or 4");
  }
  if (!(deviation_pixels >= 0)) {
    fail(ErrorCode::invalid_argument,
         "deviation_pixels is " + std::to_string(deviation_pixels) + "; it must be 0 or more");
  }
  widths = size_classes(max_width);
  heights = size_classes(max_height);
  framebuffers.resize(widths.size() * heights.size());

  const Eigen::AlignedBox3d box = bounding_box(mesh);
  center = box.center();
  half_extent = box.sizes() / 2;
  materials.resize(mesh.materials.size());
  const std::vector<bool> repeat = repeating_materials(mesh);
  const std::vector<double> density = texture_densities(mesh);
  for (std::size_t i = 0; i < materials.size(); ++i) {
    materials[i].repeat = repeat[i];
    materials[i].density = density[i];
  }
  if (options.light_texels) encoding.emplace();
  // Half a pixel where the object is as large as it is drawn in full.
  texel_length = half_extent.norm() / std::max(max_width, max_height);
  // While shaders are compiled and the mesh is simplified; a thread only where there is something to make.
  const std::launch when = encoding ? std::launch::async : std::launch::deferred;
  std::future<std::vector<LightTexture>> light_textures = std::async(when, [this, &mesh] {
    std::vector<LightTexture> made(materials.size());
    for (std::size_t i = 0; i < made.size(); ++i) made[i] = light_texture(i, mesh.materials[i].texture);
    return made;
  });

  std::future<std::vector<DrawnLevel>> shape_levels =
      std::async(options.silhouettes && deviation_pixels > 0 ? std::launch::async : std::launch::deferred, [&] {
        return deviation_pixels > 0 ? coarser_levels(mesh, MeshAspect::shape, center) : std::vector<DrawnLevel>{};
      });

  const std::string textured = options.texture_samples == 1 ? "TEXTURED" : "TEXTURED\n#define SUPERSAMPLED";
  const auto link_all = [&](const std::string& light) {
    return std::array{link(textured + light), link("VERTEX_COLORED" + light), link("UNKNOWN" + light)};
  };
  programs = link_all("");
  lit_programs = link_all("\n#define SHADED");
  gl.enable(GL_DEPTH_TEST);
  gl.depth_func(GL_LESS);
  gl.disable(GL_DITHER);
  gl.cull_face(GL_BACK);
  gl.front_face(GL_CW);  // rows run downwards (see projection())
  gl.clear_color(0, 0, 0, 0);
  gl.clear_depth(1);
  check_drawing();

  const auto geometry = [&](const DrawnLevel& level) {
    return Geometry{upload_geometry(level.vertices, level.indices), level.batches, level.deviation};
  };
  geometries.push_back(geometry(drawn_mesh(mesh, center)));
  if (deviation_pixels > 0) {
    for (const DrawnLevel& level : coarser_levels(mesh, MeshAspect::appearance, center)) {
      geometries.push_back(geometry(level));
    }
  }
  if (options.silhouettes) {
    shapes.push_back(geometries[0]);
    for (const DrawnLevel& level : shape_levels.get()) shapes.push_back(geometry(level));
  }
  const std::vector<LightTexture> light = light_textures.get();
  for (std::size_t i = 0; has_texture_coordinates && i < materials.size(); ++i) {
    upload_texture(i, mesh.materials[i].texture, light[i]);
  }
  check_errors("uploading the model");
}

GLuint Renderer::Impl::compile(GLenum kind, const char* file, const std::string& variant) const {
  const std::string text =
      std::string("#version 330 core\n#define ") + variant + "\n" + std::string(embedded_text(file));
  const GLuint shader = gl.create_shader(kind);
  const char* source = text.c_str();
  gl.shader_source(shader, 1, &source, nullptr);
  gl.compile_shader(shader);
  GLint compiled = GL_FALSE;
  gl.get_shader(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled != GL_TRUE) {
    std::array<char, 512> log{};
    gl.get_shader_info_log(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
    fail(ErrorCode::renderer, std::string("OSMesa does not compile ") + file + " (" + variant + "): " + log.data() +
                                  "; install libosmesa6 of Mesa 12 or later");
  }
  return shader;
}

Program Renderer::Impl::link(const std::string& variant) const {
  const GLuint vertex_shader = compile(GL_VERTEX_SHADER, "model.vert", variant);
  const GLuint fragment_shader = compile(GL_FRAGMENT_SHADER, "model.frag", variant);
  Program program;
  program.name = gl.create_program();
  gl.attach_shader(program.name, vertex_shader);
  gl.attach_shader(program.name, fragment_shader);
  gl.link_program(program.name);
  gl.delete_shader(vertex_shader);
  gl.delete_shader(fragment_shader);
  GLint linked = GL_FALSE;
  gl.get_program(program.name, GL_LINK_STATUS, &linked);
  if (linked != GL_TRUE) {
    std::array<char, 512> log{};
    gl.get_program_info_log(program.name, static_cast<GLsizei>(log.size()), nullptr, log.data());
    fail(ErrorCode::renderer, std::string("OSMesa does not link the shaders (") + variant + "): " + log.data() +
                                  "; install libosmesa6 of Mesa 12 or later");
  }
  program.clip_from_object = gl.get_uniform_location(program.name, "clip_from_object");
  program.camera_from_object = gl.get_uniform_location(program.name, "camera_from_object");
  program.shading = gl.get_uniform_location(program.name, "shading");
  program.spread = gl.get_uniform_location(program.name, "spread");
  return program;
}

GLuint Renderer::Impl::upload_geometry(const std::vector<Vertex>& vertices,
                                       const std::vector<std::uint32_t>& indices) const {
  GLuint array = 0;
  gl.gen_vertex_arrays(1, &array);
  gl.bind_vertex_array(array);
  std::array<GLuint, 2> buffers{};
  gl.gen_buffers(2, buffers.data());
  gl.bind_buffer(GL_ARRAY_BUFFER, buffers[0]);
  gl.buffer_data(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)), vertices.data(),
                 GL_STATIC_DRAW);
  gl.bind_buffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
  gl.buffer_data(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size() * sizeof(std::uint32_t)),
                 indices.data(), GL_STATIC_DRAW);
  const auto attribute = [this](GLuint location, GLint count, GLenum type, GLboolean normalized, std::size_t offset) {
    gl.enable_vertex_attrib_array(location);
    gl.vertex_attrib_pointer(location, count, type, normalized, sizeof(Vertex), reinterpret_cast<const void*>(offset));
  };
  attribute(0, 3, GL_FLOAT, GL_FALSE, offsetof(Vertex, position));
  attribute(1, 2, GL_FLOAT, GL_FALSE, offsetof(Vertex, texture_coordinate));
  attribute(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(Vertex, color));
  return array;
}

LightTexture Renderer::Impl::light_texture(std::size_t material, const Texture& texture) const {
  if (!encoding || !has_texture_coordinates || texture.empty()) return {};
  const MaterialState& state = materials[material];
  const int times = enlargement(texture, state.density, texel_length, max_texture_size);
  LightTexture light;
  if (times > 1) light.enlarged = enlarged(texture, times, state.repeat, *encoding);
  light.levels = light_levels(times > 1 ? light.enlarged : texture, state.repeat, *encoding);
  return light;
}

void Renderer::Impl::upload_texture(std::size_t material, const Texture& texture, const LightTexture& light) {
  MaterialState& state = materials[material];
  if (texture.empty()) {
    gl.delete_textures(1, &state.texture);
    gl.delete_textures(1, &state.light_texture);
    state.texture = state.light_texture = 0;
    return;
  }
  if (texture.width > max_texture_size || texture.height > max_texture_size) {
    fail(ErrorCode::model, "the texture of material " + std::to_string(material) + " is " +
                               size_text(texture.width, texture.height) + " pixels, OSMesa takes at most " +
                               std::to_string(max_texture_size) + "; make it smaller");
  }
  upload_levels(state.texture, texture, texture_levels(texture), state.repeat);
  if (encoding) {
    upload_levels(state.light_texture, light.enlarged.empty() ? texture : light.enlarged, light.levels, state.repeat);
  }
  if (gl.get_error() != GL_NO_ERROR) {
    fail(ErrorCode::model, "OSMesa has no room for the texture of material " + std::to_string(material) + " (" +
                               size_text(texture.width, texture.height) + " pixels); make it smaller");
  }
}

void Renderer::Impl::upload_levels(GLuint& name, const Texture& base, const std::vector<Texture>& levels,
                                   bool repeat) const {
  if (name == 0) gl.gen_textures(1, &name);
  gl.bind_texture(GL_TEXTURE_2D, name);
  const GLint wrap = repeat ? GL_REPEAT : GL_CLAMP_TO_EDGE;
  gl.texture_parameter(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap);
  gl.texture_parameter(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap);
  gl.texture_parameter(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl.texture_parameter(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
  gl.texture_parameter(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, static_cast<GLint>(levels.size()));
  const auto upload = [this](GLint level, const Texture& image) {
    gl.texture_image_2d(GL_TEXTURE_2D, level, GL_RGBA8, image.width, image.height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                        image.rgba.data());
  };
  upload(0, base);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    upload(static_cast<GLint>(i) + 1, levels[i]);
  }
}

void Renderer::Impl::bind_framebuffer(int width, int height) {
  const std::size_t column = class_of(widths, width);
  const std::size_t row = class_of(heights, height);
  GLuint& framebuffer = framebuffers[row * widths.size() + column];
  if (framebuffer != 0) {
    gl.bind_framebuffer(GL_FRAMEBUFFER, framebuffer);
    return;
  }
  gl.gen_framebuffers(1, &framebuffer);
  gl.bind_framebuffer(GL_FRAMEBUFFER, framebuffer);
  const auto attach = [&](GLenum attachment, GLenum format) {
    GLuint buffer = 0;
    gl.gen_renderbuffers(1, &buffer);
    gl.bind_renderbuffer(GL_RENDERBUFFER, buffer);
    gl.renderbuffer_storage(GL_RENDERBUFFER, format, widths[column], heights[row]);
    gl.framebuffer_renderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer);
  };
  attach(GL_COLOR_ATTACHMENT0, GL_RGBA8);
  attach(GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F);
  if (gl.check_framebuffer_status(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    framebuffer = 0;
    fail(ErrorCode::renderer, "OSMesa cannot make a framebuffer of " + size_text(widths[column], heights[row]) +
                                  " pixels with float depth; install libosmesa6 with the llvmpipe driver");
  }
}

void Renderer::Impl::read(int width, int height, int stride, const RenderTarget& target) const {
  gl.pixel_store(GL_PACK_ROW_LENGTH, stride);
  if (target.rgba != nullptr) {
    gl.read_pixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, target.rgba);
  }
  if (target.depth != nullptr) {
    gl.read_pixels(0, 0, width, height, GL_DEPTH_COMPONENT, GL_FLOAT, target.depth);
  }
}

void Renderer::Impl::check_errors(const char* action) const {
  const GLenum code = gl.get_error();
  if (code != GL_NO_ERROR) {
    fail(ErrorCode::renderer, std::string("OpenGL error ") + std::to_string(code) + " while " + action +
                                  (code == GL_OUT_OF_MEMORY ? " (out of memory)" : "") + "; renderer: " + description);
  }
}

// OpenGL calls that end in the wrong library do nothing and report nothing: draw a triangle over the upper left half
// and look whether it is there.
void Renderer::Impl::check_drawing() {
  const std::array<std::uint8_t, 4> color = {255, 128, 0, 255};
  bind_framebuffer(kSmallestClass, kSmallestClass);
  gl.viewport(0, 0, kSmallestClass, kSmallestClass);
  gl.clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  upload_geometry({{{-1, -1, 0}, {}, color}, {{1, -1, 0}, {}, color}, {{-1, 1, 0}, {}, color}}, {0, 1, 2});
  const Program& program = programs[static_cast<std::size_t>(Appearance::vertex_colored)];
  const Eigen::Matrix4f identity = Eigen::Matrix4f::Identity();
  gl.use_program(program.name);
  gl.uniform_matrix4(program.clip_from_object, 1, GL_FALSE, identity.data());
  gl.draw_elements(GL_TRIANGLES, 3, GL_UNSIGNED_INT, nullptr);

  constexpr std::size_t kPixels = kSmallestClass * kSmallestClass;
  std::vector<std::uint8_t> rgba(kPixels * 4, 99);
  std::vector<float> depth(kPixels, -1.0F);
  read(kSmallestClass, kSmallestClass, kSmallestClass, {rgba.data(), depth.data(), kSmallestClass});
  const bool drawn = std::equal(color.begin(), color.end(), rgba.begin()) && depth.front() == 0.5F;
  const bool empty = rgba.back() == 0 && depth.back() == 1.0F;
  if (!drawn || !empty) {
    fail(ErrorCode::renderer, "OSMesa does not draw (a test triangle did not come out; renderer: " + description +
                                  "); another OpenGL library may be in its way, reinstall the package libosmesa6");
  }
}

// The driver compiles its code for a material at the first draw: here, not in somebody's first frame.
void Renderer::Impl::warm_up() {
  std::vector<std::uint8_t> rgba(std::size_t{kSmallestClass} * kSmallestClass * 4);
  std::vector<float> depth(std::size_t{kSmallestClass} * kSmallestClass);
  Camera camera{kSmallestClass, kSmallestClass, kSmallestClass, kSmallestClass, 0, 0, {}};
  camera.cx = camera.cy = (kSmallestClass - 1) / 2.0;
  Pose T_camera_object = Pose::Identity();
  T_camera_object.translation() = Eigen::Vector3d(0, 0, 4 * half_extent.norm()) - center;
  const auto draw = [&] {
    render(T_camera_object, camera, {0, 0, kSmallestClass, kSmallestClass},
           {rgba.data(), depth.data(), kSmallestClass});
  };
  draw();
  render(T_camera_object, camera, {0, 0, kSmallestClass, kSmallestClass}, {nullptr, depth.data(), kSmallestClass});
  if (encoding) {
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
  if (material < materials.size() && materials[material].texture != 0) {
    return Appearance::textured;
  }
  return has_colors ? Appearance::vertex_colored : Appearance::unknown;
}

const Geometry& Renderer::Impl::level_of(const std::vector<Geometry>& levels, double deviation) {
  std::size_t level = 0;
  while (level + 1 < levels.size() && levels[level + 1].deviation <= deviation) ++level;
  return levels[level];
}

void Renderer::Impl::draw(const Eigen::Matrix4f& clip_from_object, const Pose& T_camera_center, double pixel) const {
  gl.clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  const Geometry& geometry = level_of(geometries, deviation_pixels * pixel);
  gl.bind_vertex_array(geometry.vertex_array);
  const Eigen::Matrix4f camera_from_object = T_camera_center.matrix().cast<float>();
  const bool shaded = !shading.isZero();
  for (const Batch& batch : geometry.batches) {
    const Appearance look = appearance(batch.material);
    const Program& program = (shaded ? lit_programs : programs)[static_cast<std::size_t>(look)];
    gl.use_program(program.name);
    gl.uniform_matrix4(program.clip_from_object, 1, GL_FALSE, clip_from_object.data());
    if (shaded) {
      gl.uniform_matrix4(program.camera_from_object, 1, GL_FALSE, camera_from_object.data());
      gl.uniform3(program.shading, 1, shading.data());
    }
    if (look == Appearance::textured) {
      gl.uniform1(program.spread, spread);
      const MaterialState& material = materials[batch.material];
      gl.bind_texture(GL_TEXTURE_2D, light_texels ? material.light_texture : material.texture);
    }
    draw_triangles(batch);
  }
}

void Renderer::Impl::draw_depth(const Eigen::Matrix4f& clip_from_object, double pixel) const {
  gl.clear(GL_DEPTH_BUFFER_BIT);
  const Geometry& geometry = shapes.empty() ? level_of(geometries, deviation_pixels * pixel)
                                            : level_of(shapes, kOfSilhouettes * deviation_pixels * pixel);
  gl.bind_vertex_array(geometry.vertex_array);
  const Program& program = programs[static_cast<std::size_t>(Appearance::unknown)];
  gl.use_program(program.name);
  gl.uniform_matrix4(program.clip_from_object, 1, GL_FALSE, clip_from_object.data());
  gl.color_mask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  for (const Batch& batch : geometry.batches) draw_triangles(batch);
  gl.color_mask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

void Renderer::Impl::draw_triangles(const Batch& batch) const {
  gl.draw_elements(GL_TRIANGLES, batch.index_count, GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(batch.first_index * sizeof(std::uint32_t)));
}

DepthRange Renderer::Impl::render(const Pose& T_camera_object, const Camera& camera, const Rect& roi,
                                  const RenderTarget& target) {
  const int stride = target.stride == 0 ? roi.width : target.stride;
  if (roi.empty() || roi.width > widths.back() || roi.height > heights.back() || stride < roi.width) {
    fail(ErrorCode::invalid_argument, "a region of " + size_text(roi.width, roi.height) + " pixels with a stride of " +
                                          std::to_string(stride) + " was asked for; it must fit in " +
                                          size_text(widths.back(), heights.back()) + " and in the stride");
  }
  if (!T_camera_object.matrix().allFinite()) {
    fail(ErrorCode::pose, "the pose holds NaN or infinity; give a rigid motion");
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
  bind_framebuffer(roi.width, roi.height);
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
  read(roi.width, roi.height, stride, target);
  check_errors("rendering");
  return range;
}

void Renderer::Impl::set_texture(std::size_t material, const Texture& texture) {
  if (material >= materials.size()) {
    fail(ErrorCode::invalid_argument,
         "there is no material " + std::to_string(material) + "; the model has " + std::to_string(materials.size()));
  }
  if (!has_texture_coordinates) {
    fail(ErrorCode::invalid_argument,
         "the model has no texture coordinates, so it cannot be given a texture; unwrap it");
  }
  const bool sized = texture.width > 0 && texture.height > 0;
  const std::size_t bytes = sized ? static_cast<std::size_t>(texture.width) * texture.height * 4 : 0;
  if (!texture.empty() && texture.rgba.size() != bytes) {
    fail(ErrorCode::invalid_argument, "a texture of " + size_text(texture.width, texture.height) + " pixels holds " +
                                          std::to_string(texture.rgba.size()) +
                                          " bytes; give width * height * 4 bytes of RGBA");
  }
  {
    const CurrentGlContext current(*context);
    upload_texture(material, texture, light_texture(material, texture));
  }
  warm_up();
}

Renderer::Renderer(const Mesh& mesh, int max_width, int max_height, const RendererOptions& options) {
  mesh.validate();
  impl_ = std::make_unique<Impl>(mesh, max_width, max_height, options);
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
    fail(ErrorCode::invalid_argument, "the shading's direction must be shorter than 1");
  }
  impl_->shading = shading.cast<float>();
}

void Renderer::set_lens_blur(double sigma) {
  if (!(sigma >= 0 && sigma <= kMostLensBlur)) {
    fail(ErrorCode::invalid_argument, "the lens blurs by " + std::to_string(sigma) + " pixels; it must be in [0, " +
                                          std::to_string(kMostLensBlur) + "]");
  }
  impl_->spread = static_cast<float>(std::sqrt(1 + sigma * sigma / kSharpVariance));
}

void Renderer::set_light_texels(bool light) {
  if (light && !impl_->encoding) {
    fail(ErrorCode::invalid_argument, "light texels are asked for, but the option light_texels was not given");
  }
  impl_->light_texels = light;
}

std::string Renderer::description() const { return impl_->description; }

}  // namespace holdfast
