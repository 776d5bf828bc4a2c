#include "io/ply_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <string_view>
#include <utility>

#include "holdfast/error.hpp"
#include "io/numbers.hpp"

namespace holdfast::io {

namespace fs = std::filesystem;
using Encoding = PlyHeader::Encoding;
using Type = PlyHeader::Type;
using Property = PlyHeader::Property;
using Element = PlyHeader::Element;

void fail_ply(const fs::path& path, const std::string& reason) {
  throw Error(ErrorCode::file,
              fmt::format("model '{}' cannot be read ({}): is the file complete?", path.string(), reason));
}

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
  fail_ply(path, fmt::format("its header names an unknown type '{}'", word));
}

}  // namespace

PlyHeader parse_ply_header(const std::string& bytes, const fs::path& path) {
  PlyHeader header;
  std::istringstream lines(bytes.substr(0, std::min<std::size_t>(bytes.size(), 1 << 16)));
  std::string line;
  while (std::getline(lines, line)) {
    if (line.ends_with('\r')) {
      line.pop_back();
    }
    std::istringstream words(line);
    std::string keyword;
    std::string word;
    words >> keyword;
    if (keyword == "format") {
      words >> word;
      header.encoding = word == "ascii"                  ? Encoding::text
                        : word == "binary_little_endian" ? Encoding::little_endian
                                                         : Encoding::big_endian;
    } else if (keyword == "comment") {
      words >> word;
      if (word == "TextureFile") {
        std::getline(words >> std::ws, word);
        header.textures.push_back(std::string(trimmed(word)));
      }
    } else if (keyword == "element") {
      Element element;
      words >> element.name >> element.count;
      if (!words || element.count > bytes.size()) {  // each takes a byte at least
        fail_ply(path, fmt::format("its header's '{}' is not possible in {} bytes", line, bytes.size()));
      }
      header.elements.push_back(element);
    } else if (keyword == "property" && !header.elements.empty()) {
      Property property;
      words >> word;
      if (word == "list") {
        words >> word;
        property.count_type = parse_type(word, path);
        words >> word;
      }
      property.type = parse_type(word, path);
      words >> property.name;
      header.elements.back().properties.push_back(property);
    } else if (keyword == "end_header") {
      header.size = lines.eof() ? bytes.size() : static_cast<std::size_t>(lines.tellg());
      return header;
    }
  }
  fail_ply(path, "its header has no end");
}

}  // namespace holdfast::io
