#include "colmap_plugin/depth_map_cache.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace structnerf {
namespace {

size_t NumBytes(const DenseMaps& maps) {
  return (maps.depth.size() + maps.normal.size()) * sizeof(float);
}

}  // namespace

DepthMapCache::DepthMapCache(std::function<DenseMaps(size_t view_idx)> read,
                             const size_t num_views,
                             const size_t max_bytes)
    : read_(std::move(read)),
      max_bytes_(max_bytes),
      maps_(num_views),
      last_used_(num_views, 0) {}

void DepthMapCache::Insert(const size_t view_idx, DenseMaps maps) {
  ++request_;
  Add(view_idx, std::move(maps));
  EvictUnused();
}

const std::vector<DenseMaps>& DepthMapCache::Require(
    const std::vector<int>& view_idxs) {
  ++request_;
  for (const int view_idx : view_idxs) {
    last_used_[view_idx] = request_;
  }
  for (const int view_idx : view_idxs) {
    if (maps_[view_idx].depth.empty()) {
      Add(view_idx, read_(view_idx));
      EvictUnused();
    }
  }
  return maps_;
}

void DepthMapCache::Add(const size_t view_idx, DenseMaps maps) {
  DenseMaps& entry = maps_[view_idx];
  entry.width = maps.width;
  entry.height = maps.height;
  entry.depth = std::move(maps.depth);
  entry.normal = std::move(maps.normal);
  last_used_[view_idx] = request_;
  num_bytes_ += NumBytes(entry);
}

void DepthMapCache::EvictUnused() {
  if (num_bytes_ <= max_bytes_) {
    return;
  }
  std::vector<size_t> view_idxs(maps_.size());
  std::iota(view_idxs.begin(), view_idxs.end(), 0);
  std::sort(view_idxs.begin(), view_idxs.end(), [this](size_t a, size_t b) {
    return last_used_[a] < last_used_[b];
  });
  for (const size_t view_idx : view_idxs) {
    if (num_bytes_ <= max_bytes_ || last_used_[view_idx] == request_) {
      return;
    }
    num_bytes_ -= NumBytes(maps_[view_idx]);
    maps_[view_idx] = DenseMaps();
  }
}

}  // namespace structnerf
