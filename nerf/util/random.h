#pragma once

#include <cmath>
#include <cstdint>

namespace structnerf {

// Small random number generator (PCG-XSH-RR, O'Neill 2014). A stream is named
// by numbers such as (seed, step, tile), so that what a piece of work draws
// does not depend on which thread does it, or when.
class Random {
 public:
  explicit Random(uint64_t seed, uint64_t stream = 0, uint64_t substream = 0) {
    state_ = Mix(seed + Mix(stream + Mix(substream)));
  }

  uint32_t NextUint32() {
    const uint64_t old_state = state_;
    state_ = old_state * 6364136223846793005ULL + 1442695040888963407ULL;
    const uint32_t xor_shifted =
        static_cast<uint32_t>(((old_state >> 18) ^ old_state) >> 27);
    const uint32_t rotation = static_cast<uint32_t>(old_state >> 59);
    return (xor_shifted >> rotation) | (xor_shifted << ((32 - rotation) & 31));
  }

  // Uniform in [0, 1).
  float NextFloat() { return (NextUint32() >> 8) * (1.0f / 16777216.0f); }

  // Of the standard normal distribution (Box and Muller 1958).
  float NextNormal() {
    const float radius = std::sqrt(-2.0f * std::log(1.0f - NextFloat()));
    return radius * std::cos(6.2831853f * NextFloat());
  }

  // Uniform in [0, bound); bound > 0.
  uint32_t NextBelow(const uint32_t bound) {
    return static_cast<uint32_t>(
        (static_cast<uint64_t>(NextUint32()) * bound) >> 32);
  }

 private:
  // Finaliser of splitmix64 (Steele et al. 2014).
  static uint64_t Mix(uint64_t x) {
    x += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
  }

  uint64_t state_;
};

}  // namespace structnerf
