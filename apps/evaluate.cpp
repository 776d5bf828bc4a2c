#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "commands.hpp"
#include "common_options.hpp"
#include "config_file.hpp"
#include "driver_start.hpp"
#include "evaluation/frame_pictures.hpp"
#include "evaluation/holdfast_run.hpp"
#include "evaluation/marked_points.hpp"
#include "evaluation/model_choice.hpp"
#include "evaluation/model_points.hpp"
#include "evaluation/plots.hpp"
#include "evaluation/pose_comparison.hpp"
#include "evaluation/protocol.hpp"
#include "evaluation/report.hpp"
#include "evaluation/sequence.hpp"
#include "evaluation/statistics.hpp"
#include "exit_codes.hpp"
#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "idle_options.hpp"
#include "messages.hpp"
#include "number_checks.hpp"
#include "separate_files.hpp"
#include "slow_notice.hpp"
#include "track/interruption.hpp"
#include "track/output_file.hpp"

namespace holdfast::app {
namespace {

namespace fs = std::filesystem;
using namespace evaluation;

/// Of images, by which TUM times tell frames.
constexpr double kFrameRate = 30;
constexpr const char* kNeverReset = "never-reset";
constexpr const char* kRbot = "rbot";
constexpr const char* kStarts = "starts";

struct EvaluateArguments {
  std::vector<std::string> folders;
  std::vector<std::string> models;
  std::optional<double> model_scale;
  std::optional<int> bop_object;

  std::string protocol = kNeverReset;
  std::vector<int> steps = {1};
  double minimum_visible = 0;
  bool show_start_frame = true;
  StartOptions starts;
  std::vector<double> start_error = {10, 5};  // mm, degrees

  fs::path poses;
  fs::path truth;
  bool partial = false;
  fs::path marks;
  std::vector<double> within;
  fs::path camera;

  fs::path csv;
  fs::path json;
  fs::path plots;
  fs::path pictures;
  std::vector<int> picture_frames;
  bool details = false;
  bool quiet = false;
  fs::path config;

  TrackerArguments tracker;
  DeviceArguments device;

  void add_to(CLI::App& app);
  void refuse_idle_options(const CLI::App& app) const;
  bool rbot() const { return protocol == kRbot; }
  bool wrong_starts() const { return protocol == kStarts; }
  bool needs_model_distances() const { return details || !json.empty() || !plots.empty(); }
};

void EvaluateArguments::add_to(CLI::App& app) {
  app.add_option("folders", folders,
                 "Sequences: folders with frames/, K.txt, poses_gt.txt (visible.txt), or BOP scenes")
      ->type_name("FOLDER");
  app.add_option(
         "--model", models,
         "Model file; PREFIX=FILE: for sequences whose name starts with PREFIX; repeatable. Left out: the folder's own "
         "model/model.obj; of BOP scenes the one below the data set's models/")
      ->allow_extra_args(false)
      ->type_name("[PREFIX=]FILE");
  app.add_option("--model-scale", model_scale, "The models' unit in metres [1; 0.001 for BOP scenes]")
      ->check(positive_number())
      ->type_name("FACTOR");
  app.add_option("--bop-object", bop_object, "obj_id to follow where a BOP scene holds several")->type_name("ID");

  const std::string tracking = "Running the tracker";
  app.add_option(
         "--protocol", protocol,
         "never-reset: left alone from the first true pose on; rbot: back to the truth after 5 cm or 5 degrees; "
         "starts: from wrong first poses all over the sequence, judged some frames later")
      ->check(CLI::IsMember({kNeverReset, kRbot, kStarts}))
      ->capture_default_str()
      ->group(tracking);
  app.add_option("--step", steps, "Only every n-th frame, from each of the n first ones; several: --step 1,2,3,4")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::Range(1, 1000))
      ->capture_default_str()
      ->group(tracking);
  app.add_option("--min-visible", minimum_visible,
                 "Frames with a smaller visible share count neither way and bring no reset")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str()
      ->group(tracking);
  app.add_flag("--show-start-frame,!--hide-start-frame", show_start_frame,
               "rbot: show the tracker the frame it is put to the truth of [yes; it is not counted]")
      ->group(tracking);

  app.add_option("--starts", starts.count, "starts: how many")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str()
      ->group(tracking);
  app.add_option("--start-error", start_error, "starts: up to this far off, millimetres and degrees")
      ->expected(2)
      ->delimiter(',')
      ->check(nonnegative_number())
      ->type_name("MM,DEG")
      ->capture_default_str()
      ->group(tracking);
  app.add_option("--start-frames", starts.frames, "starts: frames tracked from each; the last is judged")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str()
      ->group(tracking);
  app.add_option("--start-seed", starts.seed, "starts: another number, other errors")
      ->capture_default_str()
      ->group(tracking);

  const std::string comparing = "Comparing poses instead";
  app.add_option("--poses", poses, "Poses to judge: the table of 'holdfast track', 3x4 or 4x4 a line, or TUM")
      ->type_name("FILE")
      ->group(comparing);
  app.add_option("--truth", truth, "True poses, a line a frame, instead of a sequence folder")
      ->type_name("FILE")
      ->group(comparing);
  app.add_flag("--partial", partial, "The table may hold fewer frames than the sequence")->group(comparing);

  const std::string marking = "Comparing poses with marked points";
  app.add_option("--marks", marks,
                 "Points marked by hand, lines frame,x,y,z,u,v: how far --poses puts them from there, with --camera")
      ->type_name("FILE")
      ->group(marking);
  app.add_option("--camera", camera, "Camera of the frames that the points were marked in")
      ->type_name("FILE")
      ->group(marking);

  app.add_option("--within", within, "Most pixels that they may be off, median,largest; exit code 6 otherwise")
      ->delimiter(',')
      ->expected(2)
      ->check(nonnegative_number())
      ->type_name("PIXELS")
      ->group(marking);

  const std::string output = "Output";
  app.add_option("--csv", csv, "Every frame: truth, estimate, errors, counts, times")->type_name("FILE")->group(output);
  app.add_option("--json", json, "All figures, and the errors of every frame")->type_name("FILE")->group(output);
  app.add_option("--plots", plots, "Errors over time and accuracy curves as PNG (needs python3-matplotlib)")
      ->type_name("FOLDER")
      ->group(output);
  CLI::Option* chosen = app.add_option("--picture-frames", picture_frames, "Frames to draw: --picture-frames 0,25,50")
                            ->delimiter(',')
                            ->allow_extra_args(false)
                            ->check(nonnegative_number())
                            ->type_name("N,...")
                            ->group(output);
  CLI::Option* pictured =
      app.add_option("--pictures", pictures, "These frames as PNG: contour, and which pixels were used or rejected")
          ->type_name("FOLDER")
          ->group(output)
          ->needs(chosen);
  chosen->needs(pictured);
  app.add_flag("--details", details,
               "A second table: 2 cm / 2 degrees, ADD, ADD-S, depth, lateral, coverage, pixels on occluders, losses")
      ->group(output);
  app.add_flag("--quiet", quiet, "No progress")->group(output);

  tracker.add_to(app);
  device.add_to(app);
}

void EvaluateArguments::refuse_idle_options(const CLI::App& app) const {
  refuse_without(app, {"--camera", "--within"}, !marks.empty(), "--marks");
  refuse_beside(app,
                {"folders", "--model", "--model-scale", "--bop-object", "--min-visible", "--truth", "--partial",
                 "--csv", "--json", "--plots", "--details"},
                !marks.empty(), "--marks");
  refuse_without(app, {"--truth", "--partial"}, !poses.empty(), "--poses");
  refuse_without(app, {"--model", "--model-scale"}, poses.empty() || needs_model_distances(),
                 "--details, --json or --plots, where poses are compared");
  refuse_without(app, {"--model-scale"}, poses.empty() || !models.empty(), "--model, where poses are compared");
  refuse_beside(app,
                {"--protocol", "--step", "--show-start-frame", "--starts", "--start-error", "--start-frames",
                 "--start-seed", "--pictures", "Tracker"},
                !poses.empty(), "--poses, which tracks nothing");
  refuse_beside(app, {"--bop-object"}, !truth.empty(), "--truth");
  refuse_without(app, {"--show-start-frame"}, rbot(), "--protocol rbot");
  refuse_without(app, {"--starts", "--start-error", "--start-frames", "--start-seed"}, wrong_starts(),
                 "--protocol starts");
  refuse_beside(app, {"--step"}, wrong_starts(), "--protocol starts, which shows every frame");
}

InputFiles inputs_of(const EvaluateArguments& arguments, const std::vector<Sequence>& sequences) {
  InputFiles inputs{{arguments.poses, arguments.truth, arguments.config}, {}, {}};
  for (const Sequence& sequence : sequences) {
    inputs.files.insert(inputs.files.end(), sequence.tables.begin(), sequence.tables.end());
    for (const std::vector<fs::path>* images : {&sequence.frames, &sequence.occluder_masks}) {
      if (!images->empty()) inputs.frames.push_back(images->front().parent_path().string());
    }
    inputs.models.push_back(sequence.model);
  }
  return inputs;
}

void prepare_outputs(const EvaluateArguments& arguments, const std::vector<Sequence>& sequences) {
  require_separate_files({{arguments.csv, arguments.json}, {arguments.plots, arguments.pictures}, {}},
                         inputs_of(arguments, sequences));
  // Long runs must not end at a file that cannot be written.
  for (const fs::path& file : {arguments.csv, arguments.json}) {
    if (!file.empty()) require_writable(file);
  }
  if (!arguments.plots.empty()) {
    require_plotting();
  }
  for (const fs::path& folder : {arguments.plots, arguments.pictures}) {
    std::error_code failed;
    if (!folder.empty() && !fs::create_directories(folder, failed) && failed) {
      throw Error(ErrorCode::output, fmt::format("{}: cannot be made a folder", folder.string()));
    }
  }
}

void report(const EvaluateArguments& arguments, const Provenance& provenance,
            const std::vector<Evaluation>& evaluations) {
  const bool rbot = provenance.protocol == kRbot;
  fmt::print("{}", table(evaluations, rbot));
  if (arguments.details) {
    fmt::print("\n{}", detail_table(evaluations, rbot));
  }
  if (!arguments.csv.empty()) {
    write_frames_csv(arguments.csv, evaluations);
  }
  const fs::path json = !arguments.json.empty() ? arguments.json : arguments.plots / "evaluation.json";
  if (!arguments.json.empty() || !arguments.plots.empty()) {
    write_json(json, provenance, evaluations);
  }
  if (!arguments.plots.empty()) {
    draw_plots(json, arguments.plots);
  }
}

void finish(Evaluation& evaluation, const Tolerance& failure, const std::optional<ModelPoints>& points) {
  if (points) {
    evaluation.diameter = points->diameter();
    for (FrameRecord& record : evaluation.records) {
      record.add = points->add(record.T_camera_object_true, record.result.T_camera_object);
      record.add_s = points->add_s(record.T_camera_object_true, record.result.T_camera_object);
    }
  }
  evaluation.summary = summarize(evaluation.records, failure, evaluation.diameter);
}

Mesh load_mesh(const EvaluateArguments& arguments, const fs::path& path, const Sequence& sequence) {
  Mesh mesh = io::load_model(path, arguments.model_scale.value_or(sequence.model_scale));
  if (arguments.poses.empty()) {
    require_named_materials(mesh, path);
  }
  warn_about_units(mesh, sequence.truth.front(),
                   sequence.frames.empty() ? std::nullopt : std::optional(sequence.camera));
  return mesh;
}

std::optional<ModelPoints> points_if_needed(const EvaluateArguments& arguments, const Mesh& mesh) {
  return arguments.needs_model_distances() ? std::optional<ModelPoints>(std::in_place, mesh) : std::nullopt;
}

Evaluation track_from_starts(const Sequence& sequence, const TrackerUnderTest& tracker, const ProtocolOptions& options,
                             const EvaluateArguments& arguments) {
  StartOptions starts = arguments.starts;
  starts.translation = 1e-3 * arguments.start_error[0];
  starts.rotation = to_radians(arguments.start_error[1]);
  Evaluation out;
  out.sequence = sequence.name;
  out.records = run_starts(sequence.truth, sequence.visible, tracker, starts, options);
  return out;
}

Evaluation track_at_step(const Sequence& sequence, const TrackerUnderTest& tracker, ProtocolOptions options) {
  Evaluation out;
  out.sequence = sequence.name;
  out.step = options.step;
  if (static_cast<std::size_t>(options.step) >= sequence.truth.size()) {
    throw Error(ErrorCode::invalid_argument,
                fmt::format("--step {}: '{}' has only {} frames", options.step, sequence.name, sequence.truth.size()));
  }
  for (options.offset = 0; options.offset < options.step && !options.is_interrupted(); ++options.offset) {
    std::vector<FrameRecord> records = run_protocol(sequence.truth, sequence.visible, tracker, options);
    out.records.insert(out.records.end(), records.begin(), records.end());
  }
  return out;
}

fs::path model_of(const Sequence& sequence, const ModelChoice& models) {
  if (!models.empty()) {
    return models.for_sequence(sequence.name);
  }
  if (sequence.model.empty()) {
    throw Error(
        ErrorCode::invalid_argument,
        fmt::format("no model to track: '{}' has no model/model.obj, so add --model FILE or --model PREFIX=FILE",
                    sequence.name));
  }
  return sequence.model;
}

void require_visible_shares(const EvaluateArguments& arguments, const Sequence& sequence) {
  if (arguments.minimum_visible > 0 && sequence.visible.empty()) {
    throw Error(
        ErrorCode::invalid_argument,
        fmt::format("--min-visible: '{}' does not tell how much of the object is visible (visible.txt, a share a "
                    "frame): add that, or leave --min-visible out",
                    sequence.name));
  }
}

/// What has been tracked when it is interrupted is reported all the same.
int evaluate_tracker(const EvaluateArguments& arguments) {
  if (arguments.folders.empty()) {
    throw Error(ErrorCode::invalid_argument, "no sequence: give folders, or --poses with --truth");
  }
  start_drivers();
  const ModelChoice models(arguments.models);
  ProtocolOptions protocol;
  protocol.protocol = arguments.rbot() ? Protocol::rbot : Protocol::never_reset;
  protocol.minimum_visible = arguments.minimum_visible;
  protocol.show_start_frame = arguments.show_start_frame;
  const Interruption interruption;
  protocol.is_interrupted = [&interruption] { return interruption.requested(); };
  const TrackerOptions options = arguments.tracker.options();

  // Everything that can be wrong with the input is found before the first frame is tracked.
  std::vector<Sequence> sequences;
  for (const std::string& folder : arguments.folders) {
    sequences.push_back(load_sequence(folder, arguments.bop_object));
    sequences.back().model = model_of(sequences.back(), models);
    require_visible_shares(arguments, sequences.back());
    if (sequences.back().frames.empty()) {
      throw Error(ErrorCode::file, fmt::format("{}: no frames to track", folder));
    }
  }
  const std::vector<std::string> names = distinct_names({arguments.folders.begin(), arguments.folders.end()});
  for (std::size_t i = 0; i < names.size(); ++i) {
    sequences[i].name = names[i];
  }
  for (const int frame : arguments.picture_frames) {
    if (std::none_of(sequences.begin(), sequences.end(), [frame](const Sequence& sequence) {
          return static_cast<std::size_t>(frame) < sequence.frames.size();
        })) {
      throw Error(ErrorCode::invalid_argument, fmt::format("--picture-frames {}: no sequence has that frame", frame));
    }
  }
  prepare_outputs(arguments, sequences);

  std::optional<SlowNotice> notice(std::in_place, arguments.quiet ? nullptr : terminal(), kPreparing);
  const Device device = arguments.device.open();
  Provenance provenance;
  provenance.protocol = arguments.protocol;
  provenance.minimum_visible = arguments.minimum_visible;
  provenance.show_start_frame = arguments.show_start_frame;
  std::vector<Evaluation> evaluations;
  for (const Sequence& sequence : sequences) {
    if (interruption.requested()) break;
    const fs::path& model = sequence.model;
    const Mesh mesh = load_mesh(arguments, model, sequence);
    const std::optional<ModelPoints> points = points_if_needed(arguments, mesh);
    Tracker tracker(mesh, sequence.camera, options, device);
    notice.reset();
    provenance.tracker = tracker.description();
    TrackerUnderTest tested = under_test(tracker, sequence);
    std::optional<FramePictures> pictures;
    if (!arguments.pictures.empty()) {
      pictures.emplace(mesh, sequence, tracker, arguments.pictures, arguments.picture_frames);
      tested.inspect = [&pictures, others = tested.inspect](FrameRecord& record) {
        if (others) {
          others(record);
        }
        pictures->draw(record);
      };
    }
    for (const int step : arguments.steps) {
      protocol.step = step;
      Evaluation evaluation = arguments.wrong_starts() ? track_from_starts(sequence, tested, protocol, arguments)
                                                       : track_at_step(sequence, tested, protocol);
      if (interruption.requested() && evaluation.records.empty()) break;
      evaluations.push_back(std::move(evaluation));
      evaluations.back().model = model.string();
      finish(evaluations.back(), protocol.failure, points);
      if (!arguments.quiet) {
        const Summary& summary = evaluations.back().summary;
        fmt::print(stderr, "{} step {}: {:.1f} % within 5 cm and 5 degrees\n", sequence.name, step,
                   100 * summary.failure.share);
      }
    }
  }
  provenance.complete = !interruption.requested();
  if (evaluations.empty()) {
    print_warning("interrupted before any frame was tracked: nothing is written");
    return kInterrupted;
  }
  report(arguments, provenance, evaluations);
  if (provenance.complete) return kOk;
  std::size_t frames = 0;
  for (const Evaluation& evaluation : evaluations) frames += evaluation.records.size();
  print_warning(fmt::format("interrupted in '{}', step {}: the figures are of the {} frames tracked until then",
                            evaluations.back().sequence, evaluations.back().step, frames));
  return kInterrupted;
}

Sequence sequence_of_poses(const EvaluateArguments& arguments) {
  if (arguments.folders.size() + (arguments.truth.empty() ? 0 : 1) != 1) {
    throw Error(ErrorCode::invalid_argument, "--poses needs one sequence folder or --truth FILE");
  }
  if (!arguments.folders.empty()) {
    return load_sequence(arguments.folders.front(), arguments.bop_object);
  }
  Sequence sequence;
  sequence.name = arguments.truth.stem().string();
  sequence.truth = io::load_poses(arguments.truth);
  return sequence;
}

void evaluate_poses(const EvaluateArguments& arguments) {
  Sequence sequence = sequence_of_poses(arguments);
  require_visible_shares(arguments, sequence);
  const EstimatedPoses estimates = load_estimated_poses(arguments.poses, kFrameRate);
  Provenance provenance;
  provenance.protocol = "poses";
  provenance.minimum_visible = arguments.minimum_visible;
  provenance.tracker = arguments.poses.string();

  Evaluation evaluation;
  evaluation.sequence = sequence.name;
  evaluation.records =
      compare_poses(sequence, estimates, provenance.failure, arguments.minimum_visible, arguments.partial);
  std::optional<ModelPoints> points;
  if (!arguments.models.empty()) {
    sequence.model = ModelChoice(arguments.models).for_sequence(sequence.name);
  }
  if (!sequence.model.empty() && arguments.needs_model_distances()) {
    evaluation.model = sequence.model.string();
    points.emplace(load_mesh(arguments, evaluation.model, sequence));
  }
  prepare_outputs(arguments, {sequence});
  finish(evaluation, provenance.failure, points);
  report(arguments, provenance, {evaluation});
}

int evaluate_marks(const EvaluateArguments& arguments) {
  if (arguments.poses.empty() || arguments.camera.empty()) {
    throw Error(ErrorCode::invalid_argument, "--marks needs --poses and --camera");
  }
  const std::vector<MarkedPoint> marks = load_marked_points(arguments.marks);
  const EstimatedPoses poses = load_estimated_poses(arguments.poses, kFrameRate);
  const std::vector<MarkDistance> distances = mark_distances(marks, poses, io::load_camera(arguments.camera));
  fmt::print("{}", mark_table(distances));
  if (arguments.within.empty()) {
    return kOk;
  }
  const Spread all = mark_spread(distances);
  const bool within = all.median <= arguments.within[0] && all.maximum <= arguments.within[1];
  fmt::print("allowed: median {:g}, largest {:g} pixels: {}\n", arguments.within[0], arguments.within[1],
             within ? "met" : "missed");
  return within ? kOk : kLost;
}

}  // namespace
}  // namespace holdfast::app

namespace holdfast {

void add_evaluate_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "evaluate", "Measure the tracker on sequences with ground truth, or poses that it wrote, against the truth");
  auto arguments = std::make_shared<app::EvaluateArguments>();
  arguments->add_to(*command);
  app::add_config_option(*command);
  command->callback([command, arguments, &exit_code] {
    arguments->refuse_idle_options(*command);
    arguments->config = app::config_file(*command);
    if (!arguments->marks.empty()) {
      exit_code = app::evaluate_marks(*arguments);
      return;
    }
    if (arguments->poses.empty()) {
      exit_code = app::evaluate_tracker(*arguments);
    } else {
      app::evaluate_poses(*arguments);
      exit_code = app::kOk;
    }
  });
}

}  // namespace holdfast
