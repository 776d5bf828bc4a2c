#pragma once

#include <cstddef>
#include <future>
#include <optional>
#include <vector>

#include "base/light_encoding.hpp"
#include "holdfast/mesh.hpp"
#include "render/gl_functions.hpp"

namespace holdfast {

/// A material's texture averaged as light.
struct LightTexture {
  Texture enlarged;  ///< empty: the texture as it is
  std::vector<Texture> levels;
};

/// The textures of a mesh's materials, each as it is and, where that is going to be asked for, averaged as light.
class GlTextures {
 public:
  /// No material has a texture yet. `light`: they are averaged as light too, with texels of `texel_length` metres at
  /// most, where memory allows, since between them light is interpolated.
  GlTextures(const GlFunctions& gl, const Mesh& mesh, bool light, double texel_length);

  /// Whether they are averaged as light too.
  bool has_light() const { return encoding_.has_value(); }

  /// What upload() takes besides the mesh: takes long and needs no context, so another thread may make it, also
  /// while upload() sends the textures as they are.
  std::vector<LightTexture> light_textures(const Mesh& mesh) const;
  /// The mesh's textures become the materials', `light` once it is there. Throws Error(model) for one larger than
  /// OpenGL takes.
  void upload(const Mesh& mesh, std::future<std::vector<LightTexture>> light);

  /// The texture becomes the material's; empty: it has none. Throws Error(invalid_argument) for one that it cannot be
  /// given, else as upload() does.
  void replace(std::size_t material, const Texture& texture);

  bool has_texture(std::size_t material) const {
    return material < materials_.size() && materials_[material].texture != 0;
  }
  /// The material's texture is what is drawn with from now on; it must have one.
  void bind(std::size_t material, bool light) const;

 private:
  struct MaterialState {
    GLuint texture = 0;        ///< 0: none
    GLuint light_texture = 0;  ///< averaged as light; 0: none
    bool repeat = false;
    double density = 0;  ///< of texture coordinates on the surface, a square metre
  };

  LightTexture light_texture(std::size_t material, const Texture& texture) const;
  void upload_texture(std::size_t material, const Texture& texture);
  /// After upload_texture().
  void upload_light(std::size_t material, const Texture& texture, const LightTexture& light);
  void check_room(std::size_t material, const Texture& texture) const;
  /// Into `name`, which is made if it is 0.
  void upload_levels(GLuint& name, const Texture& base, const std::vector<Texture>& levels, bool repeat) const;

  const GlFunctions& gl_;
  GLint max_size_ = 0;
  std::vector<MaterialState> materials_;
  bool has_coordinates_;
  double texel_length_;
  std::optional<LightEncoding> encoding_;  ///< where they are averaged as light too
};

}  // namespace holdfast
