#pragma once

#include "nerf/dense_maps.h"

#include <cstddef>
#include <functional>
#include <vector>

namespace structnerf {

// Depth and normals of all views, while views are compared. Those that do not
// fit into the memory limit are read, again if need be.
class DepthMapCache {
 public:
  // `read` returns the maps of a view. `max_bytes` is exceeded when the maps of
  // one request alone need more.
  DepthMapCache(std::function<DenseMaps(size_t view_idx)> read,
                size_t num_views,
                size_t max_bytes);

  // Takes maps that can be read already.
  void Insert(size_t view_idx, DenseMaps maps);

  // Maps of all views, of which those of `view_idxs` are present and others may
  // be empty. Depth and normals only. Valid until the next call.
  const std::vector<DenseMaps>& Require(const std::vector<int>& view_idxs);

 private:
  void Add(size_t view_idx, DenseMaps maps);
  void EvictUnused();

  const std::function<DenseMaps(size_t view_idx)> read_;
  const size_t max_bytes_;
  std::vector<DenseMaps> maps_;
  std::vector<size_t> last_used_;  // request in which each was used last
  size_t request_ = 0;
  size_t num_bytes_ = 0;
};

}  // namespace structnerf
