#include "evaluation/marked_points.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <limits>
#include <sstream>

#include "evaluation/input_checks.hpp"
#include "holdfast/error.hpp"

namespace holdfast::evaluation {
namespace {

constexpr std::size_t kColumns = 6;

MarkedPoint parse_mark(std::string text, const std::string& where) {
  std::replace(text.begin(), text.end(), ',', ' ');
  std::istringstream in(text);
  std::array<double, kColumns> values{};
  std::size_t count = 0;
  while (count < kColumns && in >> values[count]) {
    ++count;
  }
  std::string rest;
  in.clear();
  const bool finite = std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  if (count < kColumns || in >> rest || !finite || values[0] < 0 || values[0] != std::floor(values[0])) {
    throw Error(ErrorCode::file, fmt::format("{}: expected frame,x,y,z,u,v (a frame's number, metres, pixels)", where));
  }
  return {static_cast<int>(values[0]), {values[1], values[2], values[3]}, {values[4], values[5]}};
}

}  // namespace

std::vector<MarkedPoint> load_marked_points(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) {
    throw Error(ErrorCode::file, fmt::format("{}: marked points cannot be read", file.string()));
  }
  skip_byte_order_mark(in);
  std::vector<MarkedPoint> marks;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    line.erase(std::min(line.find('#'), line.size()));
    if (line.find_first_not_of(" \t\r") != std::string::npos) {
      marks.push_back(parse_mark(line, fmt::format("{}, line {}", file.string(), number)));
    }
  }
  if (marks.empty()) {
    throw Error(ErrorCode::file, fmt::format("{}: no marked points", file.string()));
  }
  return marks;
}

std::vector<MarkDistance> mark_distances(const std::vector<MarkedPoint>& marks, const EstimatedPoses& poses,
                                         const Camera& camera) {
  std::vector<MarkDistance> distances;
  for (const MarkedPoint& mark : marks) {
    const auto pose = std::find_if(poses.entries.begin(), poses.entries.end(),
                                   [&](const EstimatedPoses::Entry& entry) { return entry.frame == mark.frame; });
    if (pose == poses.entries.end()) {
      throw Error(ErrorCode::file, fmt::format("frame {} is marked, but the poses have none for it", mark.frame));
    }
    MarkDistance distance{mark, pose->held(), Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity())};
    const Eigen::Vector3d p_camera = pose->result.T_camera_object * mark.p_object;
    if (p_camera.z() > 0) {
      const Eigen::Vector2d pixel = camera.project(p_camera);
      distance.offset = (camera.has_distortion() ? camera.distort(pixel) : pixel) - mark.pixel;
    }
    distances.push_back(distance);
  }
  return distances;
}

Spread mark_spread(const std::vector<MarkDistance>& distances) {
  std::vector<double> lengths;
  for (const MarkDistance& distance : distances) {
    lengths.push_back(distance.held ? distance.offset.norm() : std::numeric_limits<double>::infinity());
  }
  return spread(lengths);
}

std::string mark_table(const std::vector<MarkDistance>& distances) {
  std::string text = "frame  status  distances of the marked points, pixels\n";
  for (std::size_t i = 0; i < distances.size(); ++i) {
    const MarkDistance& distance = distances[i];
    if (i == 0 || distance.mark.frame != distances[i - 1].mark.frame) {
      text += fmt::format("{}{:>5}  {:<6}", i == 0 ? "" : "\n", distance.mark.frame, distance.held ? "held" : "lost");
    }
    text += fmt::format("  {:5.1f}", distance.offset.norm());
  }
  const Spread all = mark_spread(distances);
  return text + fmt::format("\nall    {} points: median {:.2f}, 95 % {:.2f}, largest {:.2f} pixels\n", distances.size(),
                            all.median, all.p95, all.maximum);
}

}  // namespace holdfast::evaluation
