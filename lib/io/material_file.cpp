#include "io/material_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "io/numbers.hpp"
#include "io/text_file.hpp"

namespace holdfast::io {
namespace {

namespace fs = std::filesystem;

/// The numbers that follow, up to `most`.
std::vector<double> take_numbers(std::string_view& line, std::size_t most) {
  std::vector<double> numbers;
  while (numbers.size() < most) {
    std::string_view rest = line;
    const std::optional<double> number = parse_number(next_word(rest));
    if (!number) break;
    numbers.push_back(*number);
    line = rest;
  }
  return numbers;
}

/// u and v of an option's one to three numbers.
Eigen::Vector2f pair_of(const std::vector<double>& numbers, float otherwise) {
  return {numbers.empty() ? otherwise : static_cast<float>(numbers[0]),
          numbers.size() < 2 ? otherwise : static_cast<float>(numbers[1])};
}

/// An option of a map that changes what is seen and is not supported; its words are taken off the line.
bool is_unsupported(const std::string& option, std::string_view& line) {
  if (option == "-mm") {
    const std::vector<double> values = take_numbers(line, 2);
    return !((values.empty() || values[0] == 0) && (values.size() < 2 || values[1] == 1));
  }
  if (option == "-t") {
    const std::vector<double> values = take_numbers(line, 3);
    return std::any_of(values.begin(), values.end(), [](double value) { return value != 0; });
  }
  if (option == "-cc") {
    return lower(next_word(line)) == "on";
  }
  if (option == "-bm" || option == "-texres" || option == "-boost") {
    take_numbers(line, 1);
  } else if (option == "-blendu" || option == "-blendv" || option == "-imfchan" || option == "-type") {
    next_word(line);  // how it is filtered, or of other kinds of maps
  } else {
    next_word(line);
    return true;
  }
  return false;
}

MaterialMap parse_map(std::string_view line, const fs::path& path, std::vector<std::string>& remarks) {
  MaterialMap map;
  for (line = trimmed(line); line.starts_with('-'); line = trimmed(line)) {
    std::string_view rest = line;
    const std::string option = lower(next_word(rest));
    if (trimmed(rest).empty()) break;  // a name that begins with a dash
    line = rest;
    if (option == "-s") {
      map.scale = pair_of(take_numbers(line, 3), 1);
    } else if (option == "-o") {
      map.offset = pair_of(take_numbers(line, 3), 0);
    } else if (option == "-clamp") {
      map.wrapping.u = map.wrapping.v = lower(next_word(line)) == "on" ? Wrap::clamp : Wrap::repeat;
    } else if (is_unsupported(option, line)) {
      remarks.push_back(fmt::format("'{}': the option {} of map_Kd is not supported, the texture is taken without it",
                                    path.string(), option));
    }
  }
  map.name = std::string(line);
  return map;
}

}  // namespace

std::vector<NamedMaterial> load_materials(const fs::path& path, std::vector<std::string>& remarks) {
  const std::string bytes = read_text_file(path, "material file");
  std::vector<NamedMaterial> materials;
  std::string_view text = bytes;
  for (std::string_view line; next_line(text, line);) {
    const std::string keyword = lower(next_word(line));
    if (keyword == "newmtl") {
      materials.push_back({std::string(trimmed(line)), path, {}, {}, {}});
    } else if (materials.empty()) {
      continue;
    } else if (keyword == "map_kd") {
      materials.back().map = parse_map(line, path, remarks);
    } else if (keyword == "map_ka" || keyword == "map_ke") {
      materials.back().other_map = keyword == "map_ka" ? "map_Ka" : "map_Ke";
    } else if (keyword == "kd") {
      const std::vector<double> values = take_numbers(line, 3);
      if (values.empty()) continue;  // a spectral curve
      std::array<std::uint8_t, 4> color{0, 0, 0, 255};
      for (std::size_t i = 0; i < 3; ++i) {
        const double value = values[std::min(i, values.size() - 1)];
        color[i] = static_cast<std::uint8_t>(std::lround(std::clamp(std::isnan(value) ? 0 : value, 0.0, 1.0) * 255));
      }
      materials.back().color = color;
    }
  }
  return materials;
}

}  // namespace holdfast::io
