#include <benchmark/benchmark.h>

#include <memory>

#include "benchmarks.hpp"
#include "holdfast/tracker.hpp"

namespace holdfast::bench {
namespace {

/// A tracker on its way round a scene's closed path.
class Run {
 public:
  Run(const Scene& scene, const TrackerOptions& options) : scene_(scene), tracker_(scene.mesh, scene.camera, options) {
    tracker_.reset(scene.T_camera_object.front());
    for (std::size_t i = 0; i < scene.images.size(); ++i) next();
  }

  FrameResult next() {
    FrameResult result = tracker_.track(scene_.frame(frame_));
    const Pose& T_true = scene_.T_camera_object[frame_];
    error_ = (result.T_camera_object.translation() - T_true.translation()).norm();
    frame_ = (frame_ + 1) % scene_.images.size();
    if (result.status == Status::lost) tracker_.reset(scene_.T_camera_object[frame_]);
    return result;
  }

  /// Of the last frame's translation, metres.
  double error() const { return error_; }

 private:
  const Scene& scene_;
  Tracker tracker_;
  std::size_t frame_ = 0;
  double error_ = 0;
};

void track_frames(benchmark::State& state, Run& run) {
  StageTimes sum;
  double iterations = 0, lost = 0, used = 0, visible = 0, largest_error = 0;
  for (auto _ : state) {
    const FrameResult result = run.next();
    sum.upload += result.ms.upload;
    sum.render += result.ms.render;
    sum.filter += result.ms.filter;
    sum.search += result.ms.search;
    sum.solve += result.ms.solve;
    iterations += result.iterations;
    used += result.used_pixels;
    visible += result.visible_pixels;
    lost += result.status == Status::lost ? 1 : 0;
    largest_error = std::max(largest_error, run.error());
  }
  const auto mean = [&](const char* name, double value) {
    state.counters[name] = benchmark::Counter(value, benchmark::Counter::kAvgIterations);
  };
  mean("upload_ms", sum.upload);
  mean("render_ms", sum.render);
  mean("filter_ms", sum.filter);
  mean("search_ms", sum.search);
  mean("solve_ms", sum.solve);
  mean("solutions", iterations);
  mean("used", used);
  mean("visible", visible);
  mean("lost", lost);
  state.counters["worst_mm"] = 1e3 * largest_error;
}

void register_frame(const std::string& name, Scenes& scenes, const SceneOptions& scene, const TrackerOptions& options) {
  const auto run = std::make_shared<std::unique_ptr<Run>>();
  benchmark::RegisterBenchmark(name.c_str(),
                               [run, &scenes, scene, options](benchmark::State& state) {
                                 if (!*run) *run = std::make_unique<Run>(scenes.get(scene), options);
                                 track_frames(state, **run);
                               })
      ->UseRealTime()
      ->MeasureProcessCPUTime()
      ->Unit(benchmark::kMillisecond);
}

}  // namespace

void register_frames(Scenes& scenes) {
  for (const FrameSize& size : kFrameSizes) {
    register_frame("frame/default/" + size.name(), scenes, size.scene(), TrackerOptions());
    register_frame("frame/paper/" + size.name(), scenes, size.scene(), TrackerOptions::paper());
  }
}

}  // namespace holdfast::bench
