#pragma once

#include "tests/stability/stability_case.h"

#include <cmath>
#include <string>

namespace structnerf {

// Losses and gradients against double, relative to what they are made of.
struct LossError {
  double value = 0;
  double gradient = 0;

  std::string Text() const {
    return "values within " + ShortNumber(value) + ", gradients within " +
           ShortNumber(gradient) + " of double";
  }
};

// The text of the error and more, if it is acceptable; throws UnstableError
// otherwise.
inline std::string Accept(const LossError& error,
                          const double max_value,
                          const double max_gradient,
                          const std::string& more = "") {
  RequireStable(error.value <= max_value && error.gradient <= max_gradient,
                error.Text());
  return error.Text() + more;
}

inline double RelativeError(const double actual, const double expected) {
  return std::abs(actual - expected) / (1 + std::abs(expected));
}

// Numeric derivative.
template <typename Function>
double Slope(const Function& function, const double x, const double step) {
  return (function(x + step) - function(x - step)) / (2 * step);
}

}  // namespace structnerf
