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
