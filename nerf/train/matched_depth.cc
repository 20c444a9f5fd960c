#include "nerf/train/matched_depth.h"

#include <algorithm>
#include <cstddef>

namespace structnerf {

double ConfirmedShare(const MatchedDepth& depth) {
  size_t num_pixels = 0;
  size_t num_confirmed = 0;
  for (const std::vector<float>& view : depth) {
    num_pixels += view.size();
    num_confirmed += view.size() - std::count(view.begin(), view.end(), 0.0f);
  }
  return static_cast<double>(num_confirmed) /
         static_cast<double>(std::max<size_t>(1, num_pixels));
}

}  // namespace structnerf
