#include "simulation/occluder.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "holdfast/error.hpp"
#include "simulation/random.hpp"
#include "simulation/textured_box.hpp"

namespace holdfast::simulation {
namespace {

struct ObjectTrack {
  std::vector<Eigen::Vector3d> centers;  // camera frame, one a frame
  double radius = 0;
};

ObjectTrack track_of(const Mesh& object, const PoseAt& motion, int frames) {
  const auto corners = bounding_corners(object);
  const Eigen::Vector3d center = 0.5 * (corners.front() + corners.back());
  ObjectTrack track;
  track.radius = (corners.back() - center).norm();
  for (int i = 0; i < frames; ++i) track.centers.push_back(motion(i) * center);
  return track;
}

Occluder make_bar(const OccluderOptions& o, const ObjectTrack& track, const Camera& camera, int frames) {
  if (!(o.bar_width > 0) || o.sweeps < 0 || !(o.bar_distance > 0)) {
    throw Error(ErrorCode::invalid_argument,
                "occluder bar: width and distance must be positive and the number of sweeps not negative");
  }
  double nearest = track.centers.front().z() - track.radius;
  for (const Eigen::Vector3d& center : track.centers) nearest = std::min(nearest, center.z() - track.radius);
  const double z = o.bar_distance * nearest;
  if (!(z > 0.01)) {
    throw Error(ErrorCode::invalid_argument,
                "occluder bar: no room before the object; let the object keep a larger distance");
  }
  const double thickness = std::min(0.005, 0.05 * z);
  const Eigen::Vector3d size(o.bar_width * z / camera.fx, 2.0 * camera.height * z / camera.fy, thickness);
  const Mesh mesh = plain_box(size, o.bar_color);
  const double left = -0.5 * o.bar_width - 4;
  const double right = camera.width + 0.5 * o.bar_width + 4;
  const auto at = [=, o = o](double frame) {
    double column = o.bar_column;
    if (o.sweeps > 0) {
      const double pass = std::clamp(frame / std::max(1, frames - 1), 0.0, 1.0) * o.sweeps;
      const double share = 1.0 - std::abs(1.0 - std::fmod(pass, 2.0));
      column = left + share * (right - left);
    }
    Pose pose = Pose::Identity();
    // The front is at distance z, so that the bar is as wide in pixels as asked for.
    pose.translation() = Eigen::Vector3d((column - camera.cx) / camera.fx * z, 0, z + 0.5 * thickness);
    return pose;
  };
  return {DrawnMesh(mesh), bounding_corners(mesh), at, o.finish};
}

// A curve through points at given times (cubic Hermite, slopes from the neighbours).
Eigen::Vector2d curve(const std::vector<std::pair<double, Eigen::Vector2d>>& keys, double time) {
  if (time <= keys.front().first) return keys.front().second;
  if (time >= keys.back().first) return keys.back().second;
  std::size_t i = 0;
  while (keys[i + 1].first < time) ++i;
  const auto slope = [&](std::size_t k) -> Eigen::Vector2d {
    const auto& before = keys[k == 0 ? 0 : k - 1];
    const auto& after = keys[std::min(k + 1, keys.size() - 1)];
    return (after.second - before.second) / (after.first - before.first);
  };
  const double step = keys[i + 1].first - keys[i].first;
  const double s = (time - keys[i].first) / step;
  const Eigen::Vector2d& a = keys[i].second;
  const Eigen::Vector2d& b = keys[i + 1].second;
  return a * (2 * s * s * s - 3 * s * s + 1) + b * (3 * s * s - 2 * s * s * s) +
         step * (slope(i) * (s * s * s - 2 * s * s + s) + slope(i + 1) * (s * s * s - s * s));
}

Occluder make_cube(const OccluderOptions& o, const ObjectTrack& track, int frames, std::uint64_t seed) {
  if (!(o.cube_size > 0) || !(o.cube_distance > 0)) {
    throw Error(ErrorCode::invalid_argument, "occluder cube: size and distance must be positive");
  }
  const double leave = o.leave_frame >= 0 ? o.leave_frame : std::max(0.87 * frames, frames - 40.0);
  const double cover =
      o.cover_frame >= 0 ? o.cover_frame : std::min(0.87 * leave, frames - 75.0 > 0.5 * leave ? frames - 75.0 : leave);
  if (!(cover < leave)) {
    throw Error(ErrorCode::invalid_argument,
                "occluder cube: it must cover the object before it leaves; check both frames");
  }
  // Offsets from the object's centre in units of the object's radius as seen in the image.
  const std::vector<std::pair<double, Eigen::Vector2d>> keys = {
      {0.0, {-5.0, -1.0}},          {0.15 * cover, {-1.4, -0.5}},
      {0.30 * cover, {-0.7, 1.0}},  {0.44 * cover, {0.5, 1.3}},
      {0.57 * cover, {1.2, 0.2}},   {0.70 * cover, {0.5, -1.0}},
      {0.84 * cover, {-0.9, -0.3}}, {0.95 * cover, {-0.15, 0.0}},
      {cover, {0.0, 0.0}},          {cover + 0.15 * (leave - cover), {0.1, 0.0}},
      {leave, {5.0, -1.5}}};
  // It follows the object's way only roughly: smoothed over half a second.
  std::vector<Eigen::Vector3d> smooth;
  constexpr int reach = 12;
  for (int i = 0; i < frames; ++i) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weights = 0;
    for (int k = -reach; k <= reach; ++k) {
      const double weight = std::exp(-0.5 * k * k / 25.0);
      sum += weight * track.centers[static_cast<std::size_t>(std::clamp(i + k, 0, frames - 1))];
      weights += weight;
    }
    smooth.push_back(sum / weights);
  }
  const double edge = o.cube_size * o.cube_distance * 2.0 * track.radius;
  const Mesh mesh = lettered_cube(edge, seed);
  Random random(seed, 0xc0be);
  const Eigen::Vector3d axis =
      Eigen::Vector3d(random.uniform(-1, 1), random.uniform(0.5, 1), random.uniform(-0.4, 0.4)).normalized();
  const double start = random.uniform(0, 6.28);
  const auto at = [=, o = o](double frame) {
    const double clamped = std::clamp(frame, 0.0, frames - 1.0);
    const std::size_t i = static_cast<std::size_t>(clamped);
    const std::size_t j = std::min(i + 1, smooth.size() - 1);
    const Eigen::Vector3d center = smooth[i] + (clamped - static_cast<double>(i)) * (smooth[j] - smooth[i]);
    const Eigen::Vector2d offset = curve(keys, clamped) * track.radius;
    Pose pose = Pose::Identity();
    pose.linear() =
        Eigen::AngleAxisd(start + 0.035 * frame, axis) * Eigen::Vector3d(1, -1, -1).asDiagonal().toDenseMatrix();
    pose.translation() = o.cube_distance * (center + Eigen::Vector3d(offset.x(), offset.y(), 0));
    return pose;
  };
  return {DrawnMesh(mesh), bounding_corners(mesh), at, o.finish};
}

}  // namespace

Occluder make_occluder(const OccluderOptions& options, const Mesh& object, const PoseAt& object_motion,
                       const Camera& camera, int frames, std::uint64_t seed) {
  if (options.kind == OccluderKind::mesh) {
    DrawnMesh mesh(options.mesh);
    return {std::move(mesh), bounding_corners(options.mesh), motion_through(options.T_camera_mesh), options.finish};
  }
  const ObjectTrack track = track_of(object, object_motion, frames);
  if (options.kind == OccluderKind::bar) return make_bar(options, track, camera, frames);
  return make_cube(options, track, frames, seed);
}

}  // namespace holdfast::simulation
