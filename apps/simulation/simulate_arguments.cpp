#include "simulation/simulate_arguments.hpp"

#include <algorithm>
#include <initializer_list>

#include "idle_options.hpp"
#include "number_checks.hpp"

namespace holdfast::simulation {
namespace {

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
  command
      .add_option(
          "--distance", a.distance,
          "Nearest and farthest distance, metres; short sequences keep between them [so that it fits the frame]")
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

}  // namespace

void SimulateArguments::add_to(CLI::App& command) {
  command.add_option("folder", folder, "Where the sequence goes; may be left out with --report")->type_name("FOLDER");
  command.add_flag("--report", report,
                   "Can it be tracked? Follows the object through the frames, tries faster motion and a bar in front, "
                   "and says how that went");
  add_sequence_options(command, *this);
  add_object_options(command, *this);
  add_motion_options(command, *this);
  add_occluder_options(command, *this);
  add_light_options(command, *this);
  add_sensor_options(command, *this);
}

void SimulateArguments::check(const CLI::App& command) {
  frames_given = command.count("--frames") > 0;
  size_given = command.count("--size") > 0;
  refuse_idle_options(command, *this);
}

}  // namespace holdfast::simulation
