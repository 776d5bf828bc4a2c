#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "commands.hpp"
#include "common_options.hpp"
#include "config_file.hpp"
#include "driver_start.hpp"
#include "exit_codes.hpp"
#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "messages.hpp"
#include "simulation/sequence_options.hpp"
#include "simulation/simulate_arguments.hpp"
#include "track/interruption.hpp"
#include "trackability/report.hpp"

namespace holdfast {
namespace {

using namespace simulation;

Mesh object_mesh(const SimulateArguments& arguments) {
  if (arguments.model == "box") return textured_box(arguments.box);
  return app::ModelArguments{arguments.model, arguments.model_scale}.load(arguments.report);
}

/// An object of fewer pixels across is not in the picture.
constexpr double kLeastPixels = 4;

void check_distance(const SimulateArguments& arguments, const Camera& camera, const Mesh& mesh) {
  if (arguments.distance.empty()) return;
  const auto corners = bounding_corners(mesh);
  const double diameter = (corners.back() - corners.front()).norm(), nearest = arguments.distance[0];
  const double pixels = std::max(camera.fx, camera.fy) * diameter / nearest;
  if (nearest > 0 && pixels < kLeastPixels) {
    throw Error(ErrorCode::invalid_argument,
                fmt::format("--distance: the object, {:.3g} m across, is {:.2g} pixels wide at {:.4g} m; distances are "
                            "in metres",
                            diameter, pixels, nearest));
  }
}

void print_progress(int frame, int frames, double seconds) {
  const double left = seconds / (frame + 1) * (frames - frame - 1);
  fmt::print(stderr, "\r{} of {} frames, {:.0f} s left ", frame + 1, frames, left);
  if (frame + 1 == frames) fmt::print(stderr, "\r{:60}\r", "");
}

/// The sequence's folder, with the box's model where that is what moves. Returns how many frames it came to hold.
int write_all(const SimulateArguments& arguments, const SequenceOptions& options, const Mesh& mesh,
              const std::function<void(int, const SimulatedFrame&)>& after_frame) {
  const int frames = write_sequence(Sequence(mesh, options), arguments.folder, arguments.files, after_frame);
  const std::filesystem::path model = arguments.folder / "model" / "model.obj";
  if (arguments.model != "box") {
    if (std::filesystem::exists(model) && !std::filesystem::equivalent(model, arguments.model)) {
      app::print_warning(
          fmt::format("{} is an older sequence's: 'evaluate' takes it unless --model names another", model.string()));
    }
    return frames;
  }
  std::filesystem::create_directories(model.parent_path());
  io::save_model(model, mesh);
  return frames;
}

/// Tracks what is simulated and says how that went. Frames are written as well where a folder is given.
void report(const SimulateArguments& arguments, const SequenceOptions& options, const Mesh& mesh) {
  const bool show_progress = !arguments.quiet && isatty(STDERR_FILENO) == 1;
  const auto announce = [show_progress](const std::string& what) {
    if (show_progress) fmt::print(stderr, "\r{:60}\r{}", "", what);
  };
  announce("trying what was asked for");
  const Device device;
  trackability::TrialResult asked;
  if (arguments.folder.empty()) {
    asked = trackability::run_trial(Sequence(mesh, options), mesh, device, arguments.files.threads);
  } else {
    trackability::Trial trial(mesh, options.camera, device);
    write_all(arguments, options, mesh, [&trial](int, const SimulatedFrame& frame) { trial.add(frame); });
    asked = trial.result();
  }
  const trackability::Findings findings =
      trackability::investigate(options, mesh, asked, device, arguments.files.threads, announce);
  announce("");
  fmt::print("{}", trackability::report_text(findings));
}

int run(SimulateArguments arguments) {
  if (arguments.folder.empty() && !arguments.report) {
    throw Error(ErrorCode::invalid_argument, "FOLDER is missing: where the sequence goes (--report alone needs none)");
  }
  if (arguments.report) app::start_drivers();
  const SequenceOptions options = sequence_options(arguments);
  const Mesh mesh = object_mesh(arguments);
  check_distance(arguments, options.camera, mesh);
  app::warn_about_units(mesh);
  if (arguments.report) {
    report(arguments, options, mesh);
    return app::kOk;
  }
  const Sequence sequence(mesh, options);

  const bool show_progress = !arguments.quiet && isatty(STDERR_FILENO) == 1;
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  double least_visible = 1;
  double visible_sum = 0;
  const app::Interruption interruption;
  arguments.files.is_interrupted = [&interruption] { return interruption.requested(); };
  const int written = write_all(arguments, options, mesh, [&](int i, const SimulatedFrame& frame) {
    least_visible = std::min(least_visible, frame.visible_share);
    visible_sum += frame.visible_share;
    if (show_progress) print_progress(i, sequence.size(), seconds());
  });
  if (written < sequence.size()) {
    app::print_warning(fmt::format("interrupted: {} holds the first {} of {} frames", arguments.folder.string(),
                                   written, sequence.size()));
    return app::kInterrupted;
  }
  if (visible_sum == 0) {
    app::print_warning(fmt::format(
        "the object is in no frame{}",
        arguments.trajectory.empty() ? "" : "; are the poses of --trajectory object to camera, in metres?"));
  }
  if (arguments.quiet) return app::kOk;
  const MotionSummary motion = summarize_motion(sequence.poses(), mesh, options.camera);
  fmt::print("{} frames of {}x{} in {} ({:.0f} ms a frame)\n", sequence.size(), options.camera.width,
             options.camera.height, arguments.folder.string(), 1000.0 * seconds() / sequence.size());
  fmt::print(
      "object at {:.3g} to {:.3g} m; its corners move by {:.1f} pixels a frame (median), {:.1f} (95 %), {:.1f} "
      "(most)\n",
      motion.nearest, motion.farthest, motion.median_speed, motion.speed_95, motion.max_speed);
  fmt::print("visible share {:.2f} (mean), {:.2f} (least)\n", visible_sum / sequence.size(), least_visible);
  fmt::print("can it be tracked? holdfast evaluate {}{}{}\n", arguments.folder.string(),
             arguments.model == "box" ? "" : fmt::format(" --model {}", arguments.model),
             arguments.model_scale == 1 ? "" : fmt::format(" --model-scale {}", arguments.model_scale));
  return app::kOk;
}

}  // namespace

void add_simulate_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "simulate",
      "Make a sequence with exact ground truth: a model moving before a background, with occluders, light and a\n"
      "camera's flaws. Writes frames/, K.txt, poses_gt.txt and visible.txt. --report answers whether your object can\n"
      "be tracked with your camera at your distance.");
  auto arguments = std::make_shared<SimulateArguments>();
  arguments->add_to(*command);
  app::add_config_option(*command);
  command->callback([command, arguments, &exit_code] {
    arguments->check(*command);
    exit_code = run(*arguments);
  });
}

}  // namespace holdfast
