#pragma once

#include <algorithm>
#include <vector>

namespace structnerf {

// The middle value, or the mean of the two middle ones; 0 if there is none.
// Reorders the values.
template <typename T>
double Median(std::vector<T>* values) {
  if (values->empty()) {
    return 0;
  }
  const auto middle = values->begin() + values->size() / 2;
  std::nth_element(values->begin(), middle, values->end());
  if (values->size() % 2 == 1) {
    return *middle;
  }
  return 0.5 *
         (static_cast<double>(*std::max_element(values->begin(), middle)) +
          *middle);
}

}  // namespace structnerf
