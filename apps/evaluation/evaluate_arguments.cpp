#include "evaluation/evaluate_arguments.hpp"

#include "idle_options.hpp"
#include "number_checks.hpp"

namespace holdfast::app {
namespace {

constexpr const char* kNeverReset = "never-reset";
constexpr const char* kRbot = "rbot";
constexpr const char* kStarts = "starts";

}  // namespace

bool EvaluateArguments::rbot() const { return protocol == kRbot; }

bool EvaluateArguments::wrong_starts() const { return protocol == kStarts; }

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
  app.add_option("--truth", truth, "True poses, one line per frame, instead of a sequence folder")
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

}  // namespace holdfast::app
