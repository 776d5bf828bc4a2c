#include "evaluation/estimated_poses.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <type_traits>

#include "evaluation/input_checks.hpp"
#include "holdfast/error.hpp"
#include "holdfast/io.hpp"

namespace holdfast::evaluation {
namespace {

namespace fs = std::filesystem;

/// The cells of a line of a table; one in quotes may hold commas, and quotes twice.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') {
      if (quoted && i + 1 < line.size() && line[i + 1] == '"') {
        cells.back() += line[++i];
      } else {
        quoted = !quoted;
      }
    } else if (line[i] == ',' && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += line[i];
    }
  }
  for (std::string& cell : cells) {
    const auto from = cell.find_first_not_of(" \t\r");
    const auto to = cell.find_last_not_of(" \t\r");
    cell = from == std::string::npos ? std::string() : cell.substr(from, to - from + 1);
  }
  return cells;
}

double number(const std::string& text, const fs::path& path, int line) {
  try {
    std::size_t used = 0;
    const double value = std::stod(text, &used);
    if (used == text.size()) {
      return value;
    }
  } catch (const std::exception&) {
  }
  bad_file(path, fmt::format("line {}: '{}' is no number", line, text));
}

/// The table that `holdfast track --poses` writes.
EstimatedPoses load_table(const fs::path& path) {
  std::ifstream in(path);
  skip_byte_order_mark(in);
  std::string line;
  std::getline(in, line);
  std::map<std::string, std::size_t> column;
  for (const std::string& name : cells_of(line)) {
    column.emplace(name, column.size());
  }
  for (const char* name : {"frame", "tx", "ty", "tz", "qx", "qy", "qz", "qw"}) {
    if (!column.contains(name)) {
      bad_file(path,
               fmt::format("no column '{}': a table with frame, tx ty tz (metres) and qx qy qz qw is needed", name));
    }
  }
  EstimatedPoses out;
  for (int number_of_line = 2; std::getline(in, line); ++number_of_line) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) {
      continue;
    }
    const std::vector<std::string> cells = cells_of(line);
    const auto cell = [&](const char* name) -> const std::string& {
      if (column.at(name) >= cells.size()) {
        bad_file(path, fmt::format("line {}: {} columns where the heading has {}", number_of_line, cells.size(),
                                   column.size()));
      }
      return cells[column.at(name)];
    };
    const auto value = [&](const char* name) { return number(cell(name), path, number_of_line); };
    EstimatedPoses::Entry entry;
    entry.frame = static_cast<int>(value("frame"));
    if (!out.entries.empty() && entry.frame <= out.entries.back().frame) {
      bad_file(path, fmt::format("line {}: frame {} does not come after frame {}", number_of_line, entry.frame,
                                 out.entries.back().frame));
    }
    const Eigen::Quaterniond q(value("qw"), value("qx"), value("qy"), value("qz"));
    if (!(std::abs(q.norm() - 1) < 1e-3)) {
      throw Error(ErrorCode::pose, fmt::format("{}, line {}: the quaternion's length is {:.6g}, a rotation's is 1",
                                               path.string(), number_of_line, q.norm()));
    }
    FrameResult& result = entry.result;
    result.T_camera_object.linear() = q.normalized().toRotationMatrix();
    result.T_camera_object.translation() = Eigen::Vector3d(value("tx"), value("ty"), value("tz"));
    checked(result.T_camera_object, path, fmt::format("line {}", number_of_line));
    result.status = Status::held;
    if (column.contains("status")) {
      const std::string& status = cell("status");
      if (status != "held" && status != "lost") {
        bad_file(path, fmt::format("line {}: status '{}' is neither held nor lost", number_of_line, status));
      }
      result.status = status == "held" ? Status::held : Status::lost;
    }
    const auto figure = [&](const char* name, auto& field) {
      if (column.contains(name)) field = static_cast<std::remove_reference_t<decltype(field)>>(value(name));
    };
    figure("visible", result.texture.visible_pixels);
    figure("usable", result.texture.usable_pixels);
    figure("gradient", result.texture.gradient_pixels);
    figure("passed", result.texture.passed_pixels);
    figure("used", result.texture.used_pixels);
    figure("residual", result.texture.residual);
    figure("correlation", result.texture.correlation);
    result.texture.asked = column.contains("visible");
    figure("iterations", result.iterations);
    figure("ms", result.ms.total);
    figure("texture_holds", result.texture.holds);
    figure("contour_holds", result.contour.holds);
    figure("snapshot_holds", result.snapshot.holds);
    if (column.contains("reason")) {
      result.message = cell("reason");
    }
    out.entries.push_back(entry);
  }
  return out;
}

/// The frame that is shown at this time: files have rounded times, but none between frames.
int frame_at(double time_s, double frame_rate, const fs::path& path) {
  constexpr double kBeside = 0.1;
  const double frame = std::round(time_s * frame_rate);
  if (!(std::abs(frame - time_s * frame_rate) < kBeside && frame >= 0 && frame <= std::numeric_limits<int>::max())) {
    bad_file(path,
             fmt::format("the time {:.6g} s is none of a frame at {:g} frames a second, counted from the first; give "
                         "the table of 'holdfast track --poses', which has frames' numbers, or the numbers as times",
                         time_s, frame_rate));
  }
  return static_cast<int>(frame);
}

/// A pose a line.
EstimatedPoses load_lines(const fs::path& path, std::optional<double> frame_rate) {
  const std::vector<io::TimedPose> lines = io::load_timed_poses(path);
  const bool timed =
      frame_rate && std::all_of(lines.begin(), lines.end(), [](const io::TimedPose& line) { return line.time_s; });
  const bool numbered = std::all_of(lines.begin(), lines.end(), [](const io::TimedPose& line) {
    return line.time_s && *line.time_s == std::round(*line.time_s);
  });
  EstimatedPoses out;
  for (const io::TimedPose& line : lines) {
    const int last = out.entries.empty() ? -1 : out.entries.back().frame;
    const int frame = timed ? frame_at(*line.time_s, numbered ? 1 : *frame_rate, path) : last + 1;
    if (frame <= last)
      bad_file(path, fmt::format("the time {:.6g} s does not come after the one before", *line.time_s));
    out.entries.push_back({frame, {}});
    out.entries.back().result.T_camera_object = line.T_camera_object;
    out.entries.back().result.status = Status::held;
  }
  return out;
}

}  // namespace

EstimatedPoses load_estimated_poses(const fs::path& file, std::optional<double> frame_rate) {
  std::ifstream in(file);
  if (!in) {
    bad_file(file, "cannot be opened");
  }
  std::string first;
  std::getline(in, first);
  const bool table = first.find('#') == std::string::npos && first.find("frame") != std::string::npos &&
                     first.find(',') != std::string::npos;
  EstimatedPoses out = table ? load_table(file) : load_lines(file, frame_rate);
  if (out.entries.empty()) {
    bad_file(file, "holds no poses");
  }
  return out;
}

}  // namespace holdfast::evaluation
