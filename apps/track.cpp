#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <functional>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "baking/model_completion.hpp"
#include "baking/outline_guard.hpp"
#include "baking/start_by_outline.hpp"
#include "commands.hpp"
#include "common_options.hpp"
#include "config_file.hpp"
#include "driver_start.hpp"
#include "exit_codes.hpp"
#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "holdfast/tracker.hpp"
#include "idle_options.hpp"
#include "init/guided_pose.hpp"
#include "messages.hpp"
#include "number_checks.hpp"
#include "separate_files.hpp"
#include "show/model_sheet.hpp"
#include "slow_notice.hpp"
#include "track/interruption.hpp"
#include "track/live_window.hpp"
#include "track/object_search.hpp"
#include "track/output_file.hpp"
#include "track/pipeline.hpp"
#include "track/pose_hint.hpp"
#include "track/progress.hpp"
#include "track/run_files.hpp"
#include "track/run_summary.hpp"
#include "track/track_command.hpp"
#include "track/unknown_camera.hpp"
#include "video/frame_source.hpp"
#include "video/tracker_view.hpp"
#include "window/display.hpp"

namespace holdfast {

namespace fs = std::filesystem;

namespace app {
namespace {

/// The object is held from a pose; with `by_texture` by what is printed on it, which tells sides apart.
bool is_held_from(Tracker& follower, const Pose& T_camera_object, const ImageView& view, bool by_texture) {
  try {
    follower.reset(T_camera_object);
    const FrameResult result = follower.track(view);
    if (by_texture) return result.status == Status::held && result.texture.holds;
    return detection::is_still_seen(result);  // an outline is held by chance, too, where a pose is given
  } catch (const Error&) {
    return false;  // behind the camera
  }
}

}  // namespace

Camera TrackCommand::camera_of(FrameSource& source, const Mesh& mesh) const {
  if (!camera.path.empty()) return camera.load(source.size().width, source.size().height);
  if (!quiet) print_note("no camera is given: estimating its focal length from the object");
  const detection::ModelFeatures features = recognition().features(mesh);
  const EstimatedCamera estimated =
      source.live() ? estimate_camera(features, source) : estimate_camera(features, input, source_options(), source);
  print_warning(
      fmt::format("the focal length is estimated: {:.1f} +- {:.1f} px, from {} frames; lens distortion is not "
                  "known and taken as none",
                  estimated.camera.fx, estimated.focal_sigma, estimated.frames));
  if (!camera_out.empty()) io::save_camera(camera_out, estimated.camera);
  return estimated.camera;
}

void TrackCommand::require_start(const Mesh& mesh) const {
  std::error_code unknown;
  if (mesh.has_appearance() || !init.path.empty() || !guide.empty() || fs::exists(remembered, unknown)) return;
  throw Error(
      ErrorCode::model,
      fmt::format("model '{}' has neither texture nor vertex colours to be recognized by{}: give its first pose "
                  "(--init; 'holdfast init' finds it from points), or a guide, about how it is held (--guide){}",
                  model.path.string(),
                  remembered.empty() ? "" : fmt::format(", and '{}' does not exist", remembered.string()),
                  camera.path.empty() ? ", and the camera (--camera)" : ""));
}

int TrackCommand::run() const {
  const TrackerOptions options = tracker.options();
  std::vector<fs::path> results = outputs.given();
  if (!camera_out.empty()) results.push_back(camera_out);
  if (!remembered.empty()) results.push_back(remembered);
  require_separate_files({results, {}, {completed_model}},
                         {{camera.path, init.path, guide, views, config}, {input}, {model.path}});
  if (!completed_model.empty()) {
    require_model_name(completed_model);
    require_writable(completed_model);
  }
  if (!remembered.empty()) require_writable(remembered);
  if (show) require_display("--show", "run it where there is one, or leave it out");
  start_drivers();
  FrameSource source(input, source_options());
  warn_if(source.doubt());
  if (!camera.path.empty()) (void)camera.load(source.size().width, source.size().height);
  std::optional<Pose> T_camera_object;
  if (!init.path.empty()) T_camera_object = init.load();
  std::optional<SlowNotice> notice(std::in_place, quiet ? nullptr : preparing_stream(device.options.cache_folder),
                                   kPreparing);
  // The device is opened while the model is loaded; what is missing is said first, since compiling the kernels, which
  // drivers do once a machine, cannot be broken off.
  std::error_code unknown;
  const bool there = fs::exists(model.path, unknown);
  std::future<Device> opened =
      std::async(there ? std::launch::async : std::launch::deferred, [this] { return device.open(); });
  Mesh mesh = model.load(completed_model.empty());
  Mesh given_mesh;  // kept where `mesh` becomes the completed one
  if (completed_model.empty() && !mesh.has_appearance()) tracker.refuse_for_plain();
  require_start(mesh);
  const Camera calibrated = camera_of(source, mesh);
  std::optional<Pose> T_guide;
  if (!guide.empty()) T_guide = io::load_pose(guide);
  warn_if(model_doubt(mesh));
  const bool doubts_units = warn_about_units(mesh, T_guide ? T_guide : T_camera_object, calibrated);
  if (T_guide && !doubts_units) warn_if(guide_doubt(*T_guide, mesh, calibrated));
  if (T_camera_object) require_in_view(mesh, calibrated, *T_camera_object);
  std::optional<Frame> first_frame;
  std::optional<baking::ModelCompletion> completion;
  std::optional<baking::OutlineGuard> guard;
  std::optional<Device> opened_device;
  if (!completed_model.empty()) {
    baking::CompletionOptions completing;
    completing.textures.keep = true;
    source.next(first_frame.emplace());
    if (!mesh.has_appearance() && options.contour) {
      guard.emplace(mesh, calibrated, options, opened_device.emplace(opened.get()));
      T_camera_object = start_by_outline(*guard, first_frame->image, *T_camera_object, quiet);
    }
    completion.emplace(mesh, calibrated, first_frame->image, *T_camera_object, completing);
    warn_if(completion->doubt());
    given_mesh = std::exchange(mesh, completion->model());
  }
  Tracker follower(mesh, calibrated, options, opened_device ? *opened_device : opened.get());
  if (T_camera_object) follower.reset(*T_camera_object);
  notice.reset();
  std::optional<StartSearch> start_search;
  if (T_guide) {
    const auto detector = std::make_shared<const detection::GuideDetector>(mesh, calibrated, *T_guide);
    start_search.emplace([detector](const ImageView& frame) { return detector->detect(frame); }, StartSearch::By::guide,
                         *T_guide);
  }
  // What is searched after a loss in a file may be made when it is first lost; a camera does not wait.
  const bool recovers = options.recovery && options.quality != Quality::paper && !completion && mesh.has_appearance();
  const bool recognizes = !T_camera_object && guide.empty();
  std::optional<LossSearch> loss_search;
  if (recovers || recognizes) {
    const ProposePoses recognize =
        recognition().proposer(std::make_shared<const Mesh>(mesh), calibrated, recognizes || source.live());
    if (!start_search) {
      start_search.emplace(recognize, mesh.has_appearance() ? StartSearch::By::texture : StartSearch::By::sight);
    }
    if (recovers) loss_search.emplace(recognize);
  }
  std::optional<Memory> memory;
  if (!remembered.empty()) memory.emplace(completion ? given_mesh : mesh, calibrated, recognition());
  warn_if(io::camera_warning(calibrated));
  // Until results are begun a signal may end the program at once: opening a pipe that nobody writes waits for ever.
  const Interruption interruption;
  RunFiles files(outputs, mesh, follower.camera(), source.frame_rate() / static_cast<double>(stride),
                 source.frame_count(), run_json(follower));

  std::optional<LiveWindow> window;
  if (show) window.emplace(mesh, calibrated, source.live() ? 0 : source.frame_rate() / static_cast<double>(stride));
  mesh = given_mesh = Mesh();  // their textures are not needed any more

  if (!T_camera_object && !quiet)
    print_note(guide.empty() ? "no first pose is given: looking for the object in each frame"
                             : "looking for the object near the guide in each frame");
  bool started = T_camera_object.has_value();
  SummaryBuilder figures;
  Progress progress(quiet ? nullptr : stderr, source.frame_count());
  PipelineParts parts;
  cv::Mat grey;
  parts.live = source.live();
  parts.next = [&](Frame& frame) {
    if (first_frame) {
      std::swap(frame, *first_frame);
      first_frame.reset();
      return true;
    }
    if (!source.live()) return source.next(frame);
    return read_watched([&] { return source.next(frame); }, quiet ? nullptr : stderr);
  };
  parts.is_pictured = [&](std::int64_t ordinal) { return window || files.is_pictured(ordinal); };
  const auto look = [&](TrackedFrame& tracked) {
    const ImageView view = tracker_view(tracked.frame.image, grey);
    const double time_s = tracked.frame.time_s;
    if (!started) {
      tracked.result = start_search->look(follower, view, time_s);
      started = start_search->found();
      tracked.located = tracked.result.T_camera_object.translation().z() > 0;
      if (started && !quiet) print_note(fmt::format("found in frame {}", tracked.frame.index));
      if (tracked.pictured) tracked.mask = started ? follower.pixel_mask() : PixelMask();
      return;
    }
    tracked.located = true;
    tracked.result = follower.track(view, time_s);
    // An object that is turned upon its outline is held by that, but not by its print.
    const bool is_lost = tracked.result.status == Status::lost;
    const bool unlike = tracked.result.texture.asked && !tracked.result.texture.holds;
    if (tracked.ordinal == 0 && (is_lost || unlike) && !completion) {
      const auto reading = [&](bool by_texture) {
        return pose_hint(*T_camera_object, by_texture,
                         [&](const Pose& pose) { return is_held_from(follower, pose, view, by_texture); });
      };
      // A reading that the print confirms goes before one that the outline alone holds.
      std::optional<std::string> hint;
      if (!doubts_units && tracked.result.texture.asked) hint = reading(true);
      if (!doubts_units && !hint && is_lost) hint = reading(false);
      print_warning(hint.value_or(is_lost ? lost_start(tracked.result) : held_by_outline()));
      follower.reset(*T_camera_object);
      tracked.result = follower.track(view, time_s);
    }
    const Pose T_followed = tracked.result.T_camera_object;
    if (guard) tracked.result = guard->check(follower, view, time_s, tracked.result);
    const bool by_guard = !tracked.result.T_camera_object.isApprox(T_followed, 0);  // it has no pixels to show
    if (loss_search) loss_search->look(follower, view, time_s, tracked.result);
    if (tracked.pictured) tracked.mask = by_guard ? PixelMask() : follower.pixel_mask();
    if (completion) {
      completion->update(follower, tracked.frame.image, tracked.result);
    }
  };
  parts.track = [&](TrackedFrame& tracked) {
    if (window && window->take_look_again() && start_search) {
      start_search->begin();
      started = false;
    }
    look(tracked);
    if (memory && started) memory->look(tracker_view(tracked.frame.image, grey), tracked.result);
    if (window) window->update([&] { return interruption.requested(); });
  };
  parts.write = [&](TrackedFrame& tracked) {
    if (window) window->draw(tracked);
    files.write(tracked);
    figures.add(tracked);
    progress.update(tracked.ordinal + 1, tracked.result.status == Status::held);
  };
  parts.is_interrupted = [&] { return interruption.requested() || (window && window->quits()); };
  const PipelineReport report = run_pipeline(parts);
  progress.clear();

  const std::optional<std::string> early = source.ended_early();
  RunSummary summary = figures.summary(report);
  summary.complete = summary.complete && !early;
  std::exception_ptr failure = report.failure;
  std::vector<fs::path> also_written;
  if (!camera_out.empty()) also_written.push_back(camera_out);
  const auto attempt = [&failure](const std::function<void()>& step) {
    try {
      step();
    } catch (...) {
      failure = failure ? failure : std::current_exception();
    }
  };
  attempt([&] { files.finish(summary); });
  if (memory) {
    attempt([&] {
      if (memory->save()) also_written.push_back(remembered);
    });
    warn_if(memory->doubt());
  }
  if (completion) {
    attempt([&] {
      io::save_model(completed_model, completion->model());
      also_written.push_back(completed_model);
    });
  }
  if (!quiet) {
    fmt::print("{}", summary_text(summary));
    if (completion) {
      fmt::print("  model    {:.1f} % of the surface known ({:.1f} % at the start), texture from {} frames\n",
                 100 * completion->coverage(), 100 * completion->first_coverage(), completion->frames_taken());
    }
    for (const fs::path& path : outputs.given()) {
      const bool complete = std::ranges::find(files.incomplete(), path) == files.incomplete().end();
      fmt::print("  {}  {}\n", complete ? "written" : "incomplete", path.string());
    }
    for (const fs::path& path : also_written) fmt::print("  written  {}\n", path.string());
    std::fflush(stdout);
  }
  if (failure) {
    std::rethrow_exception(failure);
  }
  if ((report.interrupted || interruption.requested()) && !(window && window->quits())) {
    return kInterrupted;
  }
  if (early) {
    print_error(*early);
    return kInput;
  }
  if (summary.held == 0 && T_camera_object) {
    print_error("the object is held in no frame: check the first pose, the model, its unit and the camera");
    return kLost;
  }
  if (summary.held == 0) {
    print_error(fmt::format(
        "the object was not found in any of {} frames: is it the model that they show, {}? A first "
        "pose (--init) needs no search",
        summary.frames, guide.empty() ? "with the texture that it has there" : "held about as the guide has it"));
    return kLost;
  }
  return require_held && summary.lost > 0 ? kLost : kOk;
}

}  // namespace app

using namespace app;

void add_track_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("track", "Follow an object through a video and write its poses");
  const auto track = std::make_shared<TrackCommand>();
  track->add_to(*command);
  command->callback([command, track, &exit_code] {
    track->check(*command);
    track->config = config_file(*command);
    track->given = command->config_to_str();
    exit_code = track->run();
  });
}

}  // namespace holdfast
