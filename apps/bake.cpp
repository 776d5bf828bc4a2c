#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "baking/model_completion.hpp"
#include "baking/outline_guard.hpp"
#include "baking/posed_frames.hpp"
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
#include "messages.hpp"
#include "number_checks.hpp"
#include "separate_files.hpp"
#include "track/interruption.hpp"
#include "track/output_file.hpp"
#include "track/pose_hint.hpp"
#include "track/progress.hpp"
#include "video/frame_source.hpp"
#include "video/tracker_view.hpp"

namespace holdfast {
namespace {

namespace fs = std::filesystem;

using namespace app;

/// What a run came to.
struct BakeReport {
  Mesh model;
  double first_coverage = 0;  ///< after the first frame
  double coverage = 0;
  std::int64_t frames = 0;
  std::int64_t taken = 0;
  std::int64_t lost = 0;
  bool interrupted = false;
  double seconds = 0;
  std::optional<std::string> ended_early;
};

struct BakeCommand {
  std::vector<std::string> inputs;
  ModelArguments model;
  CameraArguments camera;
  InitPoseArguments init;
  fs::path poses;
  fs::path out;
  DeviceArguments device;
  TrackerArguments tracker;
  std::int64_t start = 0;
  std::optional<std::int64_t> stop;
  baking::CompletionOptions options;
  bool keep_pose = false;
  bool padding_given = false;
  bool every_given = false;
  fs::path config;
  bool quiet = false;

  void add_to(CLI::App& command);
  int run() const;

 private:
  void check_arguments() const;
  Mesh load_mesh() const;
  BakeReport bake_tracked() const;
  BakeReport bake_posed() const;
  void print(const BakeReport& report) const;
};

void BakeCommand::add_to(CLI::App& command) {
  command
      .add_option("input", inputs,
                  "Video file, image folder or image pattern, or several images (then with --poses, a pose each)")
      ->required()
      ->type_name("INPUT...");
  command.add_option("--out", out, "Model to write (.obj; .mtl and .png go beside it)")->required()->type_name("FILE");
  model.add_to(command);
  camera.add_to(command);
  init.add_to(command, false);
  command
      .add_flag(
          "--keep-pose", keep_pose,
          "Take the first pose as it is given and follow the texture alone: for models whose proportions are only "
          "about right, so that their outline misleads")
      ->group("Object and camera");

  constexpr const char* frames_group = "Frames";
  command
      .add_option("--poses", poses,
                  "Instead of --init: poses of the inputs, or of frames of the one input: the table of "
                  "'holdfast track', 3x4 or 4x4 a line, or TUM")
      ->type_name("FILE")
      ->group(frames_group);
  command.add_option("--start", start, "First frame, the one that --init is the pose in [0]")
      ->type_name("N")
      ->group(frames_group);
  command.add_option("--stop", stop, "First frame not looked at any more [end]")->type_name("N")->group(frames_group);
  command
      .add_option("--every", options.every,
                  "Take texture from every N-th frame; with --init, from all of the first twenty; of several images, "
                  "from all unless it is given")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str()
      ->type_name("N")
      ->group(frames_group);
  command.add_option("--margin", options.bake.margin, "Pixels left out at the object's contour")
      ->check(CLI::Range(1, 100))
      ->capture_default_str()
      ->type_name("PIXELS")
      ->group(frames_group);

  constexpr const char* texture_group = "Texture";
  baking::TextureOptions& textures = options.textures;
  command
      .add_option("--texels-per-metre", textures.texels_per_metre,
                  "Texture resolution [the camera's, where the object is nearest at the first pose]")
      ->check(positive_number())
      ->type_name("N")
      ->group(texture_group);
  command.add_option("--padding", textures.padding, "Texels round each chart of an unwrapped model")
      ->check(CLI::Range(1, 64))
      ->capture_default_str()
      ->type_name("N")
      ->group(texture_group);
  command.add_option("--largest-texture", textures.largest_size, "Most texels a side")
      ->check(CLI::Range(64, 16384))
      ->capture_default_str()
      ->type_name("N")
      ->group(texture_group);
  command.add_flag("--unwrap", textures.unwrap, "New texture coordinates, although the model has some")
      ->group(texture_group);
  command.add_flag("--quiet", quiet, "No progress and no summary")->group("Results");

  device.add_to(command);
  tracker.add_to(command);
  add_config_option(command);
}

void BakeCommand::check_arguments() const {
  const auto refuse = [](const std::string& what) { throw Error(ErrorCode::invalid_argument, what); };
  if (init.path.empty() == poses.empty()) {
    refuse("give either --init, the pose in the first frame, or --poses, poses of all frames");
  }
  if (!init.path.empty() && inputs.size() > 1) {
    refuse("several inputs need --poses, with a pose for each; --init is for one video or one image");
  }
  require_model_name(out);
  require_separate_files({{}, {}, {out}}, {{camera.path, init.path, poses, config}, inputs, {model.path}});
  require_writable(out);
}

Mesh BakeCommand::load_mesh() const {
  Mesh mesh = model.load();
  if (padding_given && !options.textures.unwrap && !mesh.texture_coordinates.empty()) {
    throw Error(ErrorCode::invalid_argument,
                "--padding has no effect on the texture coordinates that the model has: add --unwrap for new ones, or "
                "leave --padding out");
  }
  return mesh;
}

/// A bake starts from nothing but the shape; textures only lend their proportions to coordinates that stay.
BakeReport BakeCommand::bake_tracked() const {
  FrameSourceOptions source_options;
  source_options.start = start;
  source_options.stop = stop;
  FrameSource source(inputs.front(), source_options);
  warn_if(source.doubt());
  const Camera calibrated = camera.load(source.size().width, source.size().height);
  warn_if(io::camera_warning(calibrated));
  const Mesh mesh = load_mesh();
  const Pose T_given = init.load();
  warn_about_units(mesh, T_given, calibrated);
  require_in_view(mesh, calibrated, T_given);
  const TrackerOptions tracker_options = tracker.options();

  BakeReport report;
  Frame frame;
  source.next(frame);
  std::optional<Device> opened;
  std::optional<baking::OutlineGuard> guard;
  if (!keep_pose && tracker_options.contour) {
    guard.emplace(mesh, calibrated, tracker_options, opened.emplace(device.open()));
  }
  const Pose T_camera_object = guard ? start_by_outline(*guard, frame.image, T_given, quiet) : T_given;
  baking::ModelCompletion completion(mesh, calibrated, frame.image, T_camera_object, options);
  warn_if(completion.doubt());
  Progress progress(quiet ? nullptr : stderr, source.frame_count());
  const Interruption interruption;
  std::optional<Tracker> follower;
  cv::Mat grey;
  for (;;) {
    ++report.frames;
    progress.update(report.frames, true);
    if (!source.next(frame)) {
      break;
    }
    if (interruption.requested()) {
      report.interrupted = true;
      break;
    }
    if (!follower) {  // a single image needs none
      follower.emplace(completion.model(), calibrated, tracker_options, opened ? *opened : device.open());
      follower->reset(T_camera_object);
    }
    const ImageView view = tracker_view(frame.image, grey);
    FrameResult result = follower->track(view);
    if (guard) result = guard->check(*follower, view, std::nullopt, result);
    report.lost += result.status == Status::lost ? 1 : 0;
    completion.update(*follower, frame.image, result);
  }
  progress.clear();
  report.ended_early = source.ended_early();
  report.model = completion.model();
  report.first_coverage = completion.first_coverage();
  report.coverage = completion.coverage();
  report.taken = completion.frames_taken();
  return report;
}

BakeReport BakeCommand::bake_posed() const {
  FrameSourceOptions source_options;
  source_options.start = start;
  source_options.stop = stop;
  PosedFrames frames(inputs, poses, source_options);
  const Camera calibrated = camera.load(frames.size().width, frames.size().height);
  warn_if(io::camera_warning(calibrated));
  const Mesh mesh = load_mesh();
  // Images that were chosen one by one are all wanted.
  const int every = every_given || inputs.size() == 1 ? options.every : 1;
  BakeReport report;
  std::optional<baking::TextureBaker> baker;
  Progress progress(quiet ? nullptr : stderr, frames.count());
  const Interruption interruption;
  Frame frame;
  Pose T_camera_object;
  while (frames.next(frame, T_camera_object)) {
    if (interruption.requested()) {
      report.interrupted = true;
      break;
    }
    if (report.frames++ % every != 0) {
      continue;
    }
    if (!baker) {
      warn_about_units(mesh, T_camera_object, calibrated);
      baker.emplace(baking::make_baker(mesh, calibrated, T_camera_object, options.textures, options.bake));
      warn_if(baking::coordinate_doubt(*baker));
    }
    report.taken += baker->add_frame(frame.image, T_camera_object, baking::PoseSource::given).taken ? 1 : 0;
    report.first_coverage = report.frames == 1 ? baker->coverage() : report.first_coverage;
    progress.update(report.frames, true);
  }
  progress.clear();
  if (!baker) {
    throw Error(ErrorCode::pose, fmt::format("'{}' has no pose for any frame of the input", poses.string()));
  }
  if (baker->coverage() == 0) {
    throw Error(ErrorCode::pose, fmt::format("no frame shows any of the model at the poses of '{}': check their unit "
                                             "(metres) and axes (x right, y down, z forward)",
                                             poses.string()));
  }
  report.model = baker->model();
  report.coverage = baker->coverage();
  return report;
}

void BakeCommand::print(const BakeReport& report) const {
  fmt::print("{:.1f} % of the surface known ({:.1f} % from the first frame), texture from {} of {} frames",
             100 * report.coverage, 100 * report.first_coverage, report.taken, report.frames);
  fmt::print("{}\n", report.lost > 0 ? fmt::format(", lost in {}", report.lost) : std::string());
  for (const Material& material : report.model.materials) {
    fmt::print("  texture  {}x{} texels\n", material.texture.width, material.texture.height);
  }
  fmt::print("  time     {:.1f} s\n  written  {}\n", report.seconds, out.string());
  std::fflush(stdout);
}

int BakeCommand::run() const {
  check_arguments();
  if (poses.empty()) start_drivers();
  const auto begin = std::chrono::steady_clock::now();
  BakeReport report = poses.empty() ? bake_tracked() : bake_posed();
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  io::save_model(out, report.model);
  if (!quiet) {
    print(report);
  }
  if (report.interrupted) {
    return kInterrupted;
  }
  if (report.ended_early) {
    print_error(*report.ended_early);
    return kInput;
  }
  return kOk;
}

}  // namespace

void add_bake_command(CLI::App& app, int& exit_code) {
  CLI::App* command =
      app.add_subcommand("bake", "Give a model the texture that a video or frames with poses show of it");
  const auto bake = std::make_shared<BakeCommand>();
  bake->add_to(*command);
  command->callback([command, bake, &exit_code] {
    refuse_beside(*command, {"--start", "--stop"}, bake->inputs.size() > 1, "several inputs");
    refuse_beside(*command, {"--keep-pose"}, !bake->poses.empty(), "--poses");
    refuse_beside(*command, {"Tracker"}, !bake->poses.empty(), "--poses, which tracks nothing");
    bake->padding_given = is_given(*command, "--padding");
    bake->every_given = is_given(*command, "--every");
    bake->config = config_file(*command);
    exit_code = bake->run();
  });
}

}  // namespace holdfast
