#pragma once

namespace structnerf {

// Counts Ctrl-C (SIGINT) instead of dying from it, while it lives. The third
// one ends the process at once, in case the second goes unheard. SIGTERM
// counts as two. At most one object at a time.
class ScopedInterrupts {
 public:
  ScopedInterrupts();
  ~ScopedInterrupts();

  ScopedInterrupts(const ScopedInterrupts&) = delete;
  ScopedInterrupts& operator=(const ScopedInterrupts&) = delete;

  // Since the construction; none without an object.
  static int Count();
  static bool WasTerminated();  // by SIGTERM
};

}  // namespace structnerf
