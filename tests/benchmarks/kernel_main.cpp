#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "benchmarks.hpp"
#include "holdfast/error.hpp"
#include "holdfast/tracker.hpp"
#include "profile.hpp"
#include "threads.hpp"

/// holdfast_kernel_bench [--threads N]: what every kernel costs a frame, as JSON: {"<mode>/<size>": {"<kernel>":
/// {...}}}.
namespace holdfast::bench {
namespace {

constexpr int kRounds = 4;  // of a scene's path

cl::Device chosen_device() {
  const DeviceInfo info = Device().info();
  std::vector<cl::Platform> platforms;
  cl::Platform::get(&platforms);
  std::vector<cl::Device> devices;
  platforms.at(static_cast<std::size_t>(info.platform_index)).getDevices(CL_DEVICE_TYPE_ALL, &devices);
  return devices.at(static_cast<std::size_t>(info.device_index));
}

/// Pixels that a kernel computes for, which are those of whole vectors with any pixel in them that it is about.
struct ActivePixels {
  double template_planes = 0, occlusion_tests = 0, flow_constraints = 0;
};

template <typename IsWanted>
double whole_vectors(const PixelMask& mask, int lanes, const IsWanted& is_wanted) {
  double count = 0;
  for (int y = 0; y < mask.height; ++y) {
    const std::uint8_t* row = mask.classes.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(mask.width);
    for (int x = 0; x < mask.width; x += lanes) {
      if (std::any_of(row + x, row + std::min(x + lanes, mask.width), is_wanted)) count += lanes;
    }
  }
  return count;
}

/// Of one frame in paper mode, where each kernel of these runs once, at full resolution, on every row.
ActivePixels active_pixels(const PixelMask& mask) {
  const auto visible = [](std::uint8_t c) { return c != static_cast<std::uint8_t>(PixelClass::not_visible); };
  const auto tested = [](std::uint8_t c) { return c >= static_cast<std::uint8_t>(PixelClass::no_gradient); };
  const auto passed = [](std::uint8_t c) { return c >= static_cast<std::uint8_t>(PixelClass::rejected_vote); };
  return {whole_vectors(mask, 4, visible), whole_vectors(mask, 16, tested), whole_vectors(mask, 16, passed)};
}

nlohmann::json profile_frames(const Scene& scene, const TrackerOptions& options) {
  const cl::Context context(chosen_device());
  const cl::CommandQueue queue(context, CL_QUEUE_PROFILING_ENABLE);
  Tracker tracker(scene.mesh, scene.camera, options, Device(context(), queue()));
  tracker.reset(scene.T_camera_object.front());
  const std::size_t count = scene.images.size();
  for (std::size_t i = 0; i < count; ++i) tracker.track(scene.frame(i));
  take_profile(queue);
  for (std::size_t i = 0; i < kRounds * count; ++i) tracker.track(scene.frame(i % count));
  const double frames = static_cast<double>(kRounds * count);
  nlohmann::json kernels;
  for (const auto& [name, figures] : take_profile(queue)) {
    kernels[name] = {
        {"calls", figures.calls / frames}, {"ms", figures.milliseconds / frames}, {"region", figures.region / frames}};
  }
  if (options.mode == Mode::paper) {
    ActivePixels sum;
    for (std::size_t i = 0; i < count; ++i) {
      tracker.track(scene.frame(i));
      const ActivePixels active = active_pixels(tracker.pixel_mask());
      sum.template_planes += active.template_planes;
      sum.occlusion_tests += active.occlusion_tests;
      sum.flow_constraints += active.flow_constraints;
    }
    const auto add = [&](const char* kernel, double pixels) {
      if (kernels.contains(kernel)) kernels[kernel]["active"] = pixels / static_cast<double>(count);
    };
    add("template_planes", sum.template_planes);
    add("occlusion_tests", sum.occlusion_tests);
    add("flow_constraints", sum.flow_constraints);
    take_profile(queue);
  }
  return kernels;
}

}  // namespace
}  // namespace holdfast::bench

int main(int argc, char** argv) {
  using namespace holdfast;
  try {
    bench::use_threads(argc, argv);
    bench::Scenes scenes;
    nlohmann::json result;
    for (const bench::FrameSize& size : bench::kFrameSizes) {
      const bench::Scene& scene = scenes.get(size.scene());
      result["default/" + size.name()] = bench::profile_frames(scene, TrackerOptions());
      result["paper/" + size.name()] = bench::profile_frames(scene, TrackerOptions::paper());
    }
    std::cout << result.dump(1) << '\n';
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "holdfast_kernel_bench: " << error.what() << '\n';
    return 1;
  }
}
