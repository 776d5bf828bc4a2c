#include "render/gl_textures.hpp"

#include <string>

#include "render/drawn_levels.hpp"
#include "render/mip_levels.hpp"
#include "render/renderer_error.hpp"

namespace holdfast {

GlTextures::GlTextures(const GlFunctions& gl, const Mesh& mesh)
    : gl_(gl), materials_(mesh.materials.size()), has_coordinates_(!mesh.texture_coordinates.empty()) {
  gl.get_integer(GL_MAX_TEXTURE_SIZE, &max_size_);
  if (!has_coordinates_) return;
  const std::vector<bool> repeat = repeating_materials(mesh);
  for (std::size_t i = 0; i < materials_.size(); ++i) {
    materials_[i].repeat = repeat[i];
    upload(i, mesh.materials[i].texture);
  }
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
  upload(material, texture);
}

void GlTextures::bind(std::size_t material) const { gl_.bind_texture(GL_TEXTURE_2D, materials_[material].texture); }

void GlTextures::upload(std::size_t material, const Texture& texture) {
  MaterialState& state = materials_[material];
  if (texture.empty()) {
    gl_.delete_textures(1, &state.texture);
    state.texture = 0;
    return;
  }
  const std::string name = "the texture of material " + std::to_string(material) + " (" +
                           size_text(texture.width, texture.height) + " pixels)";
  if (texture.width > max_size_ || texture.height > max_size_) {
    fail_rendering(ErrorCode::model, name + " is too large: OpenGL takes at most " + std::to_string(max_size_) +
                                         " pixels a side; make it smaller");
  }
  if (state.texture == 0) gl_.gen_textures(1, &state.texture);
  gl_.bind_texture(GL_TEXTURE_2D, state.texture);
  const GLint wrap = state.repeat ? GL_REPEAT : GL_CLAMP_TO_EDGE;
  const std::vector<Texture> levels = texture_levels(texture);
  gl_.texture_parameter(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap);
  gl_.texture_parameter(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap);
  gl_.texture_parameter(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl_.texture_parameter(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
  gl_.texture_parameter(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, static_cast<GLint>(levels.size()));
  const auto put = [this](GLint level, const Texture& image) {
    gl_.texture_image_2d(GL_TEXTURE_2D, level, GL_RGBA8, image.width, image.height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                         image.rgba.data());
  };
  put(0, texture);
  for (std::size_t i = 0; i < levels.size(); ++i) put(static_cast<GLint>(i) + 1, levels[i]);
  if (gl_.get_error() != GL_NO_ERROR) {
    fail_rendering(ErrorCode::model, "OpenGL has no room for " + name + "; make it smaller");
  }
}

}  // namespace holdfast
