#pragma once

#include <ctime>

namespace structnerf {

inline double ReadClock(const clockid_t clock) {
  timespec time;
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * time.tv_nsec;
}

// Processor time of the calling thread, and of all threads of the program.
// Other programs on a shared machine disturb it much less than elapsed time.
inline double ThreadCpuSeconds() { return ReadClock(CLOCK_THREAD_CPUTIME_ID); }
inline double ProcessCpuSeconds() {
  return ReadClock(CLOCK_PROCESS_CPUTIME_ID);
}

}  // namespace structnerf
