// "Will my object be trackable?": the judgement on made-up frames, and the command's answers on objects of which it is
// known.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "evaluation/pose_error.hpp"
#include "exit_codes.hpp"
#include "support/files.hpp"
#include "support/run_program.hpp"
#include "trackability/report.hpp"
#include "trackability/trial.hpp"

using namespace holdfast;
using namespace holdfast::trackability;
using holdfast::test::ProgramRun;
using holdfast::test::run_holdfast;
using holdfast::test::TemporaryFolder;

namespace {

/// A frame that is off by so many millimetres in depth.
evaluation::FrameRecord frame(Status status, double depth_mm) {
  evaluation::FrameRecord record;
  record.result.status = status;
  record.result.T_camera_object.translation().z() = 1e-3 * depth_mm;
  record.result.texture.usable_pixels = 800;
  record.result.texture.gradient_pixels = 200;
  record.result.texture.holds = true;
  record.result.ms.total = 2;
  record.error = evaluation::pose_error(Pose::Identity(), record.result.T_camera_object);
  return record;
}

bool says(const ProgramRun& run, const std::string& words) { return run.out.find(words) != std::string::npos; }

}  // namespace

TEST_CASE("Frames are good, wrong or lost: a twentieth of the diameter is the limit") {
  const std::vector<evaluation::FrameRecord> records = {frame(Status::held, 1), frame(Status::held, 9.9),
                                                        frame(Status::held, 10.1), frame(Status::lost, 0)};
  const TrialResult result = summarize_trial(records, std::vector<double>{900, 1000, 1000, 1200}, 0.2);
  CHECK(result.frames == 4);
  CHECK(result.good == 2);
  CHECK(result.wrong == 1);
  CHECK(result.lost == 1);
  CHECK(result.good_share() == 0.5);
  CHECK(result.worst_distance == doctest::Approx(9.9e-3));
  CHECK(result.worst_depth == doctest::Approx(9.9e-3));
  CHECK(result.median_distance == doctest::Approx(5.45e-3));
  CHECK(result.least_pixels == 900);
  CHECK(result.median_pixels == 1000);
  CHECK(result.textured_share == doctest::Approx(0.25));
  CHECK(result.median_ms == 2);
}

TEST_CASE("The verdict's limits") {
  TrialResult result;
  result.frames = 100;
  const auto of = [&result](int good) {
    result.good = good;
    return verdict(result);
  };
  CHECK(of(99) == Verdict::yes);
  CHECK(of(98) == Verdict::partly);
  CHECK(of(80) == Verdict::partly);
  CHECK(of(79) == Verdict::no);
}

TEST_CASE("The report gives a word to every finding") {
  Findings findings;
  findings.asked = summarize_trial(std::vector<evaluation::FrameRecord>(10, frame(Status::held, 2)),
                                   std::vector<double>(10, 5000.0), 0.2);
  findings.speed = 4;
  findings.metres_a_pixel = 0.001;
  findings.nearest = 0.5;
  findings.farthest = 1;
  TrialResult lost;
  lost.frames = 8;
  lost.good = 2;
  findings.faster = {{8, findings.asked}, {16, lost}};
  findings.farther = {{1, lost}};
  findings.behind_bar = findings.asked;
  const std::string text = report_text(findings);
  for (const char* words :
       {"YES: followed in 10 of 10 frames.\n", "5000 pixels", "25 % of them", "0.5 to 1 m", "2 mm and 0 degrees",
        "4 pixels a frame (0.12 m/s", "8 pixels a frame (0.24 m/s at 30 frames a second): held\n",
        "16 pixels a frame (0.48 m/s at 30 frames a second): lost (held in 25 %)", "1 m, 0 pixels: lost",
        "white bar sweeps across: held"}) {
    CAPTURE(words);
    CHECK(text.find(words) != std::string::npos);
  }
  CHECK(text.find("advice") == std::string::npos);
  findings.asked = lost;
  CHECK(report_text(findings).find("NO: followed in 2 of 8 frames") != std::string::npos);
  CHECK(report_text(findings).find("it is small in the picture") != std::string::npos);
}

TEST_CASE("simulate --report: a printed box nearby is held; it needs no folder and leaves nothing") {
  const TemporaryFolder folder;
  const ProgramRun run = run_holdfast({"simulate", "--report", "--frames", "30", "--size", "320x240", "--samples", "2",
                                       "--noise", "2", "--distance", "0.6,0.8"},
                                      folder);
  CAPTURE(run.out);
  CAPTURE(run.err);
  CHECK(run.exit_code == app::kOk);
  CHECK(run.err.empty());
  CHECK(says(run, "Can it be tracked? YES: followed in 30 of 30 frames."));
  CHECK(says(run, "  faster    8 pixels a frame"));
  CHECK(says(run, "  farther   1."));
  CHECK(says(run, "behind") == false);
  CHECK(says(run, "while a white bar sweeps across"));
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("simulate --report: a plain box is, by its contour, which is said; the frames are kept where asked for") {
  const TemporaryFolder folder;
  const ProgramRun run = run_holdfast({"simulate", "kept", "--report", "--frames", "10", "--size", "320x240",
                                       "--samples", "1", "--noise", "3", "--box-contrast", "0.01"},
                                      folder);
  CAPTURE(run.out);
  CAPTURE(run.err);
  CHECK(run.exit_code == app::kOk);
  CHECK(says(run, "Can it be tracked? YES: followed in 10 of 10 frames."));
  CHECK(says(run, "followed by its contour, for want of texture"));
  CHECK(says(run, "little of its surface has texture"));
  CHECK(std::filesystem::exists(folder / "kept/frames/000009.png"));
  CHECK(std::filesystem::exists(folder / "kept/poses_gt.txt"));
  CHECK(std::filesystem::exists(folder / "kept/model/model.obj"));
}

TEST_CASE("simulate: neither a folder nor --report") {
  const TemporaryFolder folder;
  test::check_error(run_holdfast({"simulate"}, folder), app::kUsage, {"FOLDER is missing"});
}

TEST_CASE("simulate: what makes no sense together is refused in one line, and nothing is written") {
  const TemporaryFolder folder;
  folder.write("plate.obj", "v -0.1 -0.1 0\nv 0.1 -0.1 0\nv 0 0.1 0\nf 1 2 3\n");
  folder.write("still.txt", "1 0 0 0 0 1 0 0 0 0 1 0.4\n");
  const auto simulate = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"simulate", "made", "--frames", "1", "--size", "64x48", "--samples", "1", "--quiet"});
    return run_holdfast(more, folder);
  };
  const auto refused = [&](const std::vector<std::string>& more, const std::vector<std::string>& words) {
    test::check_error(simulate(more), app::kUsage, words);
    CHECK_FALSE(std::filesystem::exists(folder / "made"));
  };
  // Millimetres: 65 pixels times 0.28 m over 100 m.
  refused({"--model", "plate.obj", "--distance", "100,200"}, {"--distance", "0.283 m", "0.18 pixels", "in metres"});
  refused({"--distance", "100,200"}, {"--distance", "in metres"});
  refused({"--model", "plate.obj", "--box-seed", "2"}, {"--box-seed", "--model box"});
  refused({"--model", "plate.obj", "--box-contrast", "0.5"}, {"--box-contrast", "--model box"});
  CHECK(simulate({"--model", "plate.obj", "--box-seed", "2", "--occluder-model", "box", "--occluder-trajectory",
                  "still.txt", "--trajectory", "still.txt"})
            .exit_code == app::kOk);
}
