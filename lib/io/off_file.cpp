#include "io/off_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/color_range.hpp"
#include "io/mesh_assembly.hpp"
#include "io/model_fault.hpp"
#include "io/numbers.hpp"
#include "io/polygon.hpp"
#include "io/text_file.hpp"

namespace holdfast::io {
namespace {

namespace fs = std::filesystem;
using Color = std::array<std::uint8_t, 4>;

/// The values of each vertex's line, by what the first line of the file names.
struct Layout {
  bool normals = false;
  bool colors = false;
  bool coordinates = false;
};

class OffReader {
 public:
  OffReader(const fs::path& path, double scale, std::vector<std::string>& remarks)
      : path_(path), scale_(scale), remarks_(remarks), bytes_(read_text_file(path, "model")), rest_(bytes_) {}

  Mesh read() {
    const Layout layout = read_layout();
    std::vector<double> counts = next_numbers();
    if (counts.size() < 2) {
      fail("its counts of vertices and faces are missing");
    }
    const std::size_t vertices = count(counts[0], "vertices"), faces = count(counts[1], "faces");
    find_range(layout, vertices, faces);
    for (std::size_t i = 0; i < vertices; ++i) add_vertex(layout, i);
    if (has_more_) {
      remarks_.push_back(fmt::format(
          "model '{}' has more numbers for a vertex than its first line says, which are not read: for colours "
          "write COFF there instead of OFF",
          path_.string()));
    }
    MeshAssembly assembly(false, true);
    bool colored = layout.colors;
    for (std::size_t i = 0; i < faces; ++i) colored = add_face(assembly, i) || colored;
    Mesh mesh = assembly.take();
    if (!colored) mesh.colors.clear();
    return mesh;
  }

 private:
  template <class... Advice>
  [[noreturn]] void fail(const std::string& reason, const Advice&... advice) const {
    fail_model(path_, reason, advice...);
  }

  /// The next line that holds anything but a comment; empty at the end.
  std::string_view content() {
    for (std::string_view line; next_line(rest_, line);) {
      line = trimmed(line.substr(0, line.find('#')));
      if (!line.empty()) return line;
    }
    return {};
  }

  Layout read_layout() {
    Layout layout;
    const std::string_view before = rest_;
    std::string_view line = content();
    std::string_view word = next_word(line);
    if (!word.ends_with("OFF")) {
      rest_ = before;  // the word is optional
      return layout;
    }
    word.remove_suffix(3);
    if (word.find_first_not_of("STCN") != word.npos) {
      fail(fmt::format("'{}OFF' is a kind of OFF that is not supported", word), "export OFF or COFF");
    }
    layout.coordinates = word.starts_with("ST");
    layout.colors = word.find('C') != word.npos;
    layout.normals = word.find('N') != word.npos;
    if (trimmed(line).starts_with("BINARY")) fail("binary OFF is not supported", "export it as text");
    if (!trimmed(line).empty())
      rest_ = {line.data(), static_cast<std::size_t>(bytes_.data() + bytes_.size() - line.data())};
    return layout;
  }

  std::vector<double> next_numbers() {
    std::string_view line = content();
    std::vector<double> numbers;
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
      const std::optional<double> number = parse_number(word);
      if (!number) fail(fmt::format("'{}' is not a number", word.substr(0, 20)), advice_on_number(word));
      numbers.push_back(*number);
    }
    if (numbers.empty()) fail("it ends early");
    return numbers;
  }

  std::size_t count(double value, const char* what) const {
    if (!(value >= 0 && value <= static_cast<double>(bytes_.size()))) {  // each takes a byte at least
      fail(fmt::format("its {} {} are not possible in {} bytes", value, what, bytes_.size()));
    }
    return static_cast<std::size_t>(value);
  }

  /// The colour in a vertex's line; empty where the file has none.
  std::span<const double> color_of_vertex(const Layout& layout, std::span<const double> values, std::size_t index) {
    const std::size_t colors_at = layout.normals ? 6 : 3;
    if (values.size() < colors_at + (layout.colors ? 3 : 0)) {
      fail(fmt::format("vertex {} has {} numbers", index, values.size()));
    }
    if (!layout.colors) {
      has_more_ = has_more_ || values.size() > colors_at + (layout.coordinates ? 2 : 0);
      return {};
    }
    const std::size_t left = values.size() - colors_at - (layout.coordinates && values.size() > colors_at + 4 ? 2 : 0);
    return values.subspan(colors_at, std::min<std::size_t>(left, 4));
  }

  /// The colour in a face's line; empty where it has none.
  std::span<const double> color_of_face(std::span<const double> values, std::size_t index) {
    if (!(values[0] >= 0 && values[0] < static_cast<double>(values.size()))) {
      fail(fmt::format("face {} has {} of its {} corners", index, values.size() - 1, values[0]));
    }
    const std::span<const double> left = values.subspan(1 + static_cast<std::size_t>(values[0]));
    return left.size() == 3 || left.size() == 4 ? left : std::span<const double>();
  }

  /// Looks ahead for how colours stand in this file.
  void find_range(const Layout& layout, std::size_t vertices, std::size_t faces) {
    const std::string_view before = rest_;
    const auto note = [](std::span<const double> color, ColorRange& range) {
      for (std::size_t i = 0; i < color.size(); ++i) range.note(i, color[i]);
    };
    for (std::size_t i = 0; i < vertices; ++i) note(color_of_vertex(layout, next_numbers(), i), of_vertices_);
    for (std::size_t i = 0; i < faces; ++i) note(color_of_face(next_numbers(), i), of_faces_);
    rest_ = before;
  }

  static Color color(std::span<const double> values, const ColorRange& range) {
    Color color{0, 0, 0, 255};
    for (std::size_t i = 0; i < values.size(); ++i) color[i] = color_byte(values[i], range.full(i));
    return color;
  }

  void add_vertex(const Layout& layout, std::size_t index) {
    const std::vector<double> values = next_numbers();
    const std::span<const double> own = color_of_vertex(layout, values, index);
    Vertex vertex;
    for (int axis = 0; axis < 3; ++axis) {
      vertex.position[axis] = static_cast<float>(values[static_cast<std::size_t>(axis)] * scale_);
    }
    if (!own.empty()) vertex.color = color(own, of_vertices_);
    vertices_.push_back(vertex);
  }

  /// Whether the face has a colour of its own.
  bool add_face(MeshAssembly& assembly, std::size_t index) {
    const std::vector<double> values = next_numbers();
    const std::span<const double> own = color_of_face(values, index);
    const auto corners = static_cast<std::size_t>(values[0]);
    std::vector<Vertex> polygon;
    std::vector<Eigen::Vector3f> positions;
    for (std::size_t i = 1; i <= corners; ++i) {
      if (!(values[i] >= 0 && values[i] < static_cast<double>(vertices_.size()))) {
        fail(fmt::format("face {} refers to vertex {}, but there are {}", index, values[i], vertices_.size()),
             kExportAnew);
      }
      polygon.push_back(vertices_[static_cast<std::size_t>(values[i])]);
      if (!own.empty()) polygon.back().color = color(own, of_faces_);
      positions.push_back(polygon.back().position);
    }
    for (const auto& [a, b, c] : triangles_of_polygon(positions)) {
      assembly.add_triangle({polygon[a], polygon[b], polygon[c]}, 0);
    }
    return !own.empty();
  }

  const fs::path& path_;
  double scale_;
  std::vector<std::string>& remarks_;
  std::string bytes_;
  std::string_view rest_;
  ColorRange of_vertices_, of_faces_;
  bool has_more_ = false;  ///< a vertex than it is to have
  std::vector<Vertex> vertices_;
};

}  // namespace

Mesh load_off(const fs::path& path, double scale, std::vector<std::string>& remarks) {
  return OffReader(path, scale, remarks).read();
}

}  // namespace holdfast::io
