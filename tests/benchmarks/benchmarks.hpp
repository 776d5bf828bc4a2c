#pragma once

#include <map>
#include <memory>
#include <string>

#include "scene.hpp"

namespace holdfast::bench {

/// What all benchmarks of a process share: scenes made once, when the first benchmark that needs one runs.
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

/// OpenCV blurs and differentiates two whole images of the frame's size: opencv/<size>.
void register_opencv_reference();

}  // namespace holdfast::bench
