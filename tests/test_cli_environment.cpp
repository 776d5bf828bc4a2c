// What the program does to its surroundings: the environment, standard streams, the folders of compiled kernels.
#include <doctest/doctest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>

#include "exit_codes.hpp"
#include "support/files.hpp"
#include "support/run_program.hpp"
#include "support/small_sequence.hpp"

namespace fs = std::filesystem;
using namespace holdfast;
using namespace holdfast::test;

namespace {

const Arguments kTrack{"track",      "frames", "--model",   "box.obj", "--camera",
                       "camera.yml", "--init", "first.txt", "--poses", "poses.csv"};

}  // namespace

TEST_CASE("the environment is changed only while there is one thread" *
          doctest::skip(std::string(HOLDFAST_ENVIRONMENT_WATCH).empty())) {
  const TemporaryFolder folder;
  write_small_sequence(folder, 3);
  const std::string watched = (folder / "watched.txt").string();
  const Environment environment{
      {"LD_PRELOAD", HOLDFAST_ENVIRONMENT_WATCH}, {"HOLDFAST_WATCHED", watched}, {"OPENCV_FFMPEG_LOGLEVEL", ""}};
  for (const Arguments& arguments : {kTrack, Arguments{"devices"}, Arguments{"evaluate", ".", "--model", "box.obj"}}) {
    CAPTURE(arguments.front());
    fs::remove(watched);
    run_holdfast(arguments, folder, environment);
    const std::string changes = read_file(watched);
    CAPTURE(changes);
    CHECK(changes.find("setenv") != std::string::npos);  // the program's own at least
    std::istringstream lines(changes);
    for (std::string line; std::getline(lines, line);) {
      CAPTURE(line);
      // PoCL 7 sets this while it starts, beside a thread of its own that waits for work.
      const bool by_pocl = line == "setenv HWLOC_PLUGINS_PATH threads=2";
      CHECK((line.ends_with("threads=1") || by_pocl));
    }
  }
}

TEST_CASE("a standard output that takes nothing is an error, and closed ones do not become files" *
          doctest::skip(!fs::exists("/dev/full"))) {
  const TemporaryFolder folder;
  write_small_sequence(folder, 3);
  const auto run = [&](const std::string& redirections) {
    return run_program("/bin/sh",
                       {"-c", "exec \"$0\" \"$@\" " + redirections, program_path(), "track", "frames", "--model",
                        "box.obj", "--camera", "camera.yml", "--init", "first.txt", "--poses", "poses.csv"},
                       folder.path());
  };
  const ProgramRun full = run(">/dev/full");
  check_error(full, app::kOutput, {"standard output"});
  for (const char* closed : {">&-", "<&- >&- 2>&-"}) {
    CAPTURE(closed);
    fs::remove(folder / "poses.csv");
    CHECK(run(closed).exit_code == app::kOk);
    const std::string poses = read_file(folder / "poses.csv");
    CHECK(poses.starts_with("frame,"));
    CHECK(std::count(poses.begin(), poses.end(), '\n') == 4);  // heading and three frames, nothing else
  }
}

TEST_CASE("where PoCL's cache cannot be written, it runs all the same and says where it keeps its kernels") {
  const TemporaryFolder folder;
  const std::string blocked = folder.write("blocked", "a file, no folder").string();
  const fs::path temporary = folder / "tmp";
  fs::create_directory(temporary);
  const ProgramRun run =
      run_holdfast({"devices"}, folder, {{"POCL_CACHE_DIR", blocked}, {"TMPDIR", temporary.string()}});
  CAPTURE(run.err);
  CHECK(run.exit_code == app::kOk);
  CHECK(run.err.find("warning") != std::string::npos);
  CHECK(run.err.find(blocked) != std::string::npos);
  CHECK(run.err.find(temporary.string()) != std::string::npos);

  const ProgramRun without_home =
      run_holdfast({"devices"}, folder,
                   {{"POCL_CACHE_DIR", ""}, {"XDG_CACHE_HOME", ""}, {"HOME", ""}, {"TMPDIR", temporary.string()}});
  CAPTURE(without_home.err);
  CHECK(without_home.exit_code == app::kOk);

  const std::string nowhere = folder.write("nowhere", "").string();
  const ProgramRun refused = run_holdfast({"devices"}, folder, {{"POCL_CACHE_DIR", blocked}, {"TMPDIR", nowhere}});
  CAPTURE(refused.err);
  CHECK((refused.exit_code == app::kOk || refused.err.find(blocked) != std::string::npos));
}
