#pragma once

#include "nerf/field/field_layout.h"
#include "nerf/util/random.h"
#include "tests/stability/stability_case.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <hwy/highway.h>

namespace structnerf {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kLargest = std::numeric_limits<float>::max();

// Calls `run` once per instruction set and returns the largest result.
inline double WorstOfTargets(const std::function<double()>& run) {
  double worst = 0;
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    worst = std::max(worst, run());
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  return worst;
}

// Any of the values, `count` times.
inline std::vector<float> PickMany(const std::vector<float>& values,
                                   const size_t count,
                                   const uint64_t seed) {
  Random random(seed);
  std::vector<float> picked(count);
  for (float& value : picked) {
    value = values[random.NextBelow(static_cast<uint32_t>(values.size()))];
  }
  return picked;
}

// A grid with far more cells than entries, in a box that is almost flat.
inline FieldLayout ExtremeLayout() {
  FieldOptions options;
  options.log2_table_size = 12;
  options.max_resolution = 65536;
  return FieldLayout(options, Eigen::Vector3f(1, 1e-3f, 0.5f));
}

// Coordinates in and far outside of it.
inline std::vector<float> ExtremePlaces(const size_t count,
                                        const uint64_t seed) {
  return PickMany({-kInfinity,
                   -kLargest,
                   -1e-40f,
                   0,
                   1e-40f,
                   0.5f,
                   1,
                   1.5f,
                   kLargest,
                   kInfinity,
                   kNan},
                  count,
                  seed);
}

inline void RequireFinite(const std::vector<float>& values,
                          const std::string& what) {
  for (const float value : values) {
    RequireStable(std::isfinite(value), what + " is " + ShortNumber(value));
  }
}

}  // namespace structnerf
