#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "io/numbers.hpp"
#include "io/text_file.hpp"

namespace holdfast::io {
namespace {

namespace fs = std::filesystem;

/// Files carry few digits; a rotation off by more than this is no rounding but another convention or a mistake.
constexpr double kRotationTolerance = 1e-2;

[[noreturn]] void fail(const fs::path& path, int line, const std::string& reason) {
  throw Error(ErrorCode::pose, fmt::format("pose file '{}', line {}: {}", path.string(), line, reason));
}

Pose checked(const Pose& pose, const fs::path& path, int line) {
  try {
    validate_pose(pose, kRotationTolerance);
  } catch (const Error& error) {
    fail(path, line, error.what());
  }
  return renormalized(pose);
}

/// 12 or 16 numbers, row by row.
Pose pose_from_matrix(const std::vector<double>& values, const fs::path& path, int line) {
  if (values.size() == 16 && !(values[12] == 0 && values[13] == 0 && values[14] == 0 && values[15] == 1)) {
    fail(path, line, "the fourth row of a 4x4 pose must be 0 0 0 1 (is the matrix transposed?)");
  }
  Pose pose = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      pose.matrix()(row, column) = values[static_cast<std::size_t>(4 * row + column)];
    }
  }
  return checked(pose, path, line);
}

Pose pose_from_tum(const std::vector<double>& values, const fs::path& path, int line) {
  const Eigen::Quaterniond q(values[7], values[4], values[5], values[6]);
  if (!(std::abs(q.norm() - 1) < kRotationTolerance)) {
    fail(path, line,
         fmt::format("the quaternion's length is {:.4g}, not 1 (expected: t tx ty tz qx qy qz qw)", q.norm()));
  }
  Pose pose = Pose::Identity();
  pose.linear() = q.normalized().toRotationMatrix();
  pose.translation() << values[1], values[2], values[3];
  return checked(pose, path, line);
}

/// A rotation about an axis by its length, radians.
Pose pose_from_vectors(const Eigen::Vector3d& rotation, const Eigen::Vector3d& translation, const fs::path& path,
                       int line) {
  constexpr double most = 6.3;  // radians, a whole turn
  if (!(rotation.norm() < most)) {
    fail(path, line,
         fmt::format("the rotation vector is {:.4g} radians long, more than a turn (six numbers are OpenCV's rvec and "
                     "tvec in a line, or ViSP's translation and rotation a number a line): are they degrees, or in the "
                     "other order?",
                     rotation.norm()));
  }
  Pose pose = Pose::Identity();
  if (rotation.norm() > 0) {
    pose.linear() = Eigen::AngleAxisd(rotation.norm(), rotation.normalized()).toRotationMatrix();
  }
  pose.translation() = translation;
  return checked(pose, path, line);
}

/// rvec and tvec.
Pose pose_from_opencv(const std::vector<double>& v, const fs::path& path, int line) {
  return pose_from_vectors({v[0], v[1], v[2]}, {v[3], v[4], v[5]}, path, line);
}

/// The three numbers in brackets after a name that is there once.
std::optional<std::vector<double>> named_vector(const std::string& text, const char* name) {
  const std::size_t at = text.find(name);
  const std::size_t begin = at == std::string::npos ? at : text.find_first_of("[(", at);
  const bool once = at == std::string::npos || text.find(name, at + 1) == std::string::npos;
  if (begin == std::string::npos || !once || text.find("vec", at + 4) < begin) return std::nullopt;
  const std::size_t end = text.find_first_of("rtRT\"'}", begin);  // where the next name begins
  const auto lines = parse_numbers(text.substr(begin, end == std::string::npos ? end : end - begin));
  std::vector<double> values;
  if (lines) {
    for (const NumberLine& line : *lines) values.insert(values.end(), line.values.begin(), line.values.end());
  }
  return values.size() == 3 ? std::optional(values) : std::nullopt;
}

std::vector<NumberLine> read_lines(const fs::path& path) {
  int bad_line = 0;
  std::string bad_word;
  const std::string text = read_plain_text_file(path, "pose file");
  const auto lines = parse_numbers(text, &bad_line, &bad_word);
  if (!lines) {
    const auto rotation = named_vector(text, "rvec"), translation = named_vector(text, "tvec");
    if (rotation && translation) {
      NumberLine both{1, *rotation};
      both.values.insert(both.values.end(), translation->begin(), translation->end());
      return {both};
    }
    fail(path, bad_line,
         fmt::format("'{}' is not a number (expected: a 3x4 or 4x4 matrix, t tx ty tz qx qy qz qw, or rvec and tvec)",
                     bad_word));
  }
  if (lines->empty()) {
    throw Error(
        ErrorCode::pose,
        fmt::format(
            "pose file '{}' holds no numbers: give a 3x4 or 4x4 matrix, t tx ty tz qx qy qz qw, or rvec and tvec",
            path.string()));
  }
  return *lines;
}

bool is_pose_line(const NumberLine& line) {
  return line.values.size() == 6 || line.values.size() == 8 || line.values.size() == 12 || line.values.size() == 16;
}

Pose pose_from_line(const NumberLine& line, const fs::path& path) {
  if (line.values.size() == 6) return pose_from_opencv(line.values, path, line.line);
  return line.values.size() == 8 ? pose_from_tum(line.values, path, line.line)
                                 : pose_from_matrix(line.values, path, line.line);
}

}  // namespace

Pose load_pose(const fs::path& path) {
  const std::vector<NumberLine> lines = read_lines(path);
  // Two lines of six are the twelve numbers of a matrix.
  if (is_pose_line(lines.front()) && !(lines.front().values.size() == 6 && lines.size() == 2)) {
    return pose_from_line(lines.front(), path);
  }
  // A matrix over several lines: rows of four (the fourth row tells 4x4 from the next pose's first row), or all the
  // numbers that there are.
  std::vector<double> values;
  bool rows_of_four = true;
  for (const NumberLine& line : lines) {
    rows_of_four = rows_of_four && line.values.size() == 4;
    values.insert(values.end(), line.values.begin(), line.values.end());
  }
  if (rows_of_four && values.size() > 16) {
    const bool is_4x4 = values[12] == 0 && values[13] == 0 && values[14] == 0 && values[15] == 1;
    values.erase(values.begin() + (is_4x4 ? 16 : 12), values.end());
  }
  if (values.size() == 6) {
    const int line = lines.front().line;
    return lines.size() == 6
               ? pose_from_vectors({values[3], values[4], values[5]}, {values[0], values[1], values[2]}, path, line)
               : pose_from_opencv(values, path, line);
  }
  if (values.size() != 12 && values.size() != 16) {
    fail(
        path, lines.front().line,
        fmt::format("{} numbers make no pose (expected: a 3x4 or 4x4 matrix, t tx ty tz qx qy qz qw, or rvec and tvec)",
                    values.size()));
  }
  return pose_from_matrix(values, path, lines.front().line);
}

std::vector<Pose> load_poses(const fs::path& path) {
  std::vector<Pose> poses;
  for (const TimedPose& timed : load_timed_poses(path)) poses.push_back(timed.T_camera_object);
  return poses;
}

std::vector<TimedPose> load_timed_poses(const fs::path& path) {
  std::vector<TimedPose> poses;
  for (const NumberLine& line : read_lines(path)) {
    if (!is_pose_line(line)) {
      fail(path, line.line,
           fmt::format("{} numbers make no pose (expected on each line: 12 or 16 of a matrix, or t tx ty tz qx qy qz "
                       "qw)",
                       line.values.size()));
    }
    TimedPose timed;
    if (line.values.size() == 8) timed.time_s = line.values.front();
    timed.T_camera_object = pose_from_line(line, path);
    poses.push_back(timed);
  }
  return poses;
}

void save_pose(const fs::path& path, const Pose& T_camera_object) {
  if (!T_camera_object.matrix().allFinite()) {
    throw Error(ErrorCode::pose,
                fmt::format("pose file '{}' is not written: the pose has NaN or infinite entries", path.string()));
  }
  std::string text = "# T_camera_object: object frame to camera frame (x right, y down, z forward), metres\n";
  for (int row = 0; row < 4; ++row) {
    const auto values = T_camera_object.matrix().row(row);
    text += fmt::format("{:.17g} {:.17g} {:.17g} {:.17g}\n", values(0), values(1), values(2), values(3));
  }
  write_text_file(path, text);
}

}  // namespace holdfast::io
