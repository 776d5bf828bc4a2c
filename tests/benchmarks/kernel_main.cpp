#include <algorithm>
#include <chrono>
#include <iostream>
#include <nlohmann/json.hpp>

#include "benchmarks.hpp"
#include "device_limits.hpp"
#include "holdfast/error.hpp"
#include "holdfast/tracker.hpp"
#include "median.hpp"
#include "profile.hpp"
#include "threads.hpp"

/// holdfast_kernel_bench [--threads N]: what every kernel costs a frame, as JSON: {"<mode>/<size>": {"<kernel>":
/// {...}}}.
namespace holdfast::bench {
namespace {

constexpr int kRounds = 4;  // of a scene's path
constexpr std::size_t kCopied = 4096 * 1024;

double milliseconds_of(const auto& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

/// Pixels that a kernel computes for, which are those of whole vectors with any pixel in them that it is about.
struct ActivePixels {
  double occlusion_tests = 0, flow_constraints = 0;
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
  const auto tested = [](std::uint8_t c) { return c >= static_cast<std::uint8_t>(PixelClass::no_gradient); };
  const auto passed = [](std::uint8_t c) { return c >= static_cast<std::uint8_t>(PixelClass::rejected_vote); };
  return {whole_vectors(mask, 16, tested), whole_vectors(mask, 16, passed)};
}

nlohmann::json profile_frames(DeviceLimits& limits, const Scene& scene, const TrackerOptions& options) {
  const cl::Context context(chosen_device());
  const cl::CommandQueue queue(context, CL_QUEUE_PROFILING_ENABLE);
  Tracker tracker(scene.mesh, scene.camera, options, Device(context(), queue()));
  tracker.reset(scene.T_camera_object.front());
  const std::size_t count = scene.images.size();
  for (std::size_t i = 0; i < count; ++i) tracker.track(scene.frame(i));
  take_profile(queue);
  struct Sums {
    double calls = 0, region = 0;
    std::vector<double> milliseconds;  // a frame that the kernel ran in
  };
  std::map<std::string, Sums> sums;
  // The device's limits in the same minute: shared machines are fast now and slow then.
  std::vector<double> copy_ms, multiply_add_ms;
  limits.copy(kCopied);
  for (std::size_t i = 0; i < kRounds * count; ++i) {
    if (i % count == 0) {  // not at every frame: the caches are the tracker's again after the first
      for (int k = 0; k < 10; ++k) {
        copy_ms.push_back(milliseconds_of([&] { limits.copy(kCopied); }));
        multiply_add_ms.push_back(milliseconds_of([&] { limits.multiply_add(); }));
      }
      take_profile(queue);
    }
    tracker.track(scene.frame(i % count));
    for (const auto& [name, figures] : take_profile(queue)) {
      Sums& sum = sums[name];
      sum.calls += figures.calls;
      sum.region += figures.region;
      sum.milliseconds.push_back(figures.milliseconds);
    }
  }
  nlohmann::json kernels;
  kernels["limits"] = {{"GB_per_s", 1e-6 * limits.copied(kCopied) / median(copy_ms)},
                       {"GFLOP_per_s", 1e-6 * limits.operations() / median(multiply_add_ms)}};
  for (const auto& [name, sum] : sums) {
    // Rare kernels by the frames they run in: a median over all frames would say nothing of them.
    const double frames = static_cast<double>(sum.milliseconds.size());
    kernels[name] = {{"calls", sum.calls / frames}, {"ms", median(sum.milliseconds)}, {"region", sum.region / frames}};
  }
  if (options.quality == Quality::paper) {
    ActivePixels sum;
    for (std::size_t i = 0; i < count; ++i) {
      tracker.track(scene.frame(i));
      const ActivePixels active = active_pixels(tracker.pixel_mask());
      sum.occlusion_tests += active.occlusion_tests;
      sum.flow_constraints += active.flow_constraints;
    }
    const auto add = [&](const char* kernel, double pixels) {
      if (kernels.contains(kernel)) kernels[kernel]["active"] = pixels / static_cast<double>(count);
    };
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
    bench::DeviceLimits limits;
    nlohmann::json result;
    for (const bench::FrameSize& size : bench::kFrameSizes) {
      const bench::Scene& scene = scenes.get(size.scene());
      result["default/" + size.name()] = bench::profile_frames(limits, scene, TrackerOptions());
      result["fast/" + size.name()] = bench::profile_frames(limits, scene, TrackerOptions::fast());
      result["paper/" + size.name()] = bench::profile_frames(limits, scene, TrackerOptions::paper());
    }
    std::cout << result.dump(1) << '\n';
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "holdfast_kernel_bench: " << error.what() << '\n';
    return 1;
  }
}
