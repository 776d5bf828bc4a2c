#include "render/gl_geometry.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace holdfast {
namespace {

/// Deviation allowed of what only silhouettes are drawn of, in that of views: their places average over many pixels.
constexpr double kOfSilhouettes = 2;

const Geometry& level_of(const std::vector<Geometry>& levels, double deviation) {
  std::size_t level = 0;
  while (level + 1 < levels.size() && levels[level + 1].deviation <= deviation) ++level;
  return levels[level];
}

}  // namespace

Geometry upload_geometry(const GlFunctions& gl, const DrawnLevel& level) {
  GLuint array = 0;
  gl.gen_vertex_arrays(1, &array);
  gl.bind_vertex_array(array);
  std::array<GLuint, 2> buffers{};
  gl.gen_buffers(2, buffers.data());
  gl.bind_buffer(GL_ARRAY_BUFFER, buffers[0]);
  gl.buffer_data(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(level.vertices.size() * sizeof(Vertex)),
                 level.vertices.data(), GL_STATIC_DRAW);
  gl.bind_buffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
  gl.buffer_data(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(level.indices.size() * sizeof(std::uint32_t)),
                 level.indices.data(), GL_STATIC_DRAW);
  const auto attribute = [&](GLuint location, GLint count, GLenum type, GLboolean normalized, std::size_t offset) {
    gl.enable_vertex_attrib_array(location);
    gl.vertex_attrib_pointer(location, count, type, normalized, sizeof(Vertex), reinterpret_cast<const void*>(offset));
  };
  attribute(0, 3, GL_FLOAT, GL_FALSE, offsetof(Vertex, position));
  attribute(1, 2, GL_FLOAT, GL_FALSE, offsetof(Vertex, texture_coordinate));
  attribute(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(Vertex, color));
  return {array, level.batches, level.deviation};
}

void draw_triangles(const GlFunctions& gl, const Batch& batch) {
  gl.draw_elements(GL_TRIANGLES, batch.index_count, GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(batch.first_index * sizeof(std::uint32_t)));
}

GlGeometry::GlGeometry(const GlFunctions& gl, const std::vector<DrawnLevel>& levels,
                       const std::optional<std::vector<DrawnLevel>>& shapes) {
  for (const DrawnLevel& level : levels) levels_.push_back(upload_geometry(gl, level));
  if (!shapes) return;
  shapes_.push_back(levels_.front());
  for (const DrawnLevel& level : *shapes) shapes_.push_back(upload_geometry(gl, level));
}

const Geometry& GlGeometry::view(double deviation) const { return level_of(levels_, deviation); }

const Geometry& GlGeometry::silhouette(double deviation) const {
  return shapes_.empty() ? view(deviation) : level_of(shapes_, kOfSilhouettes * deviation);
}

}  // namespace holdfast
