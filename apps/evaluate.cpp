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
#include "config_file.hpp"
#include "driver_start.hpp"
#include "evaluation/estimated_poses.hpp"
#include "evaluation/evaluate_arguments.hpp"
#include "evaluation/folder_names.hpp"
#include "evaluation/frame_pictures.hpp"
#include "evaluation/holdfast_run.hpp"
#include "evaluation/marked_points.hpp"
#include "evaluation/model_choice.hpp"
#include "evaluation/model_points.hpp"
#include "evaluation/plots.hpp"
#include "evaluation/pose_comparison.hpp"
#include "evaluation/report.hpp"
#include "evaluation/sequence.hpp"
#include "evaluation/statistics.hpp"
#include "exit_codes.hpp"
#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "messages.hpp"
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
  fmt::print("{}", table(evaluations, arguments.rbot()));
  if (arguments.details) {
    fmt::print("\n{}", detail_table(evaluations, arguments.rbot()));
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
  const ModelArguments model{path, arguments.model_scale.value_or(sequence.model_scale)};
  Mesh mesh = model.load(arguments.poses.empty());
  warn_about_units(mesh, sequence.truth.front(),
                   sequence.frames.empty() ? std::nullopt : std::optional(sequence.camera));
  if (!sequence.frames.empty()) warn_if(io::camera_warning(sequence.camera));
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

  std::optional<SlowNotice> notice(
      std::in_place, arguments.quiet ? nullptr : preparing_stream(arguments.device.options.cache_folder), kPreparing);
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
