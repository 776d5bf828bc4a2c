#include "track/interruption.hpp"

#include <atomic>

namespace holdfast::app {
namespace {

// A signal handler can reach nothing but a static.
std::atomic<bool> signalled = false;
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void remember_signal(int) { signalled = true; }

}  // namespace

Interruption::Interruption() {
  signalled = false;
  struct sigaction action {};
  action.sa_handler = remember_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  sigaction(SIGINT, &action, &previous_int_);
  sigaction(SIGTERM, &action, &previous_term_);
  sigaction(SIGHUP, nullptr, &previous_hup_);
  if (previous_hup_.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);  // nohup wants it ignored
  // A reader that has gone is an output that cannot be written: the others are still finished.
  action.sa_handler = SIG_IGN;
  action.sa_flags = 0;
  sigaction(SIGPIPE, &action, &previous_pipe_);
}

Interruption::~Interruption() {
  signalled = false;
  sigaction(SIGINT, &previous_int_, nullptr);
  sigaction(SIGTERM, &previous_term_, nullptr);
  sigaction(SIGHUP, &previous_hup_, nullptr);
  sigaction(SIGPIPE, &previous_pipe_, nullptr);
}

bool Interruption::requested() { return signalled; }

}  // namespace holdfast::app
