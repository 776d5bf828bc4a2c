#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "benchmarks.hpp"
#include "holdfast/tracker.hpp"
#include "median.hpp"

namespace holdfast::bench {
namespace {

/// A tracker on its way round a scene's closed path.
class Run {
 public:
  Run(const Scene& scene, const Mesh& mesh, const TrackerOptions& options)
      : scene_(scene), tracker_(mesh, scene.camera, options) {
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

  /// From a pose half a pixel off the true one: the same for whatever is compared.
  FrameResult next_refined() {
    const Pose& T_true = scene_.T_camera_object[frame_];
    Pose T_start = T_true;
    T_start.translation().x() += 0.5 * T_true.translation().z() / scene_.camera.fx;
    FrameResult result = tracker_.refine(scene_.frame(frame_), T_start);
    error_ = (result.T_camera_object.translation() - T_true.translation()).norm();
    frame_ = (frame_ + 1) % scene_.images.size();
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

template <typename Next>
void track_frames(benchmark::State& state, Run& run, const Next& next) {
  struct Figure {
    const char* name;
    double (*of)(const FrameResult& result);
    std::vector<double> values;
  };
  std::array<Figure, 11> figures{{
      {"frame_ms", [](const FrameResult& r) { return r.ms.total; }, {}},
      {"without_render_ms", [](const FrameResult& r) { return r.ms.total - r.ms.render; }, {}},
      {"upload_ms", [](const FrameResult& r) { return r.ms.upload; }, {}},
      {"render_ms", [](const FrameResult& r) { return r.ms.render; }, {}},
      {"filter_ms", [](const FrameResult& r) { return r.ms.filter; }, {}},
      {"search_ms", [](const FrameResult& r) { return r.ms.search; }, {}},
      {"solve_ms", [](const FrameResult& r) { return r.ms.solve; }, {}},
      {"contour_ms", [](const FrameResult& r) { return r.ms.contour; }, {}},
      {"solutions", [](const FrameResult& r) { return static_cast<double>(r.iterations); }, {}},
      {"used", [](const FrameResult& r) { return static_cast<double>(r.texture.used_pixels); }, {}},
      {"visible", [](const FrameResult& r) { return static_cast<double>(r.visible_pixels()); }, {}},
  }};
  double lost = 0, largest_error = 0;
  for (auto _ : state) {
    const FrameResult result = next(run);
    for (Figure& figure : figures) figure.values.push_back(figure.of(result));
    lost += result.status == Status::lost ? 1 : 0;
    largest_error = std::max(largest_error, run.error());
  }
  for (const Figure& figure : figures) state.counters[figure.name] = median(figure.values);
  state.counters["lost"] = benchmark::Counter(lost, benchmark::Counter::kAvgIterations);
  state.counters["worst_mm"] = 1e3 * largest_error;
}

constexpr auto kTrack = [](Run& run) { return run.next(); };
constexpr auto kRefine = [](Run& run) { return run.next_refined(); };

/// `pieces`: the mesh's triangles are cut into pieces x pieces.
template <typename Next>
void register_frame(const std::string& name, Scenes& scenes, const SceneOptions& options, const TrackerOptions& tracker,
                    const Next& next, int pieces = 1) {
  const auto run = std::make_shared<std::unique_ptr<Run>>();
  benchmark::RegisterBenchmark(name.c_str(),
                               [=, &scenes](benchmark::State& state) {
                                 if (!*run) {
                                   const Scene& scene = scenes.get(options);
                                   *run = std::make_unique<Run>(scene, subdivided(scene.mesh, pieces), tracker);
                                 }
                                 track_frames(state, **run, next);
                               })
      ->UseRealTime()
      ->MeasureProcessCPUTime()
      ->Unit(benchmark::kMillisecond);
}

struct NamedMode {
  const char* name;
  TrackerOptions options;
};
const std::array<NamedMode, 3>& modes() {
  static const std::array<NamedMode, 3> modes{
      {{"default", TrackerOptions()}, {"fast", TrackerOptions::fast()}, {"paper", TrackerOptions::paper()}}};
  return modes;
}

}  // namespace

void register_frames(Scenes& scenes) {
  for (const FrameSize& size : kFrameSizes) {
    for (const NamedMode& mode : modes()) {
      register_frame(std::string("frame/") + mode.name + "/" + size.name(), scenes, size.scene(), mode.options, kTrack);
    }
  }
}

void register_sweeps(Scenes& scenes) {
  for (const NamedMode& mode : modes()) {
    const auto name = [&](const char* sweep, const std::string& value) {
      return std::string(sweep) + "/" + mode.name + "/" + value;
    };
    for (const int pixels : {2000, 4000, 16000, 32000, 64000, 96000}) {
      const SceneOptions scene{640, 480, static_cast<double>(pixels), 24};
      register_frame(name("object_pixels", std::to_string(pixels)), scenes, scene, mode.options, kTrack);
    }
    for (const auto& [width, height] : {std::pair(320, 240), {640, 480}, {1280, 720}, {1920, 1080}}) {
      const SceneOptions scene{width, height, 20000, 24};
      register_frame(name("frame_size", std::to_string(width) + "x" + std::to_string(height)), scenes, scene,
                     mode.options, kTrack);
    }
    for (const int pieces : {1, 4, 16, 64, 204}) {
      const SceneOptions scene{640, 480, 32000, 24};
      register_frame(name("triangles", std::to_string(12 * pieces * pieces)), scenes, scene, mode.options, kTrack,
                     pieces);
    }
  }
  for (const int levels : {1, 2, 3, 4}) {
    TrackerOptions options;
    options.levels = levels;
    register_frame("levels/default/" + std::to_string(levels), scenes, {640, 480, 32000, 24}, options, kTrack);
  }
}

void register_occlusion(Scenes& scenes) {
  for (const FrameSize& size : kFrameSizes) {
    for (const bool on : {true, false}) {
      TrackerOptions options = TrackerOptions::paper();
      options.occlusion.gradient_test = options.occlusion.angle_test = options.occlusion.magnitude_test = on;
      options.occlusion.block_vote = on;
      register_frame(std::string("occlusion/") + (on ? "on/" : "off/") + size.name(), scenes, size.scene(), options,
                     kRefine);
    }
  }
}

}  // namespace holdfast::bench
