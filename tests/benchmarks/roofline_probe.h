#pragma once

#include <cstddef>

namespace structnerf {

// What this machine can do at best, measured with all of `num_threads` threads
// busy at the same time and given per thread and second of its processor time,
// so that a thread that has to wait for its turn counts the same. Each probe
// takes some tenths of a second and gives the median of several rounds.
class RooflineProbe {
 public:
  explicit RooflineProbe(int num_threads) : num_threads_(num_threads) {}

  // Cycles, taking a chain of dependent additions at one cycle each.
  double ClockRate() const;

  // Floating-point operations in fused multiply-adds of single precision that
  // stay in registers.
  double PeakFlops() const;

  // Independent reads of random cache lines of a buffer.
  double RandomLineRate(size_t num_bytes) const;

  // Bytes moved by updating a buffer larger than the caches in order.
  double StreamBandwidth() const;

 private:
  const int num_threads_;
};

// Name of the instruction set in use.
const char* SimdTargetInUse();

}  // namespace structnerf
