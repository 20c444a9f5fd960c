#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace structnerf {

// The value that a share, in [0, 1], of the others do not exceed: one of the
// values, the lower where the share falls between two. There must be at least
// one value. Reorders them.
template <typename T>
T Quantile(std::vector<T>* values, const double share) {
  const auto place =
      values->begin() + static_cast<ptrdiff_t>(share * (values->size() - 1));
  std::nth_element(values->begin(), place, values->end());
  return *place;
}

}  // namespace structnerf
