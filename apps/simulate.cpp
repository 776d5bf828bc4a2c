#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "commands.hpp"
#include "common_options.hpp"
#include "config_file.hpp"
#include "driver_start.hpp"
#include "exit_codes.hpp"
#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "idle_options.hpp"
#include "messages.hpp"
#include "number_checks.hpp"
#include "simulation/sequence.hpp"
#include "simulation/sequence_files.hpp"
#include "simulation/textured_box.hpp"
#include "track/interruption.hpp"
#include "trackability/report.hpp"

namespace holdfast {
namespace {

using namespace simulation;

constexpr double radians_a_degree = std::numbers::pi / 180.0;

struct SimulateArguments {
  std::filesystem::path folder;
  SequenceOptions sequence;
  SequenceFileOptions files;
  BoxOptions box;
  bool quiet = false;
  bool report = false;
  bool frames_given = false;

  std::string model = "box";
  double model_scale = 1;
  std::filesystem::path camera;
  std::string size = "640x480";
  bool size_given = false;
  double view_angle = 0;
  bool rescale_camera = false;

  std::string motion = "smooth";
  std::vector<double> distance;  // nearest, farthest
  double rotation_degrees = 35;
  std::vector<double> orientation;  // yaw, pitch, roll, degrees
  std::filesystem::path trajectory;

  std::vector<std::string> occluders;
  OccluderOptions occluder;  // what all bars and cubes share
  std::vector<std::string> occluder_models;
  std::vector<std::string> occluder_trajectories;
  double occluder_scale = 1;

  std::vector<std::string> lights;
  std::vector<double> light_orbit;  // radius, frames a turn
};

// "a<separator>b...": exactly `count` numbers.
std::vector<double> numbers_in(const std::string& text, char separator, std::size_t count, const std::string& option,
                               const std::string& wanted) {
  std::vector<double> numbers;
  const std::vector<std::string> parts = CLI::detail::split(text, separator);
  for (const std::string& part : parts) {
    double number = 0;
    if (!CLI::detail::lexical_cast(part, number)) break;
    numbers.push_back(number);
  }
  if (numbers.size() != count || parts.size() != count) {
    throw Error(ErrorCode::invalid_argument, fmt::format("{}: '{}' is not {}", option, text, wanted));
  }
  return numbers;
}

Mesh object_mesh(const SimulateArguments& arguments) {
  if (arguments.model == "box") return textured_box(arguments.box);
  return io::load_model(arguments.model, arguments.model_scale);
}

Camera camera_of(const SimulateArguments& arguments) {
  const std::vector<double> size = numbers_in(arguments.size, 'x', 2, "--size", "WIDTHxHEIGHT, for example 640x480");
  const int width = static_cast<int>(size[0]);
  const int height = static_cast<int>(size[1]);
  if (width < 16 || height < 16 || width > 8192 || height > 8192) {
    throw Error(ErrorCode::invalid_argument, "--size: width and height must be 16 to 8192 pixels");
  }
  if (!arguments.camera.empty()) {
    const Camera camera = io::load_camera(arguments.camera);
    // A calibration brings its own size; the default must not contradict it.
    if (camera.width > 0 && !arguments.size_given) return camera;
    return io::camera_for_frames(camera, width, height, arguments.rescale_camera);
  }
  const double angle = arguments.view_angle > 0 ? arguments.view_angle : 52.4;
  const double focal = 0.5 * width / std::tan(0.5 * angle * radians_a_degree);
  return {width, height, focal, focal, 0.5 * (width - 1), 0.5 * (height - 1), {}};
}

MotionOptions motion_of(const SimulateArguments& arguments) {
  MotionOptions motion = arguments.sequence.motion;
  motion.style = arguments.motion == "sharp"   ? MotionStyle::sharp
                 : arguments.motion == "still" ? MotionStyle::still
                                               : MotionStyle::smooth;
  if (!arguments.distance.empty()) {
    motion.nearest = arguments.distance[0];
    motion.farthest = arguments.distance[1];
  }
  motion.rotation_range = arguments.rotation_degrees * radians_a_degree;
  if (!arguments.orientation.empty()) {
    const Eigen::Matrix3d upright = Eigen::Vector3d(1, -1, -1).asDiagonal();
    motion.orientation = Eigen::AngleAxisd(arguments.orientation[2] * radians_a_degree, Eigen::Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(arguments.orientation[1] * radians_a_degree, Eigen::Vector3d::UnitX()) *
                         Eigen::AngleAxisd(arguments.orientation[0] * radians_a_degree, Eigen::Vector3d::UnitY()) *
                         upright;
  }
  if (!arguments.trajectory.empty()) motion.T_camera_object = io::load_poses(arguments.trajectory);
  return motion;
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

/// Options that would change nothing in the frames asked for.
void refuse_idle_options(const CLI::App& command, const SimulateArguments& a) {
  const auto beside = [&](std::initializer_list<const char*> options, bool given, const std::string& what) {
    app::refuse_beside(command, options, given, what);
  };
  const auto without = [&](std::initializer_list<const char*> options, bool given, const std::string& what) {
    app::refuse_without(command, options, given, what);
  };
  const auto among = [](const std::vector<std::string>& kinds, const char* kind) {
    return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
  };
  beside({"--speed", "--turns", "--ease", "--distance", "--rotation", "--orientation"}, !a.trajectory.empty(),
         "--trajectory");
  beside({"--speed", "--rotation"}, a.motion == "still", "--motion still");
  without({"--turns", "--ease"}, a.motion == "sharp", "--motion sharp");

  const bool box = a.model == "box";
  beside({"--model-scale"}, box, "--model box");
  without({"--box-contrast"}, box, "--model box");
  without({"--box-seed"}, box || among(a.occluder_models, "box"), "--model box");
  without({"--rescale-camera"}, a.size_given, "--size");
  without({"--masks", "--overwrite"}, !a.folder.empty(), "FOLDER");

  without({"--bar-width", "--bar-sweeps"}, among(a.occluders, "bar"), "--occluder bar");
  without({"--cube-size"}, among(a.occluders, "cube"), "--occluder cube");
  const bool meshes = std::any_of(a.occluder_models.begin(), a.occluder_models.end(),
                                  [](const std::string& model) { return model != "box"; });
  without({"--occluder-scale"}, meshes, "--occluder-model FILE");

  without({"--shininess"}, a.sequence.lighting.finish.specular > 0, "--specular");
  const SensorOptions& sensor = a.sequence.sensor;
  without({"--change-frames"}, sensor.exposure_stops != 0 || sensor.white_balance_stops != 0 || sensor.gamma_stops != 0,
          "--exposure, --white-balance or --gamma");
}

/// A pose a frame, or a single one of what stands still.
void require_poses(std::size_t poses, int frames, const std::filesystem::path& file) {
  if (poses > 1 && poses < static_cast<std::size_t>(frames)) {
    throw Error(ErrorCode::file, fmt::format("{}: {} poses for {} frames; give one a frame, or a single one",
                                             file.string(), poses, frames));
  }
}

std::vector<OccluderOptions> occluders_of(const SimulateArguments& arguments, int frames) {
  std::vector<OccluderOptions> occluders;
  for (const std::string& name : arguments.occluders) {
    occluders.push_back(arguments.occluder);
    occluders.back().kind = name == "bar" ? OccluderKind::bar : OccluderKind::cube;
  }
  if (arguments.occluder_models.size() != arguments.occluder_trajectories.size()) {
    throw Error(ErrorCode::invalid_argument,
                "--occluder-model: each needs its --occluder-trajectory, in the same order");
  }
  for (std::size_t i = 0; i < arguments.occluder_models.size(); ++i) {
    OccluderOptions occluder;
    occluder.kind = OccluderKind::mesh;
    occluder.mesh = arguments.occluder_models[i] == "box"
                        ? textured_box({.seed = arguments.box.seed + 1})
                        : io::load_model(arguments.occluder_models[i], arguments.occluder_scale);
    occluder.T_camera_mesh = io::load_poses(arguments.occluder_trajectories[i]);
    require_poses(occluder.T_camera_mesh.size(), frames, arguments.occluder_trajectories[i]);
    occluders.push_back(std::move(occluder));
  }
  return occluders;
}

LightingOptions lighting_of(const SimulateArguments& arguments) {
  LightingOptions lighting = arguments.sequence.lighting;
  if (!arguments.lights.empty()) lighting.lights.clear();
  for (const std::string& text : arguments.lights) {
    const auto values = numbers_in(text, ',', 4, "--light", "X,Y,Z,INTENSITY in metres, for example -0.6,-1,-0.3,0.65");
    LightOptions light;
    light.position = {values[0], values[1], values[2]};
    light.intensity = values[3];
    lighting.lights.push_back(light);
  }
  for (LightOptions& light : lighting.lights) {
    if (arguments.light_orbit.empty()) continue;
    if (!(arguments.light_orbit[1] > 0)) {
      throw Error(ErrorCode::invalid_argument, "--light-orbit: the frames of a turn must be above 0");
    }
    light.orbit_radius = arguments.light_orbit[0];
    light.orbit_frames = arguments.light_orbit[1];
  }
  return lighting;
}

void print_progress(int frame, int frames, double seconds) {
  const double left = seconds / (frame + 1) * (frames - frame - 1);
  fmt::print(stderr, "\r{} of {} frames, {:.0f} s left ", frame + 1, frames, left);
  if (frame + 1 == frames) fmt::print(stderr, "\r{:60}\r", "");
}

SequenceOptions sequence_options(const SimulateArguments& arguments) {
  SequenceOptions options = arguments.sequence;
  options.camera = camera_of(arguments);
  options.motion = motion_of(arguments);
  if (!options.motion.T_camera_object.empty() && !arguments.frames_given) {
    options.frames = static_cast<int>(options.motion.T_camera_object.size());
  }
  require_poses(options.motion.T_camera_object.size(), options.frames, arguments.trajectory);
  options.occluders = occluders_of(arguments, options.frames);
  options.lighting = lighting_of(arguments);
  return options;
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
  if (arguments.report) app::require_named_materials(mesh, arguments.model);
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

void add_sequence_options(CLI::App& command, SimulateArguments& a) {
  const char* group = "Sequence";
  command.add_option("--frames", a.sequence.frames, "Number of frames; with --trajectory: all its poses")
      ->check(CLI::Range(1, 1000000))
      ->type_name("N")
      ->capture_default_str()
      ->group(group);
  command.add_option("--seed", a.sequence.seed, "Another number, another motion, background and noise")
      ->type_name("N")
      ->capture_default_str()
      ->group(group);
  command.add_flag("--masks", a.files.masks, "Write the occluders' masks too")->group(group);
  command.add_flag("--overwrite", a.files.overwrite, "Replace a sequence that FOLDER already holds")->group(group);
  command
      .add_option("--threads", a.files.threads, "Frames drawn at a time; 0: one a core. Changes nothing in the frames")
      ->check(CLI::Range(0, 256))
      ->type_name("N")
      ->capture_default_str()
      ->group(group);
  command.add_flag("--quiet", a.quiet, "No progress and no summary")->group(group);
}

void add_object_options(CLI::App& command, SimulateArguments& a) {
  const char* group = "Object and camera";
  command.add_option("--model", a.model, "Model file, or 'box': a printed cardboard box of 200 x 150 x 80 mm")
      ->type_name("FILE|box")
      ->capture_default_str()
      ->group(group);
  command.add_option("--model-scale", a.model_scale, "The model's unit in metres: 0.001 for millimetres")
      ->check(app::positive_number())
      ->type_name("FACTOR")
      ->capture_default_str()
      ->group(group);
  command.add_option("--box-seed", a.box.seed, "Another number, another print on the box")
      ->type_name("N")
      ->capture_default_str()
      ->group(group);
  command.add_option("--box-contrast", a.box.contrast, "Of the box's print: 0 is plain cardboard")
      ->check(CLI::Range(0.0, 1.0))
      ->type_name("SHARE")
      ->capture_default_str()
      ->group(group);
  CLI::Option* camera = command.add_option("--camera", a.camera, "Calibration file; its lens distortion is simulated")
                            ->type_name("FILE")
                            ->group(group);
  command.add_option("--size", a.size, "Size of the frames where the calibration names none")
      ->type_name("WxH")
      ->capture_default_str()
      ->group(group);
  command.add_flag("--rescale-camera", a.rescale_camera, "--size is the calibration's view at another size")
      ->needs(camera)
      ->group(group);
  command.add_option("--view-angle", a.view_angle, "Horizontal, degrees, where there is no calibration [52.4]")
      ->check(CLI::Range(1.0, 170.0))
      ->type_name("DEG")
      ->excludes(camera)
      ->group(group);
}

void add_motion_options(CLI::App& command, SimulateArguments& a) {
  const char* group = "Motion";
  CLI::Option* motion =
      command.add_option("--motion", a.motion, "smooth, sharp (straight lines and sudden turns) or still")
          ->check(CLI::IsMember({"smooth", "sharp", "still"}))
          ->type_name("STYLE")
          ->capture_default_str()
          ->group(group);
  command
      .add_option("--speed", a.sequence.motion.speed,
                  "Pixels a frame of the fastest corner: 95 % of the frames keep to it")
      ->check(app::positive_number())
      ->type_name("PX")
      ->capture_default_str()
      ->group(group);
  command.add_option("--turns", a.sequence.motion.turns, "sharp: turns by 90 degrees or more, at least")
      ->check(CLI::Range(0, 100000))
      ->type_name("N")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--ease", a.sequence.motion.ease,
                  "sharp: frames to get up to speed, at the start and after each turn; 0: turns at full speed")
      ->check(CLI::Range(0, 10000))
      ->type_name("N")
      ->capture_default_str()
      ->group(group);
  command.add_option("--distance", a.distance, "Nearest and farthest distance, metres [so that it fits the frame]")
      ->expected(2)
      ->delimiter(',')
      ->type_name("NEAR,FAR")
      ->group(group);
  command.add_option("--rotation", a.rotation_degrees, "Farthest turn from the middle orientation, degrees")
      ->check(CLI::Range(0.0, 180.0))
      ->type_name("DEG")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--orientation", a.orientation,
                  "Middle orientation, degrees; 0,0,0: y up, +z to the camera [32,23,0]")
      ->expected(3)
      ->delimiter(',')
      ->type_name("YAW,PITCH,ROLL")
      ->group(group);
  command.add_option("--trajectory", a.trajectory, "File of poses, one a frame, instead of a made motion")
      ->type_name("FILE")
      ->excludes(motion)
      ->group(group);
}

void add_occluder_options(CLI::App& command, SimulateArguments& a) {
  const char* group = "Occluders";
  command
      .add_option("--occluder", a.occluders, "bar (white, sweeps across) or cube (lettered, passes, covers, leaves)")
      ->check(CLI::IsMember({"bar", "cube"}))
      ->allow_extra_args(false)
      ->type_name("KIND")
      ->group(group);
  command.add_option("--bar-width", a.occluder.bar_width, "Pixels")
      ->check(app::positive_number())
      ->type_name("PX")
      ->capture_default_str()
      ->group(group);
  command.add_option("--bar-sweeps", a.occluder.sweeps, "Passes over the frame")
      ->check(CLI::Range(1, 100000))
      ->type_name("N")
      ->capture_default_str()
      ->group(group);
  command.add_option("--cube-size", a.occluder.cube_size, "Its edge as a share of the object's diameter, as seen")
      ->check(app::positive_number())
      ->type_name("SHARE")
      ->capture_default_str()
      ->group(group);
  command.add_option("--occluder-model", a.occluder_models, "Model file, or 'box'; with a trajectory each")
      ->allow_extra_args(false)
      ->type_name("FILE")
      ->group(group);
  command
      .add_option("--occluder-trajectory", a.occluder_trajectories,
                  "File of its poses (to the camera), one a frame, or a single one")
      ->allow_extra_args(false)
      ->type_name("FILE")
      ->group(group);
  command.add_option("--occluder-scale", a.occluder_scale, "The occluders' unit in metres: 0.001 for millimetres")
      ->check(app::positive_number())
      ->type_name("FACTOR")
      ->capture_default_str()
      ->group(group);
}

void add_light_options(CLI::App& command, SimulateArguments& a) {
  const char* group = "Light and background";
  command.add_option("--ambient", a.sequence.lighting.ambient, "Light from everywhere")
      ->check(app::nonnegative_number())
      ->type_name("LIGHT")
      ->capture_default_str()
      ->group(group);
  command.add_option("--light", a.lights, "A lamp: camera axes, metres; several may be given [-0.6,-1,-0.3,0.65]")
      ->allow_extra_args(false)
      ->type_name("X,Y,Z,LIGHT")
      ->group(group);
  command.add_option("--light-orbit", a.light_orbit, "The lamps circle: radius in metres, frames a turn")
      ->expected(2)
      ->delimiter(',')
      ->type_name("RADIUS,FRAMES")
      ->group(group);
  command.add_option("--specular", a.sequence.lighting.finish.specular, "Strength of the object's highlights")
      ->check(app::nonnegative_number())
      ->type_name("LIGHT")
      ->capture_default_str()
      ->group(group);
  command.add_option("--shininess", a.sequence.lighting.finish.shininess, "Larger: smaller, sharper highlights")
      ->check(app::positive_number())
      ->type_name("EXPONENT")
      ->capture_default_str()
      ->group(group);
  command.add_option("--background", a.sequence.background.file, "Picture or video [a made picture of clutter]")
      ->type_name("FILE")
      ->group(group);
  command.add_option("--background-pan", a.sequence.background.pan, "The background moves by this much a frame")
      ->check(app::nonnegative_number())
      ->type_name("PX")
      ->capture_default_str()
      ->group(group);
}

void add_sensor_options(CLI::App& command, SimulateArguments& a) {
  const char* group = "What the camera adds";
  SensorOptions& sensor = a.sequence.sensor;
  const auto add = [&](const char* name, double& value, const char* unit, const char* description) {
    command.add_option(name, value, description)->type_name(unit)->capture_default_str()->group(group);
  };
  command.add_option("--samples", a.sequence.samples, "Squared: samples a pixel")
      ->check(CLI::Range(1, 16))
      ->type_name("N")
      ->capture_default_str()
      ->group(group);
  add("--motion-blur", a.sequence.motion_blur, "SHARE", "Exposure time over frame time, 0 to 1");
  add("--blur", sensor.blur_sigma, "PX", "Standard deviation of the lens' blur");
  add("--noise", sensor.noise, "GREY", "Standard deviation, grey levels of 255");
  add("--shot-noise", sensor.shot_noise, "GREY", "Further noise at white, less where it is darker");
  add("--gain", sensor.gain, "FACTOR", "Of the exposure");
  add("--exposure", sensor.exposure_stops, "STOPS", "The exposure swings up and down by this much");
  add("--white-balance", sensor.white_balance_stops, "STOPS", "Red and blue swing against each other");
  add("--gamma", sensor.gamma_stops, "STOPS", "The tone curve's exponent swings by powers of two");
  add("--change-frames", sensor.change_frames, "N", "Frames that such a swing takes");
  command.add_option("--jpeg", sensor.jpeg_quality, "Store frames as JPEG of this quality; 0: as PNG")
      ->check(CLI::Range(0, 100))
      ->type_name("QUALITY")
      ->capture_default_str()
      ->group(group);
}

}  // namespace

void add_simulate_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "simulate",
      "Make a sequence with exact ground truth: a model moving before a background, with occluders, light and a\n"
      "camera's flaws. Writes frames/, K.txt, poses_gt.txt and visible.txt. --report answers whether your object can\n"
      "be tracked with your camera at your distance.");
  auto arguments = std::make_shared<SimulateArguments>();
  command->add_option("folder", arguments->folder, "Where the sequence goes; may be left out with --report")
      ->type_name("FOLDER");
  command->add_flag("--report", arguments->report,
                    "Can it be tracked? Follows the object through the frames, tries faster motion and a bar in front, "
                    "and says how that went");
  add_sequence_options(*command, *arguments);
  add_object_options(*command, *arguments);
  add_motion_options(*command, *arguments);
  add_occluder_options(*command, *arguments);
  add_light_options(*command, *arguments);
  add_sensor_options(*command, *arguments);
  app::add_config_option(*command);
  command->callback([command, arguments, &exit_code] {
    arguments->frames_given = command->count("--frames") > 0;
    arguments->size_given = command->count("--size") > 0;
    refuse_idle_options(*command, *arguments);
    exit_code = run(*arguments);
  });
}

}  // namespace holdfast
