#pragma once

#include <csignal>

namespace holdfast::app {

/// While one lives, Ctrl-C (SIGINT), SIGTERM and SIGHUP ask for an orderly end instead of killing the program; a second
/// signal kills it. A pipe that nobody reads any more is an error of its writer. One at a time.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  /// False where none lives.
  static bool requested();

 private:
  struct sigaction previous_int_ {};
  struct sigaction previous_term_ {};
  struct sigaction previous_hup_ {};
  struct sigaction previous_pipe_ {};
};

}  // namespace holdfast::app
