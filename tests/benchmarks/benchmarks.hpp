#pragma once

#include <map>
#include <memory>
#include <string>

#include "scene.hpp"

namespace holdfast::bench {

/// Scenes shared by the benchmarks of a process, each made when the first that needs it runs.
class Scenes {
 public:
  const Scene& get(const SceneOptions& options);

 private:
  std::map<std::string, std::unique_ptr<Scene>> scenes_;
};

/// Sizes that every figure is given for, with the share of the frame that the object fills.
struct FrameSize {
  int width, height;
  double fill;
  SceneOptions scene() const { return {width, height, fill * width * height}; }
  std::string name() const { return std::to_string(width) + "x" + std::to_string(height); }
};
inline constexpr FrameSize kFrameSizes[] = {{512, 256, 0.25}, {640, 480, 0.20}, {1280, 720, 0.20}};

/// Whole frames of Tracker::track, from a frame in host memory to a pose: frame/<mode>/<size>.
void register_frames(Scenes& scenes);

/// The same against what they could depend on: object_pixels/<mode>/<n>, frame_size/<mode>/<size> (20,000 pixels of
/// object), triangles/<mode>/<n>, iterations/<mode>/<n>.
void register_sweeps(Scenes& scenes);

/// One solution from given poses, in paper mode, with and without the occlusion tests: occlusion/<on or off>/<size>.
void register_occlusion(Scenes& scenes);

/// OpenCV blurs and differentiates two whole images of the frame's size: opencv/<size>.
void register_opencv_reference();

/// What the OpenCL device can do at best: limit/copy/<KB> and limit/multiply_add.
void register_device_limits();

}  // namespace holdfast::bench
