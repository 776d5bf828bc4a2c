#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "commands.hpp"
#include "common_options.hpp"
#include "config_file.hpp"
#include "driver_start.hpp"
#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "idle_options.hpp"
#include "init/check_picture.hpp"
#include "init/click_session.hpp"
#include "init/guided_pose.hpp"
#include "init/init_outcome.hpp"
#include "init/mirrored_points.hpp"
#include "init/point_pairs.hpp"
#include "init/pose_from_points.hpp"
#include "init/refine_on_frame.hpp"
#include "init/surface_distance.hpp"
#include "messages.hpp"
#include "separate_files.hpp"
#include "show/model_sheet.hpp"
#include "slow_notice.hpp"
#include "track/outline.hpp"
#include "track/output_file.hpp"
#include "video/frame_source.hpp"

namespace holdfast {
namespace {

namespace fs = std::filesystem;

using namespace app;

/// Points that reach farther from the model than this share of its size are not of its unit or frame.
constexpr double kOffModel = 0.1;
/// The same of points that are nowhere on its surface.
constexpr double kOffSurface = 0.03;
/// Points that spread this many times wider than the model, or the model than them, are in another unit.
constexpr double kOtherUnit = 20;

struct InitCommand {
  ModelArguments model;
  CameraArguments camera;
  DeviceArguments device;
  fs::path points;
  bool click = false;
  fs::path guide;
  bool estimate_focal = false;
  std::string image;
  std::int64_t frame_number = 0;
  bool no_refine = false;
  fs::path pose_out;
  fs::path camera_out;
  fs::path picture_out;
  fs::path points_out;
  fs::path json_out;
  fs::path config;

  void add_to(CLI::App& command);
  void run() const;

 private:
  void run_guide() const;

  void require_consistent() const;
  std::vector<fs::path> outputs() const;
  std::optional<Camera> known_camera(const cv::Mat& frame) const;
  void refine(InitOutcome& outcome) const;
  void write(const InitOutcome& outcome) const;
};

void InitCommand::add_to(CLI::App& command) {
  constexpr const char* points_group = "Points and frame";
  command.add_option("--points", points, "CSV of lines x,y,z,u,v: a point of the model (in its unit) and its pixel")
      ->type_name("FILE")
      ->group(points_group);
  command.add_flag("--click", click, "Click the model's vertices in a window instead")->group(points_group);
  command
      .add_option(
          "--guide", guide,
          "A pose about as the object is held (to 20 degrees, a fifth of its distance, a quarter of the picture) "
          "instead: the pose is looked for near it, the picture shows both")
      ->type_name("FILE")
      ->group(points_group);
  command.add_option("--image", image, "The frame: an image, or a video, folder or pattern with --frame")
      ->type_name("INPUT")
      ->group(points_group);
  command.add_option("--frame", frame_number, "Number of the frame in --image [0]")
      ->type_name("N")
      ->group(points_group);
  model.add_to(command, false);
  camera.add_to(command, false);
  command
      .add_flag("--estimate-focal", estimate_focal,
                "Camera unknown: find the focal length too (six points or more; square pixels, centre in the middle)")
      ->group("Object and camera");
  command.add_flag("--no-refine", no_refine,
                   "Leave the pose as the points give it, also where the model has a texture");

  constexpr const char* output_group = "Results";
  command.add_option("--pose", pose_out, "The pose, for --init of 'holdfast track'")
      ->type_name("FILE")
      ->group(output_group);
  command.add_option("--camera-out", camera_out, "The camera, for --camera of 'holdfast track' (.yml, .json, .xml)")
      ->type_name("FILE")
      ->group(output_group);
  command
      .add_option(
          "--picture", picture_out,
          "Picture (.png) of the model's contour over the frame, and of the model as it was loaded, to check by eye")
      ->type_name("FILE")
      ->group(output_group);
  command.add_option("--points-out", points_out, "The points that were clicked, for --points")
      ->type_name("FILE")
      ->group(output_group);
  command.add_option("--json", json_out, "All of it as JSON")->type_name("FILE")->group(output_group);
  device.add_to(command);
  add_config_option(command);
}

void InitCommand::require_consistent() const {
  const auto require = [](bool condition, const char* message) {
    if (!condition) {
      throw Error(ErrorCode::invalid_argument, message);
    }
  };
  require(static_cast<int>(!points.empty()) + static_cast<int>(click) + static_cast<int>(!guide.empty()) == 1,
          "give either --points FILE or --click or --guide FILE");
  require(guide.empty() || (!image.empty() && !model.path.empty() && !estimate_focal),
          "--guide needs --image, --model and --camera");
  require(camera.path.empty() == estimate_focal, "give either --camera FILE or, when it is unknown, --estimate-focal");
  require(frame_number >= 0, "--frame counts from 0");
  require(!image.empty() || !estimate_focal, "--estimate-focal needs --image: the frame's size tells its centre");
  require(!image.empty() || picture_out.empty(), "--picture needs --image: the frame to draw on");
  require(!click || (!image.empty() && !model.path.empty()), "--click needs --image and --model");
  require_separate_files({outputs(), {}, {}}, {{points, guide, camera.path, config}, {image}, {model.path}});
  for (const fs::path& path : outputs()) require_writable(path);
}

std::vector<fs::path> InitCommand::outputs() const {
  std::vector<fs::path> given;
  for (const fs::path& path : {pose_out, camera_out, picture_out, points_out, json_out}) {
    if (!path.empty()) {
      given.push_back(path);
    }
  }
  return given;
}

cv::Mat read_frame(const std::string& input, std::int64_t number) {
  FrameSourceOptions options;
  options.start = number;
  options.stop = number + 1;
  Frame frame;
  bool found = false;
  try {
    FrameSource source(input, options);
    found = source.next(frame);
    warn_if(source.doubt());
  } catch (const Error& error) {
    if (error.code() != ErrorCode::invalid_argument) {
      throw;
    }  // the number lies behind the end; said below, by the name of this command's option
  }
  if (!found) {
    throw Error(ErrorCode::invalid_argument, fmt::format("--frame {}: '{}' has no such frame", number, input));
  }
  return frame.image.clone();
}

std::optional<Camera> InitCommand::known_camera(const cv::Mat& frame) const {
  if (estimate_focal) {
    return std::nullopt;
  }
  return frame.empty() ? camera.load() : camera.load(frame.cols, frame.rows);
}

/// Points that spread over far less, or more, than the model are in another unit.
std::optional<std::string> other_unit(const Mesh& mesh, const std::vector<PointPair>& pairs) {
  Eigen::AlignedBox3d box;
  for (const PointPair& pair : pairs) box.extend(pair.p_object);
  const double points = box.diagonal().norm(), model = 2.0 * mesh.radius();
  if (points > model / kOtherUnit && points < model * kOtherUnit) return std::nullopt;
  return fmt::format(
      "the points spread over {:.3g} m and the model over {:.3g} m: are the points in the unit of the model's file?",
      points, model);
}

/// Points elsewhere than the model's surface are in another unit or frame, such as one with another axis up, though a
/// pose may bring them to their pixels all the same.
void warn_when_off_model(const Mesh& mesh, const std::vector<PointPair>& pairs, const std::vector<double>& off) {
  const double radius = mesh.radius();
  for (const PointPair& pair : pairs) {
    const double distance = (pair.p_object - mesh.center()).norm();
    if (distance > (1 + kOffModel) * radius) {
      print_warning(fmt::format(
          "the point of {} lies {:.3g} m from the model's centre, but the model reaches only {:.3g} m: are the points "
          "in the model's unit and frame?",
          pair.name, distance, radius));
      return;
    }
  }
  const auto farthest = std::max_element(off.begin(), off.end());
  const auto count =
      std::count_if(off.begin(), off.end(), [&](double metres) { return metres > kOffSurface * radius; });
  if (count > 0) {
    print_warning(fmt::format(
        "{} of {} points do not lie on the model, that of {} is {:.3g} mm off its surface: were they measured in a "
        "file with other axes (y up instead of z) or another origin? 'holdfast show' draws the model as it is read",
        count, off.size(), pairs[static_cast<std::size_t>(farthest - off.begin())].name, *farthest * 1e3));
  }
}

void InitCommand::refine(InitOutcome& outcome) const {
  const bool possible = outcome.mesh && outcome.mesh->has_appearance() && !outcome.frame.empty();
  if (no_refine || !possible) {
    return;
  }
  const SlowNotice notice(preparing_stream(device.options.cache_folder), kPreparing);
  outcome.refinement = refine_on_frame(*outcome.mesh, outcome.from_points.camera, device.open(), outcome.frame,
                                       outcome.from_points.pairs, outcome.from_points.T_camera_object);
  if (!outcome.refinement->accepted) {
    print_warning("the pose is left as the points give it, because refining it on the frame failed: " +
                  outcome.refinement->reason);
  }
}

void InitCommand::write(const InitOutcome& outcome) const {
  const Camera& used = outcome.from_points.camera;
  if (!pose_out.empty()) {
    io::save_pose(pose_out, outcome.pose());
  }
  if (!camera_out.empty()) {
    io::save_camera(camera_out, used);
  }
  if (!points_out.empty()) {
    save_point_pairs(points_out, outcome.given);
  }
  if (!json_out.empty()) {
    write_whole(json_out, json_of(outcome));
  }
  if (!picture_out.empty()) {
    const std::vector<Line> outline =
        outcome.mesh ? Outline(*outcome.mesh, used).lines(outcome.pose()) : std::vector<Line>();
    const cv::Mat picture = check_picture(outcome.frame, used, outcome.pose(), outline, outcome.from_points.pairs);
    save_picture(picture_out,
                 outcome.mesh ? with_model_sheet(picture, *outcome.mesh, model.path.filename().string()) : picture);
  }
}

/// The pose near the guide in the frame, and a picture of both: the guide's contour orange, the pose's green.
void InitCommand::run_guide() const {
  start_drivers();
  const Mesh mesh = model.load();
  const cv::Mat frame = read_frame(image, frame_number);
  const Camera used = camera.load(frame.cols, frame.rows);
  const Pose T_guide = io::load_pose(guide);
  warn_if(io::camera_warning(used));
  if (!warn_about_units(mesh, T_guide, used)) warn_if(guide_doubt(T_guide, mesh, used));
  const std::optional<Pose> found = pose_near(T_guide, mesh, used, device, frame);
  if (!picture_out.empty()) {
    save_picture(picture_out, with_model_sheet(guide_picture(T_guide, found, mesh, used, frame), mesh,
                                               model.path.filename().string()));
  }
  if (!found) {
    throw Error(ErrorCode::pose,
                fmt::format("the object is not seen near the guide in frame {} of '{}'{}", frame_number, image,
                            picture_out.empty() ? "" : "; the picture shows the guide"));
  }
  if (!pose_out.empty()) io::save_pose(pose_out, *found);
  const Eigen::Vector3d& t = found->translation();
  fmt::print("object at      ({:.4f}, {:.4f}, {:.4f}) m: right, down, ahead of the camera\n", t.x(), t.y(), t.z());
  for (const fs::path& path : outputs()) fmt::print("written        {}\n", path.string());
}

void InitCommand::run() const {
  require_consistent();
  if (!guide.empty()) return run_guide();
  if (click) {
    require_display();
  }
  if (!no_refine && !model.path.empty() && !image.empty()) start_drivers();
  InitOutcome outcome;
  outcome.focal_estimated = estimate_focal;
  if (!points.empty()) {
    outcome.given = load_point_pairs(points, model.scale);
  }
  if (!model.path.empty()) {
    outcome.mesh = model.load();
  }
  if (!image.empty()) {
    outcome.frame = read_frame(image, frame_number);
  }
  const std::optional<Camera> known = known_camera(outcome.frame);
  if (known) warn_if(io::camera_warning(*known));
  if (click) {
    outcome.given = click_points(outcome.frame, *outcome.mesh, known);
  }
  outcome.from_points = known ? pose_from_points(outcome.given, *known)
                              : pose_and_focal_from_points(outcome.given, outcome.frame.cols, outcome.frame.rows);
  for (const std::string& warning : outcome.from_points.warnings) {
    print_warning(warning);
  }
  if (known) warn_if(mirrored_points(outcome.given, *known, outcome.from_points.rms));
  if (outcome.mesh) {
    const std::optional<std::string> unit = other_unit(*outcome.mesh, outcome.given);
    warn_if(unit);
    if (!unit) warn_about_units(*outcome.mesh, outcome.from_points.T_camera_object, outcome.from_points.camera);
    for (const PointPair& pair : outcome.given) {
      outcome.off_surface.push_back(distance_to_surface(*outcome.mesh, pair.p_object));
    }
    if (!unit) warn_when_off_model(*outcome.mesh, outcome.given, outcome.off_surface);
  }
  refine(outcome);
  write(outcome);
  fmt::print("{}", text_of(outcome, pose_out.empty(), outputs()));
}

}  // namespace

void add_init_command(CLI::App& app, int&) {
  CLI::App* command = app.add_subcommand("init", "Find the first pose (and focal length) from points in a frame");
  const auto init = std::make_shared<InitCommand>();
  init->add_to(*command);
  command->callback([command, init] {
    refuse_without(*command, {"--frame", "--rescale-camera"}, !init->image.empty(), "--image");
    refuse_without(*command, {"--rescale-camera", "--pixel-centres"}, !init->camera.path.empty(), "--camera");
    refuse_beside(*command, {"--no-refine", "--camera-out", "--points-out", "--json"}, !init->guide.empty(), "--guide");
    init->config = config_file(*command);
    init->run();
  });
}

}  // namespace holdfast
