#pragma once

#include <cmath>
#include <cstdint>

#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"
#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"

namespace holdfast::test {

inline constexpr double kDegrees = 180 / M_PI;

/// The box of the paper's experiments as its camera sees it, moving by up to `speed` pixels a frame.
inline simulation::SequenceOptions paper_camera(int frames, double speed, std::uint64_t seed) {
  simulation::SequenceOptions options;
  options.camera = {512, 256, 685, 685, 255.5, 127.5, {}};
  options.frames = frames;
  options.seed = seed;
  options.motion.speed = speed;
  options.motion.nearest = 0.6;
  options.motion.farthest = 0.9;
  options.sensor.blur_sigma = 0.5;
  options.sensor.noise = 2;
  return options;
}

inline const Mesh& box() {
  static const Mesh mesh = simulation::textured_box();
  return mesh;
}

struct PoseError {
  double millimetres = 0, degrees = 0;
};

inline PoseError pose_error(const Pose& T_true, const Pose& T_estimated) {
  return {1e3 * (T_true.translation() - T_estimated.translation()).norm(),
          kDegrees * rotation_angle(T_true.linear().transpose() * T_estimated.linear())};
}

}  // namespace holdfast::test
