#include "init/point_pairs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <string_view>

#include "holdfast/error.hpp"
#include "track/output_file.hpp"

namespace holdfast::app {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";  // Windows' editors begin UTF-8 with it
constexpr std::string_view kBlanks = " \t\r";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  return first == text.npos ? "" : text.substr(first, text.find_last_not_of(kBlanks) + 1 - first);
}

/// Cells between commas or semicolons, or else between blanks.
std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  const bool delimited = line.find_first_of(",;") != line.npos;
  const std::string_view separators = delimited ? ",;" : kBlanks;
  while (true) {
    const std::size_t end = std::min(line.find_first_of(separators), line.size());
    const std::string_view cell = trimmed(line.substr(0, end));
    if (delimited || !cell.empty()) {
      cells.push_back(cell);
    }
    if (end == line.size()) {
      return cells;
    }
    line.remove_prefix(end + 1);
  }
}

std::optional<double> number(std::string_view cell) {
  if (cell.starts_with('+')) {
    cell.remove_prefix(1);
  }
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc() && end == cell.data() + cell.size() ? std::optional(value) : std::nullopt;
}

bool is_heading(const std::vector<std::string_view>& cells) {
  return std::all_of(cells.begin(), cells.end(), [](std::string_view cell) {
    return !cell.empty() && std::isalpha(static_cast<unsigned char>(cell.front())) && !number(cell);
  });
}

PointPair parse_pair(const std::vector<std::string_view>& cells, const fs::path& path, int line, double scale) {
  const auto fail = [&](const std::string& reason) {
    throw Error(ErrorCode::pose, fmt::format("point pairs '{}', line {}: {}", path.string(), line, reason));
  };
  if (cells.size() != 5) {
    fail(fmt::format("{} columns; expected 5: x,y,z,u,v (a point of the model and its pixel), with decimal points",
                     cells.size()));
  }
  std::array<double, 5> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::optional<double> value = number(cells[i]);
    if (!value) {
      fail(fmt::format("'{}' is not a number", cells[i].substr(0, 40)));
    }
    if (!std::isfinite(*value)) {
      fail(fmt::format("'{}' is not finite: give coordinates in numbers", cells[i]));
    }
    values[i] = *value;
  }
  return {
      scale * Eigen::Vector3d(values[0], values[1], values[2]), {values[3], values[4]}, fmt::format("line {}", line)};
}

}  // namespace

std::vector<PointPair> load_point_pairs(const fs::path& path, double scale) {
  std::error_code ignored;
  if (!fs::exists(path, ignored) || fs::is_directory(path, ignored)) {
    throw Error(ErrorCode::file,
                fmt::format("point pairs '{}' do not exist: give a CSV file of lines x,y,z,u,v", path.string()));
  }
  std::ifstream file(path);
  std::vector<PointPair> pairs;
  std::string text;
  int line = 0;
  bool first = true;
  while (std::getline(file, text)) {
    if (++line == 1 && text.starts_with(kByteOrderMark)) {
      text.erase(0, kByteOrderMark.size());
    }
    const std::string_view content = trimmed(std::string_view(text).substr(0, text.find('#')));
    if (content.empty()) {
      continue;
    }
    const std::vector<std::string_view> cells = cells_of(content);
    if (!first || !is_heading(cells)) {
      pairs.push_back(parse_pair(cells, path, line, scale));
    }
    first = false;
  }
  if (!file.eof()) {
    throw Error(ErrorCode::file,
                fmt::format("point pairs '{}' cannot be read: check the file's permissions", path.string()));
  }
  return pairs;
}

void save_point_pairs(const fs::path& path, const std::vector<PointPair>& pairs) {
  std::string text = "# x_m,y_m,z_m,u_px,v_px\n";
  for (const PointPair& pair : pairs) {
    text += fmt::format("{:.9g},{:.9g},{:.9g},{:.2f},{:.2f}\n", pair.p_object.x(), pair.p_object.y(), pair.p_object.z(),
                        pair.pixel.x(), pair.pixel.y());
  }
  write_whole(path, text);
}

}  // namespace holdfast::app
