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
  const TrackerOptions standard = parsed({});
  CHECK(standard.mode == Mode::standard);
  CHECK(standard.iterations == TrackerOptions().iterations);
  CHECK(standard.occlusion.block_vote == TrackerOptions().occlusion.block_vote);
  const TrackerOptions paper = parsed({"--mode", "paper"});
  const TrackerOptions wanted = TrackerOptions::paper();
  CHECK(paper.mode == Mode::paper);
  CHECK(paper.levels == wanted.levels);
  CHECK(paper.robust_weights == wanted.robust_weights);
  CHECK(paper.occlusion.difference_relative == wanted.occlusion.difference_relative);
  CHECK(paper.occlusion.block_vote);
  const TrackerOptions published = parsed({"--mode", "published"});
  CHECK(published.mode == Mode::paper);
  CHECK_FALSE(published.occlusion.block_vote);
  CHECK_FALSE(published.photometric);
  CHECK(published.blur_sigma == TrackerOptions::published().blur_sigma);
  const TrackerOptions fast = parsed({"--mode", "fast"});
  CHECK(fast.mode == Mode::fast);
  CHECK(fast.most_pixels == TrackerOptions::fast().most_pixels);
  CHECK(fast.texture_samples == 1);
  CHECK(fast.levels == standard.levels);
  CHECK(paper.occlusion.vote_relative);
  CHECK_FALSE(standard.occlusion.vote_relative);
  CHECK_FALSE(parsed({"--mode", "paper", "--no-vote-relative"}).occlusion.vote_relative);
}

TEST_CASE("An option changes its field in any mode, and no other") {
  for (const char* mode : {"default", "fast", "paper", "published"}) {
    CAPTURE(mode);
    const TrackerOptions base = parsed({"--mode", mode});
    const TrackerOptions changed = parsed({"--mode", mode, "--blur-sigma", "1.75", "--no-magnitude-test",
                                           "--all-channels", "--silhouette-margin", "1", "--angle-maximum", "0.3"});
    CHECK(changed.blur_sigma == 1.75);
    CHECK_FALSE(changed.occlusion.magnitude_test);
    CHECK(changed.occlusion.all_channels);
    CHECK(changed.silhouette_margin == 1);
    CHECK(changed.occlusion.angle_maximum == 0.3);
    CHECK(changed.levels == base.levels);
    CHECK(changed.occlusion.gradient_test == base.occlusion.gradient_test);
    CHECK(changed.photometric == base.photometric);
  }
  // A flag says what it says, whatever the mode's own value.
  CHECK(parsed({"--mode", "paper", "--robust-weights"}).robust_weights);
  CHECK_FALSE(parsed({"--no-robust-weights"}).robust_weights);
}

TEST_CASE("Configuration files: bare keys, sections, underscores; the command line wins") {
  const TemporaryFolder folder;
  const std::string file = folder
                               .write("c.ini",
                                      "; comment\nmode = fast\nblur_sigma = 1.5\nblock-vote = false\n[track]\n"
                                      "levels = 2\n[simulate]\nlevels = 7\nunheard-of = 1\n")
                               .string();
  const TrackerOptions read = parsed({"--config", file});
  CHECK(read.mode == Mode::fast);
  CHECK(read.blur_sigma == 1.5);
  CHECK_FALSE(read.occlusion.block_vote);
  CHECK(read.levels == 2);
  CHECK(parsed({"--config", file, "--levels", "3"}).levels == 3);
  const std::string negative = folder.write("n.toml", "photometric = false\n").string();
  CHECK_FALSE(parsed({"--config", negative}).photometric);
  CHECK_THROWS_AS(parsed({"--config", folder.write("u.toml", "unheard-of = 1\n").string()}), CLI::ParseError);
  CHECK_THROWS_AS(parsed({"--config", folder.write("s.toml", "[trak]\nlevels = 2\n").string()}), CLI::ParseError);
  CHECK_THROWS_AS(parsed({"--config", (folder / "none.toml").string()}), CLI::ParseError);
}

TEST_CASE("Values out of range name the flag that was typed") {
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"--gradient-minimum", "-1"},    {"--angle-maximum", "2"},
      {"--difference-maximum", "-1"},  {"--difference-relative", "-1"},
      {"--vote-share", "7"},           {"--redundancy-cosine", "1.5"},
      {"--blur-sigma", "40"},          {"--silhouette-margin", "9"},
      {"--depth-jump", "0"},           {"--levels", "0"},
      {"--finest-level", "5"},         {"--iterations", "0"},
      {"--search-radius", "-1"},       {"--lost-correlation", "3"},
      {"--lost-visible-share", "-0.1"}};
  for (const auto& [flag, value] : wrong) {
    CAPTURE(flag);
    const auto error = error_of([&, flag = flag, value = value] { parsed({flag, value}); });
    CHECK(error.code == ErrorCode::invalid_argument);
    CHECK(error.message.starts_with(flag + " must be "));
    CHECK(error.message.find('_') == std::string::npos);
  }
}

TEST_CASE("Paper mode refuses what it has no use for, unless it is as it would be anyway") {
  const std::vector<std::vector<std::string>> idle{
      {"--levels", "2"},     {"--finest-level", "1"},  {"--most-pixels", "9000"}, {"--enough-pixels", "900"},
      {"--iterations", "2"}, {"--correlation-search"}, {"--search-radius", "64"}, {"--motion-blur"},
      {"--coarse-color"},    {"--lens-blur"},          {"--challenge"},           {"--recovery"}};
  for (const std::vector<std::string>& options : idle) {
    const std::string flag = options.front();
    CAPTURE(flag);
    CHECK_NOTHROW(parsed(options));
    for (const std::string mode : {"paper", "published"}) {
      std::vector<std::string> both{"--mode", mode};
      both.insert(both.end(), options.begin(), options.end());
      const auto error = error_of([&] { parsed(both); });
      CHECK(error.code == ErrorCode::invalid_argument);
      CHECK(error.message.starts_with(flag + " has no effect beside --mode " + mode + ", which"));
    }
  }
  CHECK_FALSE(parsed({"--mode", "paper", "--no-recovery", "--levels", "1"}).recovery);
}

TEST_CASE("File names with blanks are taken whole") {
  CLI::App app;
  ModelArguments model;
  model.add_to(app);
  std::vector<std::string> arguments{"my model.obj", "--model"};
  app.parse(arguments);
  CHECK(model.path == "my model.obj");
}
