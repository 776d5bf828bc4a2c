#include "evaluation/plots.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <spawn.h>
#include <sys/wait.h>

#include <string_view>
#include <vector>

#include "evaluation/plot_script.hpp"
#include "holdfast/error.hpp"

extern char** environ;

namespace holdfast::evaluation {
namespace {

constexpr int kNotFound = 127;

/// The program's exit code; kNotFound where it cannot be started. Its error output is thrown away when `silent`.
int run(const std::vector<std::string>& arguments, bool silent) {
  std::vector<std::string> copies = arguments;
  std::vector<char*> pointers;
  for (std::string& argument : copies) {
    pointers.push_back(argument.data());
  }
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (silent) {
    posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
  }
  // Spawned, not forked: a fork after OpenCL's threads have started hangs.
  pid_t child = 0;
  const int failed = posix_spawnp(&child, pointers[0], &actions, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) {
    return kNotFound;
  }
  int status = 0;
  if (waitpid(child, &status, 0) != child || !WIFEXITED(status)) {
    return 1;
  }
  return WEXITSTATUS(status);
}

}  // namespace

void require_plotting(const std::string& python) {
  const int code = run({python, "-c", "import matplotlib"}, true);
  if (code == kNotFound) {
    throw Error(ErrorCode::invalid_argument,
                fmt::format("--plots needs {}: it was not found; install python3 and python3-matplotlib", python));
  }
  if (code != 0) {
    throw Error(ErrorCode::invalid_argument,
                fmt::format("--plots needs matplotlib, which {} does not have; install python3-matplotlib", python));
  }
}

void draw_plots(const std::filesystem::path& report, const std::filesystem::path& folder, const std::string& python) {
  const std::string script(plot_script("plot.py"));
  const int code = run({python, "-c", script, report.string(), folder.string()}, false);
  if (code != 0) {
    throw Error(ErrorCode::output,
                fmt::format("{}: the plots could not be drawn ({} ended with {})", folder.string(), python, code));
  }
}

}  // namespace holdfast::evaluation
