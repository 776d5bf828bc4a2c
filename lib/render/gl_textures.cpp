#include "render/gl_textures.hpp"

#include <string>

#include "render/drawn_levels.hpp"
#include "render/enlarged_texture.hpp"
#include "render/mip_levels.hpp"
#include "render/renderer_error.hpp"

namespace holdfast {

GlTextures::GlTextures(const GlFunctions& gl, const Mesh& mesh, bool light, double texel_length)
    : gl_(gl),
      materials_(mesh.materials.size()),
      has_coordinates_(!mesh.texture_coordinates.empty()),
      texel_length_(texel_length) {
  gl.get_integer(GL_MAX_TEXTURE_SIZE, &max_size_);
  const std::vector<bool> repeat = repeating_materials(mesh);
  const std::vector<double> density = texture_densities(mesh);
  for (std::size_t i = 0; i < materials_.size(); ++i) {
    materials_[i].repeat = repeat[i];
    materials_[i].density = density[i];
  }
  if (light) encoding_.emplace();
}

std::vector<LightTexture> GlTextures::light_textures(const Mesh& mesh) const {
  std::vector<LightTexture> made(materials_.size());
  for (std::size_t i = 0; i < made.size(); ++i) made[i] = light_texture(i, mesh.materials[i].texture);
  return made;
}

void GlTextures::upload(const Mesh& mesh, std::future<std::vector<LightTexture>> light) {
  if (!has_coordinates_) return;
  for (std::size_t i = 0; i < materials_.size(); ++i) upload_texture(i, mesh.materials[i].texture);
  const std::vector<LightTexture> made = light.get();
  for (std::size_t i = 0; i < materials_.size(); ++i) upload_light(i, mesh.materials[i].texture, made[i]);
}

void GlTextures::replace(std::size_t material, const Texture& texture) {
  if (material >= materials_.size()) {
    fail_rendering(ErrorCode::invalid_argument, "there is no material " + std::to_string(material) +
                                                    "; the model has " + std::to_string(materials_.size()));
  }
  if (!has_coordinates_) {
    fail_rendering(ErrorCode::invalid_argument,
                   "the model has no texture coordinates, so it cannot be given a texture; unwrap it");
  }
  const bool sized = texture.width > 0 && texture.height > 0;
  const std::size_t bytes = sized ? static_cast<std::size_t>(texture.width) * texture.height * 4 : 0;
  if (!texture.empty() && texture.rgba.size() != bytes) {
    fail_rendering(ErrorCode::invalid_argument, "a texture of " + size_text(texture.width, texture.height) +
                                                    " pixels holds " + std::to_string(texture.rgba.size()) +
                                                    " bytes; give width * height * 4 bytes of RGBA");
  }
  upload_texture(material, texture);
  upload_light(material, texture, light_texture(material, texture));
}

void GlTextures::bind(std::size_t material, bool light) const {
  const MaterialState& state = materials_[material];
  gl_.bind_texture(GL_TEXTURE_2D, light ? state.light_texture : state.texture);
}

LightTexture GlTextures::light_texture(std::size_t material, const Texture& texture) const {
  if (!encoding_ || !has_coordinates_ || texture.empty()) return {};
  const MaterialState& state = materials_[material];
  const int times = enlargement(texture, state.density, texel_length_, max_size_);
  LightTexture light;
  if (times > 1) light.enlarged = enlarged(texture, times, state.repeat, *encoding_);
  light.levels = light_levels(times > 1 ? light.enlarged : texture, state.repeat, *encoding_);
  return light;
}

void GlTextures::upload_texture(std::size_t material, const Texture& texture) {
  MaterialState& state = materials_[material];
  if (texture.empty()) {
    gl_.delete_textures(1, &state.texture);
    gl_.delete_textures(1, &state.light_texture);
    state.texture = state.light_texture = 0;
    return;
  }
  if (texture.width > max_size_ || texture.height > max_size_) {
    fail_rendering(ErrorCode::model, "the texture of material " + std::to_string(material) + " is " +
                                         size_text(texture.width, texture.height) + " pixels, OpenGL takes at most " +
                                         std::to_string(max_size_) + "; make it smaller");
  }
  upload_levels(state.texture, texture, texture_levels(texture), state.repeat);
  check_room(material, texture);
}

void GlTextures::upload_light(std::size_t material, const Texture& texture, const LightTexture& light) {
  MaterialState& state = materials_[material];
  if (!encoding_ || texture.empty()) return;
  upload_levels(state.light_texture, light.enlarged.empty() ? texture : light.enlarged, light.levels, state.repeat);
  check_room(material, texture);
}

void GlTextures::check_room(std::size_t material, const Texture& texture) const {
  if (gl_.get_error() == GL_NO_ERROR) return;
  fail_rendering(ErrorCode::model, "OpenGL has no room for the texture of material " + std::to_string(material) + " (" +
                                       size_text(texture.width, texture.height) + " pixels); make it smaller");
}

void GlTextures::upload_levels(GLuint& name, const Texture& base, const std::vector<Texture>& levels,
                               bool repeat) const {
  if (name == 0) gl_.gen_textures(1, &name);
  gl_.bind_texture(GL_TEXTURE_2D, name);
  const GLint wrap = repeat ? GL_REPEAT : GL_CLAMP_TO_EDGE;
  gl_.texture_parameter(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap);
  gl_.texture_parameter(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap);
  gl_.texture_parameter(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl_.texture_parameter(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
  gl_.texture_parameter(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, static_cast<GLint>(levels.size()));
  const auto put = [this](GLint level, const Texture& image) {
    gl_.texture_image_2d(GL_TEXTURE_2D, level, GL_RGBA8, image.width, image.height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                         image.rgba.data());
  };
  put(0, base);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    put(static_cast<GLint>(i) + 1, levels[i]);
  }
}

}  // namespace holdfast
