#pragma once

#include "colmap_plugin/dense_workspace.h"
#include "nerf/dense_maps.h"

#include <cstddef>
#include <string>
#include <vector>

namespace structnerf {

// The maps of all views, blank surfaces on planes (InterimStage::kCompleted),
// while their consistency is checked. Those that do not fit into the memory
// limit are read back from the workspace.
class DepthMapCache {
 public:
  // `workspace` must outlive this object. `max_bytes` is exceeded when the maps
  // of one request alone need more.
  DepthMapCache(const DenseWorkspace* workspace,
                std::vector<std::string> image_names,
                size_t max_bytes);

  // Takes maps that have been written to the workspace already.
  void Insert(size_t view_idx, DenseMaps maps);

  // Maps of all views, of which those of `view_idxs` are present and others may
  // be empty. Depth and normals only. Valid until the next call.
  const std::vector<DenseMaps>& Require(const std::vector<int>& view_idxs);

 private:
  void Add(size_t view_idx, DenseMaps maps);
  void EvictUnused();

  const DenseWorkspace* workspace_;
  const std::vector<std::string> image_names_;
  const size_t max_bytes_;
  std::vector<DenseMaps> maps_;
  std::vector<size_t> last_used_;  // request in which each was used last
  size_t request_ = 0;
  size_t num_bytes_ = 0;
};

}  // namespace structnerf
