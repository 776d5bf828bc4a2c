#include "io/ply_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "io/model_fault.hpp"
#include "io/numbers.hpp"

namespace holdfast::io {

namespace fs = std::filesystem;
using Encoding = PlyHeader::Encoding;
using Type = PlyHeader::Type;
using Property = PlyHeader::Property;
using Element = PlyHeader::Element;

namespace {

Type parse_type(const std::string& word, const fs::path& path) {
  constexpr std::pair<std::string_view, Type> names[] = {
      {"char", Type::int8},     {"int8", Type::int8},       {"uchar", Type::uint8},    {"uint8", Type::uint8},
      {"short", Type::int16},   {"int16", Type::int16},     {"ushort", Type::uint16},  {"uint16", Type::uint16},
      {"int", Type::int32},     {"int32", Type::int32},     {"uint", Type::uint32},    {"uint32", Type::uint32},
      {"float", Type::float32}, {"float32", Type::float32}, {"double", Type::float64}, {"float64", Type::float64}};
  for (const auto& [name, type] : names) {
    if (word == name) {
      return type;
    }
  }
  fail_model(path, fmt::format("its header names an unknown type '{}'", word), kExportAnew);
}

Encoding parse_encoding(const std::string& word, const fs::path& path) {
  if (word == "ascii") return Encoding::text;
  if (word == "binary_little_endian") return Encoding::little_endian;
  if (word == "binary_big_endian") return Encoding::big_endian;
  fail_model(path, fmt::format("its header names an unknown format '{}'", word), kExportAnew);
}

}  // namespace

PlyHeader parse_ply_header(const std::string& bytes, const fs::path& path) {
  PlyHeader header;
  std::string_view text = std::string_view(bytes).substr(0, 1 << 16), line;
  if (!next_line(text, line) || trimmed(line) != "ply")
    fail_model(path, "it does not begin with 'ply'", "is it a PLY file?");
  const auto take = [&line] { return lower(next_word(line)); };
  while (next_line(text, line)) {
    const std::string_view whole = line;
    const std::string keyword = take();
    if (keyword == "format") {
      header.encoding = parse_encoding(take(), path);
    } else if (keyword == "comment") {
      if (take() == "texturefile") header.textures.emplace_back(trimmed(line));
    } else if (keyword == "element") {
      const std::string name = take();
      const std::optional<double> count = parse_number(next_word(line));
      if (!count || !(*count >= 0 && *count <= static_cast<double>(bytes.size()))) {  // each takes a byte at least
        fail_model(path, fmt::format("its header's '{}' is not possible in {} bytes", whole, bytes.size()));
      }
      header.elements.push_back({name, static_cast<std::size_t>(*count), {}});
    } else if (keyword == "property" && !header.elements.empty()) {
      Property property;
      std::string word = take();
      if (word == "list") {
        property.count_type = parse_type(take(), path);
        word = take();
      }
      property.type = parse_type(word, path);
      property.name = take();
      header.elements.back().properties.push_back(property);
    } else if (keyword == "end_header") {
      header.size = static_cast<std::size_t>(text.data() - bytes.data());
      return header;
    }
  }
  fail_model(path, "its header has no end");
}

}  // namespace holdfast::io
