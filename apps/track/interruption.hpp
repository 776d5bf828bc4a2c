#pragma once

#include <csignal>

namespace holdfast::app {

/// While one lives, Ctrl-C (SIGINT) and SIGTERM ask for an orderly end instead of killing the program; a second signal
/// kills it. One at a time.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  bool requested() const;

 private:
  struct sigaction previous_int_ {};
  struct sigaction previous_term_ {};
};

}  // namespace holdfast::app
