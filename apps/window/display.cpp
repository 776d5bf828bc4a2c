#include "window/display.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>

#include "holdfast/error.hpp"
#include "modules/window_module.hpp"

namespace holdfast::app {
namespace {

constexpr unsigned kPatience = 30;  // seconds: a toolkit loads slowly on a busy machine or over a network

bool has_display() {
  const auto is_set = [](const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0';
  };
  return is_set("DISPLAY") || is_set("WAYLAND_DISPLAY");
}

/// Window toolkits abort the program when the display does not answer, so a child tries it first.
bool display_answers() {
  const WindowModule& window = window_module();
  const pid_t child = fork();
  if (child == 0) {
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    std::signal(SIGABRT, SIG_DFL);
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    alarm(kPatience);
    try {
      window.named_window("holdfast", cv::WINDOW_AUTOSIZE);
    } catch (...) {
      _exit(1);
    }
    _exit(0);
  }
  int status = 0;
  return child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace

void refuse_without_display(const std::string& option, const std::string& why, const std::string& instead) {
  throw Error(ErrorCode::invalid_argument, option + " needs a display (" + why + "): " + instead);
}

void require_display(const std::string& option, const std::string& instead) {
  if (!has_display()) refuse_without_display(option, "neither DISPLAY nor WAYLAND_DISPLAY is set", instead);
  if (!display_answers()) refuse_without_display(option, "the one that is set does not answer", instead);
}

}  // namespace holdfast::app
