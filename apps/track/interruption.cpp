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
}

Interruption::~Interruption() {
  sigaction(SIGINT, &previous_int_, nullptr);
  sigaction(SIGTERM, &previous_term_, nullptr);
}

bool Interruption::requested() const { return signalled; }

}  // namespace holdfast::app
