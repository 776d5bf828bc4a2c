#include "track/track_command.hpp"

#include <nlohmann/json.hpp>

#include "config_file.hpp"
#include "holdfast/error.hpp"
#include "idle_options.hpp"
#include "number_checks.hpp"
#include "track/interruption.hpp"

namespace holdfast::app {

void TrackCommand::add_to(CLI::App& command) {
  command
      .add_option("input", input,
                  "Video file, image folder, image pattern (frames/%06d.png, 'frames/*.png'), or a camera's number")
      ->required()
      ->type_name("INPUT");
  model.add_to(command);
  camera.add_to(command, false, "; without it the focal length is estimated from a textured object");
  command.add_option("--camera-out", camera_out, "The camera that was estimated, for --camera of the next run (.yml)")
      ->type_name("FILE")
      ->group("Object and camera");
  init.add_to(command, false, "; without it a textured object is looked for in each frame until it is found");
  command
      .add_option("--guide", guide,
                  "A pose about as the object will be held (to 20 degrees, a fifth of its distance, a quarter of the "
                  "picture): it is waited for there; needs no texture")
      ->type_name("FILE")
      ->group("Object and camera");
  command
      .add_option("--views", views,
                  "What the model looks like from all sides: read, or made and written where there is no such file yet "
                  "[kept in the cache folder]")
      ->type_name("FILE")
      ->group("Object and camera");

  command
      .add_option("--remember", remembered,
                  "What frames show of the object: read where the file is, added to, and written at the end, so that "
                  "the next run recognizes it, also without a texture")
      ->type_name("FILE")
      ->group("Object and camera");

  constexpr const char* frames_group = "Frames";
  command.add_option("--start", start, "First frame tracked, the one that --init is the pose in [0]")
      ->type_name("N")
      ->group(frames_group);
  command.add_option("--stop", stop, "First frame not tracked any more [end]")->type_name("N")->group(frames_group);
  command.add_option("--stride", stride, "Track every N-th frame [1]")->type_name("N")->group(frames_group);
  command.add_option("--frame-rate", frame_rate, "Frames a second of images [30]; for a video instead of its own")
      ->check(positive_number())
      ->type_name("RATE")
      ->group(frames_group);

  constexpr const char* output_group = "Results";
  command.add_option("--poses", outputs.poses, "CSV: pose, status and figures, one row per frame")
      ->type_name("FILE")
      ->group(output_group);
  command.add_option("--tum", outputs.tum, "TUM trajectory of the frames that are held")
      ->type_name("FILE")
      ->group(output_group);
  command.add_option("--json", outputs.json, "JSON: all that the CSV has, times, information matrices, the summary")
      ->type_name("FILE")
      ->group(output_group);
  command
      .add_option("--overlay", outputs.overlay,
                  "Video (.mp4, .mkv, .mov; .avi, which plays after a kill too): the model's contour, and pixels "
                  "used (green) or rejected (red)")
      ->type_name("FILE")
      ->group(output_group);
  command.add_option("--contact-sheet", outputs.contact_sheet, "Picture (.png) of frames spread over the run")
      ->type_name("FILE")
      ->group(output_group);
  command.add_option("--contact-frames", outputs.contact_frames, "How many [20]")->type_name("N")->group(output_group);
  command
      .add_option("--complete-model", completed_model,
                  "Model (.obj) with the texture that the frames add where the given one has none; a model without any "
                  "texture begins with what the first frame shows")
      ->type_name("FILE")
      ->group(output_group);
  command
      .add_flag("--show", show,
                "A window with contour, axes and status: space pauses, . goes on by a frame, c shows pixels used and "
                "rejected, l looks for the object again, s saves the picture, q ends")
      ->group(output_group);
  command.add_flag("--require-held", require_held, "Exit with code 6 when any frame was lost")->group(output_group);
  command.add_flag("--quiet", quiet, "No progress and no summary")->group(output_group);

  device.add_to(command);
  tracker.add_to(command);
  add_config_option(command);
}

void TrackCommand::check(const CLI::App& command) const {
  refuse_beside(command, {"--camera-out"}, !camera.path.empty(), "--camera");
  if (camera.path.empty() && !(init.path.empty() && guide.empty())) {
    throw Error(ErrorCode::invalid_argument,
                "--init and --guide need --camera: a pose is of the camera that it was measured with");
  }
  refuse_beside(command, {"--guide"}, !init.path.empty(), "--init");
  refuse_without(command, {"--complete-model"}, !init.path.empty(), "--init");
  const bool is_started = !(init.path.empty() && guide.empty());
  if (is_started && remembered.empty()) {  // the object is recognized after a loss only
    const TrackerOptions options = tracker.options();
    refuse_beside(command, {"--views"}, !completed_model.empty(), "--complete-model");
    refuse_beside(command, {"--views"}, options.quality == Quality::paper, "--mode paper");
    refuse_without(command, {"--views"}, options.recovery, "--recovery");
  }
  refuse_without(command, {"--contact-frames"}, !outputs.contact_sheet.empty(), "--contact-sheet");
}

FrameSourceOptions TrackCommand::source_options() const {
  FrameSourceOptions options;
  options.start = start;
  options.stop = stop;
  options.stride = stride;
  options.frame_rate = frame_rate;
  options.gives_up = &Interruption::requested;
  if (camera.path.empty()) return options;
  const Camera calibration = camera.load();
  options.live_width = calibration.width;
  options.live_height = calibration.height;
  return options;
}

std::string TrackCommand::run_json(const Tracker& used) const {
  const Camera& seen_by = used.camera();
  const nlohmann::ordered_json run = {
      {"version", HOLDFAST_VERSION},
      {"input", input},
      {"start", start},
      {"stop", stop ? nlohmann::ordered_json(*stop) : nlohmann::ordered_json(nullptr)},
      {"stride", stride},
      {"model", model.path.string()},
      {"model_scale", model.scale},
      {"camera",
       {{"width", seen_by.width},
        {"height", seen_by.height},
        {"fx", seen_by.fx},
        {"fy", seen_by.fy},
        {"cx", seen_by.cx},
        {"cy", seen_by.cy},
        {"lens", lens_name(seen_by.lens)},
        {"distortion", seen_by.distortion}}},
      {"init", init.path.empty() ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(init.path.string())},
      {"mode", tracker.mode_name()},
      {"options", given},
      {"tracker", used.description()},
      {"pose_convention", "object to camera, metres; camera axes x right, y down, z forward"},
      {"information_convention",
       "inverse covariance of (v, w) in T_true = T exp((v, w)): object axes, metres and radians"}};
  return run.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace holdfast::app
