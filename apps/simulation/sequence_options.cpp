#include "simulation/sequence_options.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "common_options.hpp"
#include "holdfast/error.hpp"
#include "holdfast/io.hpp"

namespace holdfast::simulation {
namespace {

constexpr double radians_a_degree = std::numbers::pi / 180.0;

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
    return app::camera_for_frames(camera, width, height, arguments.rescale_camera);
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

}  // namespace

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

}  // namespace holdfast::simulation
