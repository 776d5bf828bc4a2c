#include "evaluate.hpp"

#include <fmt/core.h>

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/holdfast_run.hpp"
#include "evaluation/model_choice.hpp"
#include "evaluation/protocol.hpp"
#include "evaluation/report.hpp"
#include "evaluation/sequence.hpp"
#include "holdfast/error.hpp"
#include "holdfast/io.hpp"

namespace holdfast {
namespace {

using namespace evaluation;

struct EvaluateOptions {
  std::vector<std::string> folders;
  std::vector<std::string> models;
  std::string protocol = "never-reset";
  std::vector<int> steps = {1};
  double minimum_visible = 0;
  bool show_start_frame = false;
  std::string mode = "default";
  std::string device;
  std::string csv;
  bool quiet = false;
};

Protocol protocol_named(const std::string& name) { return name == "rbot" ? Protocol::rbot : Protocol::never_reset; }

Evaluation evaluate_step(const Sequence& sequence, const TrackerUnderTest& tracker, ProtocolOptions options) {
  Evaluation out;
  out.sequence = sequence.name;
  out.step = options.step;
  for (options.offset = 0; options.offset < options.step; ++options.offset) {
    for (FrameRecord& record : run_protocol(sequence.truth, sequence.visible, tracker, options)) {
      out.records.push_back(std::move(record));
    }
  }
  out.summary = summarize(out.records);
  return out;
}

void run(const EvaluateOptions& options) {
  const ModelChoice models(options.models);
  ProtocolOptions protocol;
  protocol.protocol = protocol_named(options.protocol);
  protocol.minimum_visible = options.minimum_visible;
  protocol.show_start_frame = options.show_start_frame;
  const TrackerOptions tracker_options = options.mode == "paper" ? TrackerOptions::paper() : TrackerOptions();
  const Device device(DeviceOptions{options.device, {}, {}});

  std::vector<Evaluation> evaluations;
  for (const std::string& folder : options.folders) {
    const Sequence sequence = load_sequence(folder);
    if (sequence.frames.empty()) {
      throw Error(ErrorCode::file, fmt::format("{}: no frames to track", folder));
    }
    const Mesh mesh = io::load_model(models.for_sequence(sequence.name), sequence.model_scale);
    Tracker tracker(mesh, sequence.camera, tracker_options, device);
    const TrackerUnderTest tested = under_test(tracker, sequence);
    for (const int step : options.steps) {
      protocol.step = step;
      evaluations.push_back(evaluate_step(sequence, tested, protocol));
      if (!options.quiet) {
        fmt::print(stderr, "{} step {}: done\n", sequence.name, step);
      }
    }
    if (!options.csv.empty()) {
      write_frames_csv(options.csv, evaluations);
    }
  }
  fmt::print("{}", table(evaluations, protocol.protocol));
}

}  // namespace

void add_evaluate_command(CLI::App& app, int& exit_code) {
  CLI::App* command =
      app.add_subcommand("evaluate", "Run the tracker on sequences with ground truth and report errors");
  auto options = std::make_shared<EvaluateOptions>();
  command->add_option("folders", options->folders, "Sequence folders")->required();
  command->add_option("--model", options->models, "Model file, or PREFIX=FILE for sequences whose name starts so")
      ->required()
      ->allow_extra_args(false);
  command->add_option("--protocol", options->protocol, "never-reset or rbot")
      ->check(CLI::IsMember({"never-reset", "rbot"}))
      ->capture_default_str();
  command->add_option("--step", options->steps, "Every n-th frame, all phase offsets; several: 1,2,3,4")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command
      ->add_option("--min-visible", options->minimum_visible, "Frames with a smaller visible share count neither way")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command->add_flag("--show-start-frame", options->show_start_frame,
                    "rbot: after each reset show the tracker the frame it was reset on");
  command->add_option("--mode", options->mode, "default or paper")->check(CLI::IsMember({"default", "paper"}));
  command->add_option("--device", options->device, "OpenCL device");
  command->add_option("--csv", options->csv, "Write every frame to this file");
  command->add_flag("--quiet", options->quiet, "No progress");
  command->callback([options, &exit_code]() {
    run(*options);
    exit_code = 0;
  });
}

}  // namespace holdfast
