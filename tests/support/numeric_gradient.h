#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace structnerf {

// Gradient of `function` at `x` by central differences. The step of each
// coordinate is `step` times the larger of its magnitude and one.
inline std::vector<double> NumericGradient(
    const std::function<double(const std::vector<double>&)>& function,
    std::vector<double> x,
    const double step = 1e-6) {
  std::vector<double> gradient(x.size());
  for (size_t i = 0; i < x.size(); ++i) {
    const double center = x[i];
    const double h = step * std::max(1.0, std::abs(center));
    x[i] = center + h;
    const double above = function(x);
    x[i] = center - h;
    const double below = function(x);
    x[i] = center;
    gradient[i] = (above - below) / (2 * h);
  }
  return gradient;
}

}  // namespace structnerf
