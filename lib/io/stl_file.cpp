#include "io/stl_file.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/mesh_assembly.hpp"
#include "io/model_fault.hpp"
#include "io/numbers.hpp"
#include "io/polygon.hpp"
#include "io/text_file.hpp"

namespace holdfast::io {
namespace {

namespace fs = std::filesystem;
using Color = std::array<std::uint8_t, 4>;

constexpr std::size_t kHeader = 80, kBegin = 84;  // of a binary file: words, then the count of facets
constexpr std::size_t kFacet = 50;                // bytes: normal, three corners, attribute
constexpr std::uint32_t kBit = 0x8000;            // of the attribute
constexpr Color kGrey{153, 153, 153, 255};        // of facets without a colour beside others with one

std::uint32_t little_endian(std::string_view bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

std::string lower_word(std::string_view& line) { return lower(next_word(line)); }

class StlReader {
 public:
  StlReader(const fs::path& path, double scale)
      : path_(path), scale_(scale), bytes_(read_binary_file(path, "model")), text_(bytes_) {}

  Mesh read() {
    const std::uint64_t facets = text_.size() < kBegin ? 0 : little_endian(text_.substr(kHeader, 4));
    const std::uint64_t whole = kBegin + kFacet * facets;
    // Binary files may begin with "solid" too, and have more behind the facets. Of a text the count, in letters, is of
    // more facets than any file holds.
    const bool is_text = text_.size() < whole && begins_as_text();
    if (is_text) return read_text();
    if (text_.size() < whole) fail(fmt::format("it has {} of {} bytes", text_.size(), whole));
    return read_binary(static_cast<std::size_t>(facets));
  }

 private:
  template <class... Advice>
  [[noreturn]] void fail(const std::string& reason, const Advice&... advice) const {
    fail_model(path_, reason, advice...);
  }

  bool begins_as_text() const {
    constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
    std::string_view first, rest = text_;
    if (rest.starts_with(byte_order_mark)) rest.remove_prefix(byte_order_mark.size());
    while (trimmed(first).empty() && next_line(rest, first)) {
    }
    const bool has_zeros =
        text_.substr(0, kBegin).find('\0') != text_.npos;  // as the count of a binary file that is cut
    return lower_word(first) == "solid" && !has_zeros;
  }

  Mesh read_text() {
    MeshAssembly assembly(false, false);
    std::vector<Eigen::Vector3f> corners;
    bool in_solid = true, in_facet = false;
    int number = 0;
    for (std::string_view rest = text_, line; next_line(rest, line);) {
      ++number;
      const std::string word = lower_word(line);
      if (word == "facet") {
        if (in_facet) fail(fmt::format("line {}: a facet within a facet", number), kExportAnew);
        in_facet = true;
        corners.clear();
      } else if (word == "vertex" && in_facet) {
        corners.push_back(corner(line, number));
      } else if (word == "endfacet" && in_facet) {
        for (const auto& [a, b, c] : triangles_of_polygon(corners)) {
          assembly.add_triangle({Vertex{corners[a], {}, {}}, {corners[b], {}, {}}, {corners[c], {}, {}}}, 0);
        }
        in_facet = false;
      } else if (word == "solid" || word == "endsolid" || (word == "end" && lower_word(line) == "solid")) {
        in_solid = word == "solid";
      }
    }
    if (in_facet || in_solid) fail("it ends before 'endsolid'");
    return assembly.take();
  }

  Eigen::Vector3f corner(std::string_view line, int number) const {
    Eigen::Vector3d position;
    for (double& value : position) {
      const std::string_view word = next_word(line);
      const std::optional<double> read = parse_number(word);
      if (!read) fail(fmt::format("line {}: '{}' is not a number", number, word.substr(0, 20)), advice_on_number(word));
      value = *read;
    }
    return (position * scale_).cast<float>();
  }

  Mesh read_binary(std::size_t facets) const {
    const auto facet = [this](std::size_t i) { return text_.substr(kBegin + kFacet * i, kFacet); };
    const Looks looks = looks_of(facets);
    MeshAssembly assembly(false, looks.colored);
    for (std::size_t i = 0; i < facets; ++i) {
      const std::string_view bytes = facet(i);
      std::array<Vertex, 3> corners;
      for (std::size_t k = 0; k < 9; ++k) {
        const auto value = std::bit_cast<float>(little_endian(bytes.substr(12 + 4 * k, 4)));
        corners[k / 3].position[static_cast<Eigen::Index>(k % 3)] = static_cast<float>(value * scale_);
      }
      const Color color = color_of(attribute(i), looks);
      for (Vertex& corner : corners) corner.color = color;
      assembly.add_triangle(corners, 0);
    }
    return assembly.take();
  }

  /// The way the facets of a file say their colours, which STL does not: VisCAM's and SolidView's way, or that of
  /// Magics, whose header has a colour of the whole part.
  struct Looks {
    bool by_magics = false;    ///< red in the lowest bits, else blue
    std::uint32_t own = kBit;  ///< bit 15 of a facet with a colour of its own
    Color otherwise = kGrey;   ///< of the others
    bool colored = false;
  };

  Looks looks_of(std::size_t facets) const {
    constexpr std::string_view key = "COLOR=";
    const std::size_t named = text_.substr(0, kHeader).find(key);
    bool all = true, any = false, differ = false;
    for (std::size_t i = 0; i < facets; ++i) {
      const bool bit = (attribute(i) & kBit) != 0;
      all = all && bit;
      any = any || bit;
      differ = differ || attribute(i) != attribute(0);
    }
    Looks looks;
    looks.by_magics = named != text_.npos && named + key.size() + 4 <= kHeader;
    looks.colored = looks.by_magics ? differ : any;  // one colour all over shows nothing that the outline does not
    for (std::size_t i = 0; looks.by_magics && i < 4; ++i) {
      looks.otherwise[i] = static_cast<std::uint8_t>(text_[named + key.size() + i]);
    }
    // Magics sets the bit where the part's colour holds. MeshLab writes Magics' header, and the bit with every colour.
    if (looks.by_magics && !all) looks.own = 0;
    return looks;
  }

  static Color color_of(std::uint32_t attribute, const Looks& looks) {
    if ((attribute & kBit) != looks.own) return looks.otherwise;
    Color color{0, 0, 0, 255};
    for (std::size_t i = 0; i < 3; ++i) {
      color[looks.by_magics ? i : 2 - i] = static_cast<std::uint8_t>(((attribute >> (5 * i) & 31) * 255 + 15) / 31);
    }
    return color;
  }

  /// The two bytes behind a facet.
  std::uint32_t attribute(std::size_t facet) const {
    return little_endian(text_.substr(kBegin + kFacet * (facet + 1) - 2, 2));
  }

  const fs::path& path_;
  double scale_;
  std::string bytes_;
  std::string_view text_;
};

}  // namespace

Mesh load_stl(const fs::path& path, double scale) { return StlReader(path, scale).read(); }

}  // namespace holdfast::io
