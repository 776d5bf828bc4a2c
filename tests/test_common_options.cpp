#include <doctest/doctest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <vector>

#include "common_options.hpp"
#include "config_file.hpp"
#include "support/files.hpp"

using namespace holdfast;
using namespace holdfast::app;
using holdfast::test::error_of;
using holdfast::test::TemporaryFolder;

namespace {

TrackerOptions parsed(std::vector<std::string> arguments) {
  CLI::App app;
  enable_config_file(app);
  CLI::App* command = app.add_subcommand("track", "");
  TrackerArguments tracker;
  tracker.add_to(*command);
  add_config_option(*command);
  app.add_subcommand("simulate");
  arguments.insert(arguments.begin(), "track");
  std::reverse(arguments.begin(), arguments.end());
  app.parse(arguments);
  return tracker.options();
}

}  // namespace

TEST_CASE("Without options a mode's own values stand") {
  const TrackerOptions standard = parsed({}), named = parsed({"--mode", "default"});
  CHECK(standard.quality == Quality::accurate);
  CHECK(named.quality == Quality::accurate);
  CHECK(standard.contour == TrackerOptions().contour);
  CHECK(standard.levels == TrackerOptions().levels);
  CHECK(standard.recovery_budget_ms == TrackerOptions().recovery_budget_ms);
  CHECK(standard.occlusion.block_vote == TrackerOptions().occlusion.block_vote);
  CHECK(standard.ablate.empty());
  const TrackerOptions paper = parsed({"--mode", "paper"});
  const TrackerOptions wanted = TrackerOptions::paper();
  CHECK(paper.quality == Quality::paper);
  CHECK(paper.levels == wanted.levels);
  CHECK(paper.contour == wanted.contour);
  CHECK(paper.occlusion.difference_relative == wanted.occlusion.difference_relative);
  const TrackerOptions fast = parsed({"--mode", "fast"});
  CHECK(fast.quality == Quality::fast);
  CHECK(fast.levels == TrackerOptions::fast().levels);
}

TEST_CASE("An option changes its field in any mode, and no other") {
  for (const char* mode : {"default", "fast", "paper"}) {
    CAPTURE(mode);
    const TrackerOptions base = parsed({"--mode", mode});
    const TrackerOptions changed =
        parsed({"--mode", mode, "--no-light-compensation", "--angle-each", "--gradient-minimum", "0.02",
                "--angle-maximum", "0.3", "--ablate", "velocity,expected_motion"});
    CHECK_FALSE(changed.light_compensation);
    CHECK_FALSE(changed.occlusion.angle_together);
    CHECK(changed.occlusion.gradient_minimum == 0.02);
    CHECK(changed.occlusion.angle_maximum == 0.3);
    CHECK(changed.ablate == std::vector<std::string>{"velocity", "expected_motion"});
    CHECK(changed.quality == base.quality);
    CHECK(changed.levels == base.levels);
    CHECK(changed.contour == base.contour);
    CHECK(changed.occlusion.gradient_test == base.occlusion.gradient_test);
    CHECK(changed.occlusion.magnitude_test == base.occlusion.magnitude_test);
  }
  const TrackerOptions twice = parsed({"--ablate", "velocity", "--ablate", "shading"});
  CHECK(twice.ablate == std::vector<std::string>{"velocity", "shading"});
  // A flag says what it says, whatever the mode's own value.
  CHECK(parsed({"--magnitude-test"}).occlusion.magnitude_test);
  CHECK_FALSE(parsed({"--mode", "paper", "--no-magnitude-test"}).occlusion.magnitude_test);
  CHECK_FALSE(parsed({"--no-contour"}).contour);
  CHECK(parsed({"--contour"}).contour);
  CHECK(parsed({"--recovery-budget", "7.5"}).recovery_budget_ms == 7.5);
}

TEST_CASE("Options that are gone are refused") {
  for (const char* option : {"--blur-sigma=1", "--no-outline", "--no-photometric", "--challenge", "--iterations=2",
                             "--lost-correlation=0.5", "--texture-samples=1", "--all-channels"}) {
    CAPTURE(option);
    CHECK_THROWS_AS(parsed({option}), CLI::ParseError);
  }
  CHECK_THROWS_AS(parsed({"--mode", "published"}), CLI::ParseError);
}

TEST_CASE("Configuration files: bare keys, sections, underscores; the command line wins") {
  const TemporaryFolder folder;
  const std::string file = folder
                               .write("c.ini",
                                      "; comment\nmode = fast\nsearch_radius = 15\nblock-vote = false\n[track]\n"
                                      "levels = 2\n[simulate]\nlevels = 7\nunheard-of = 1\n")
                               .string();
  const TrackerOptions read = parsed({"--config", file});
  CHECK(read.quality == Quality::fast);
  CHECK(read.search_radius == 15);
  CHECK_FALSE(read.occlusion.block_vote);
  CHECK(read.levels == 2);
  CHECK(parsed({"--config", file, "--levels", "3"}).levels == 3);
  const std::string negative = folder.write("n.toml", "light-compensation = false\n").string();
  CHECK_FALSE(parsed({"--config", negative}).light_compensation);
  CHECK_THROWS_AS(parsed({"--config", folder.write("u.toml", "unheard-of = 1\n").string()}), CLI::ParseError);
  CHECK_THROWS_AS(parsed({"--config", folder.write("s.toml", "[trak]\nlevels = 2\n").string()}), CLI::ParseError);
  CHECK_THROWS_AS(parsed({"--config", (folder / "none.toml").string()}), CLI::ParseError);
}

TEST_CASE("Values out of range name the flag that was typed") {
  const std::vector<std::pair<std::string, std::string>> wrong{{"--gradient-minimum", "-1"},
                                                               {"--angle-maximum", "2"},
                                                               {"--difference-maximum", "-1"},
                                                               {"--difference-relative", "-1"},
                                                               {"--vote-share", "7"},
                                                               {"--redundancy-cosine", "1.5"},
                                                               {"--levels", "0"},
                                                               {"--levels", "7"},
                                                               {"--search-radius", "-1"},
                                                               {"--recovery-budget", "-1"}};
  for (const auto& [flag, value] : wrong) {
    CAPTURE(flag);
    const auto error = error_of([&, flag = flag, value = value] { parsed({flag, value}); });
    CHECK(error.code == ErrorCode::invalid_argument);
    CHECK(error.message.starts_with(flag + " must be "));
    CHECK(error.message.find('_') == std::string::npos);
  }
  const auto error = error_of([] { parsed({"--ablate", "luck"}); });
  CHECK(error.says(ErrorCode::invalid_argument, {"--ablate", "'luck'", "expected_motion", "velocity"}));
}

TEST_CASE("Paper mode refuses what it has no use for, unless it is as it would be anyway") {
  const std::vector<std::vector<std::string>> idle{
      {"--levels", "2"}, {"--search-radius", "64"}, {"--motion-blur"}, {"--contour"}, {"--recovery"}};
  for (const std::vector<std::string>& options : idle) {
    const std::string flag = options.front();
    CAPTURE(flag);
    CHECK_NOTHROW(parsed(options));
    std::vector<std::string> both{"--mode", "paper"};
    both.insert(both.end(), options.begin(), options.end());
    const auto error = error_of([&] { parsed(both); });
    CHECK(error.code == ErrorCode::invalid_argument);
    CHECK(error.message.starts_with(flag + " has no effect beside --mode paper, which"));
  }
  CHECK_FALSE(parsed({"--mode", "paper", "--no-recovery", "--levels", "1"}).recovery);
}

TEST_CASE("Options of a part that is left out are refused") {
  const std::vector<std::vector<std::string>> idle{{"--no-gradient-test", "--gradient-minimum=0.1"},
                                                   {"--no-angle-test", "--angle-together"},
                                                   {"--difference-relative=0"},
                                                   {"--vote-share=0.5"},
                                                   {"--redundancy-cosine=0.8"},
                                                   {"--no-recovery", "--recovery-budget=9"},
                                                   {"--ablate=shift_search", "--search-radius=9"}};
  for (const std::vector<std::string>& options : idle) {
    CAPTURE(options.back());
    const auto error = error_of([&] { parsed(options); });
    CHECK(error.says(ErrorCode::invalid_argument, {"has no effect"}));
  }
  CHECK(parsed({"--mode", "paper", "--block-vote", "--vote-share=0.6"}).occlusion.vote_share == 0.6);
}

TEST_CASE("File names with blanks are taken whole") {
  CLI::App app;
  ModelArguments model;
  model.add_to(app);
  std::vector<std::string> arguments{"my model.obj", "--model"};
  app.parse(arguments);
  CHECK(model.path == "my model.obj");
}
