#include "simulation/motion.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "holdfast/error.hpp"
#include "simulation/random.hpp"
#include "simulation/sharp_motion.hpp"
#include "simulation/stage.hpp"

namespace holdfast::simulation {
namespace {

using Corners = std::array<Eigen::Vector3d, 8>;

// A number in [-1, 1] that varies as a sum of three sines.
struct Wave {
  std::array<double, 3> strength, frequency, phase;

  explicit Wave(Random& random) {
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      strength[i] = random.uniform(0.4, 1.0);
      frequency[i] = random.uniform(0.5, 2.0);
      phase[i] = random.uniform(0.0, 2.0 * std::numbers::pi);
      sum += strength[i];
    }
    for (double& s : strength) s /= sum;
  }
  double at(double time) const {
    double value = 0;
    for (std::size_t i = 0; i < 3; ++i) value += strength[i] * std::sin(frequency[i] * time + phase[i]);
    return value;
  }
};

PoseAt smooth_motion(const Stage& stage, const MotionOptions& options, int frames, std::uint64_t seed) {
  Random random(seed, 0x51e5);
  std::vector<Wave> waves;
  for (int i = 0; i < 6; ++i) waves.emplace_back(random);
  const auto at = [stage, waves, range = options.rotation_range](double time) {
    Placement p{waves[0].at(time), waves[1].at(time), waves[2].at(time), {}};
    // Each axis' sum of sines seldom comes near 1: stretched so that the range is used, never left.
    for (int k = 0; k < 3; ++k)
      p.turn[k] = range * std::sin(0.5 * std::numbers::pi * waves[static_cast<std::size_t>(3 + k)].at(time));
    return stage.pose(p);
  };
  // The slower the sines run, the slower the corners: find the pace at which 95 % of the frames keep to the speed.
  const auto speed_at = [&](double pace) {
    std::vector<double> speeds;
    Pose last = at(0);
    for (int i = 1; i < std::max(frames, 2); ++i) {
      const Pose next = at(pace * i);
      speeds.push_back(stage.motion(last, next));
      last = next;
    }
    const auto nth = speeds.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(speeds.size() - 1));
    std::nth_element(speeds.begin(), nth, speeds.end());
    return *nth;
  };
  double low = 0, high = 1e-4;
  constexpr double fastest_pace = 0.4;  // radians a frame: beyond, the motion is a jitter and no longer smooth
  while (speed_at(high) < options.speed) {
    low = high;
    high *= 1.25;
    if (high > fastest_pace) {
      throw Error(
          ErrorCode::invalid_argument,
          "motion: the object cannot move that fast smoothly and stay in view; lower the speed, bring it nearer or "
          "allow more rotation");
    }
  }
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (speed_at(middle) < options.speed ? low : high) = middle;
  }
  return [at, pace = high](double frame) { return at(pace * frame); };
}

void validate(const MotionOptions& options) {
  const auto check = [](bool fine, const char* what) {
    if (!fine) throw Error(ErrorCode::invalid_argument, std::string("motion: ") + what);
  };
  check(options.speed > 0 && std::isfinite(options.speed), "the speed must be a positive number of pixels a frame");
  check(options.nearest >= 0 && options.farthest >= 0, "distances must not be negative; 0 chooses them");
  check(options.rotation_range >= 0 && options.rotation_range <= std::numbers::pi,
        "the rotation range must be 0 to pi");
  check(options.turns >= 0, "the number of turns must not be negative");
  check(options.ease >= 0, "the frames to get up to speed must not be negative");
}

}  // namespace

PoseAt motion_through(std::vector<Pose> poses) {
  if (poses.empty()) throw Error(ErrorCode::invalid_argument, "motion: there are no poses; give one a frame");
  return [poses = std::move(poses)](double frame) {
    const int last = static_cast<int>(poses.size()) - 1;
    if (last == 0 || frame >= last + 0.5) return poses[static_cast<std::size_t>(last)];
    // Exposures that reach beyond the ends go straight on there.
    const int i = std::clamp(static_cast<int>(std::floor(frame)), 0, last - 1);
    return between(poses[static_cast<std::size_t>(i)], poses[static_cast<std::size_t>(i) + 1],
                   std::max(frame, -0.5) - i);
  };
}

std::array<Eigen::Vector3d, 8> bounding_corners(const Mesh& mesh) {
  Eigen::Vector3f low = mesh.positions.front(), high = low;
  for (const Eigen::Vector3f& p : mesh.positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  Corners corners;
  for (std::size_t i = 0; i < 8; ++i) {
    corners[i] = Eigen::Vector3f(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z())
                     .cast<double>();
  }
  return corners;
}

double corner_motion(const std::array<Eigen::Vector3d, 8>& corners, const Camera& camera, const Pose& T_camera_object_1,
                     const Pose& T_camera_object_2) {
  double farthest = 0;
  for (const Eigen::Vector3d& corner : corners) {
    const Eigen::Vector3d a = T_camera_object_1 * corner;
    const Eigen::Vector3d b = T_camera_object_2 * corner;
    farthest = std::max(
        farthest, std::hypot(camera.fx * (b.x() / b.z() - a.x() / a.z()), camera.fy * (b.y() / b.z() - a.y() / a.z())));
  }
  return farthest;
}

Eigen::Matrix3d MotionOptions::default_orientation() {
  Eigen::Matrix3d upright = Eigen::Vector3d(1, -1, -1).asDiagonal();  // y up, facing the camera
  return Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(0.55, Eigen::Vector3d::UnitY()) * upright;
}

PoseAt make_motion(const MotionOptions& options, const Mesh& mesh, const Camera& camera, int frames,
                   std::uint64_t seed) {
  if (!options.T_camera_object.empty()) return motion_through(options.T_camera_object);
  validate(options);
  const Stage stage(options, mesh, camera);
  switch (options.style) {
    case MotionStyle::smooth:
      return smooth_motion(stage, options, frames, seed);
    case MotionStyle::sharp:
      return sharp_motion(stage, options, frames, seed);
    case MotionStyle::still:
      break;
  }
  return [pose = stage.pose({})](double) { return pose; };
}

MotionSummary summarize_motion(const std::vector<Pose>& poses, const Mesh& mesh, const Camera& camera) {
  MotionSummary summary;
  const Corners corners = bounding_corners(mesh);
  const Eigen::Vector3d center = 0.5 * (corners.front() + corners.back());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double distance = (poses[i] * center).z();
    summary.nearest = i == 0 ? distance : std::min(summary.nearest, distance);
    summary.farthest = std::max(summary.farthest, distance);
    if (i + 1 < poses.size()) summary.corner_speed.push_back(corner_motion(corners, camera, poses[i], poses[i + 1]));
    if (i > 0 && i + 1 < poses.size()) {
      const Eigen::Vector3d in = (poses[i] * center) - (poses[i - 1] * center);
      const Eigen::Vector3d out = (poses[i + 1] * center) - (poses[i] * center);
      if (in.norm() > 0 && out.norm() > 0 && in.dot(out) <= 0) ++summary.turns;
    }
  }
  if (summary.corner_speed.empty()) return summary;
  std::vector<double> sorted = summary.corner_speed;
  std::sort(sorted.begin(), sorted.end());
  summary.median_speed = sorted[sorted.size() / 2];
  summary.speed_95 = sorted[static_cast<std::size_t>(0.95 * static_cast<double>(sorted.size() - 1))];
  summary.max_speed = sorted.back();
  return summary;
}

}  // namespace holdfast::simulation
