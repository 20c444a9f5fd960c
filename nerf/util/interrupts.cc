#include "nerf/util/interrupts.h"

#include <atomic>

#include <signal.h>
#include <unistd.h>

namespace structnerf {
namespace {

static_assert(std::atomic<int>::is_always_lock_free,
              "signal handlers may not wait for locks");

std::atomic<int> num_interrupts{0};
std::atomic<int> num_terminations{0};
struct sigaction previous_int_action;
struct sigaction previous_term_action;

void HandleInterrupt(const int signal_number) {
  if (signal_number == SIGTERM) {
    ++num_terminations;
  }
  const int count =
      num_interrupts.fetch_add(signal_number == SIGTERM ? 2 : 1) + 1;
  if (count >= 3) {
    _exit(128 + signal_number);
  }
}

}  // namespace

ScopedInterrupts::ScopedInterrupts() {
  struct sigaction action = {};
  action.sa_handler = HandleInterrupt;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, &previous_int_action);
  sigaction(SIGTERM, &action, &previous_term_action);
}

ScopedInterrupts::~ScopedInterrupts() {
  sigaction(SIGINT, &previous_int_action, nullptr);
  sigaction(SIGTERM, &previous_term_action, nullptr);
  num_interrupts = 0;
  num_terminations = 0;
}

int ScopedInterrupts::Count() { return num_interrupts; }

bool ScopedInterrupts::WasTerminated() { return num_terminations > 0; }

}  // namespace structnerf
