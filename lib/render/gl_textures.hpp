#pragma once

#include <cstddef>
#include <vector>

#include "holdfast/mesh.hpp"
#include "render/gl_functions.hpp"

namespace holdfast {

/// The textures of a mesh's materials.
class GlTextures {
 public:
  /// The mesh's textures become the materials'. Throws Error(model) for one larger than OpenGL takes.
  GlTextures(const GlFunctions& gl, const Mesh& mesh);

  /// The texture becomes the material's; empty: it has none. Throws Error(invalid_argument) for one that it cannot be
  /// given, else as the constructor does.
  void replace(std::size_t material, const Texture& texture);

  bool has_texture(std::size_t material) const {
    return material < materials_.size() && materials_[material].texture != 0;
  }
  /// The material's texture is what is drawn with from now on; it must have one.
  void bind(std::size_t material) const;

 private:
  struct MaterialState {
    GLuint texture = 0;  ///< 0: none
    bool repeat = false;
  };

  void upload(std::size_t material, const Texture& texture);

  const GlFunctions& gl_;
  GLint max_size_ = 0;
  std::vector<MaterialState> materials_;
  bool has_coordinates_;
};

}  // namespace holdfast
