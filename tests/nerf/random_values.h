#pragma once

#include "nerf/util/random.h"

#include <vector>

namespace structnerf {

// Numbers uniform in [low, high) that depend on the seed only.
inline std::vector<float> RandomValues(const size_t count,
                                       const float low,
                                       const float high,
                                       const uint64_t seed) {
  Random random(seed);
  std::vector<float> values(count);
  for (float& value : values) {
    value = low + (high - low) * random.NextFloat();
  }
  return values;
}

}  // namespace structnerf
