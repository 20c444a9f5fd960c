#pragma once

#include "nerf/engine/stage_clock.h"
#include "nerf/field/field_layout.h"
#include "nerf/kernels/adam.h"
#include "nerf/kernels/grid_gradient.h"
#include "nerf/util/aligned_buffer.h"
#include "nerf/util/state_stream.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include <hwy/base.h>

namespace structnerf {

// The grid of the fused engine: tables in half precision that rays read, full
// precision copies and moments that the optimiser updates, and the gradient,
// kept as the tiles' sorted corners until it is used.
class FusedGrid {
 public:
  // `tile_samples`: most samples of a tile.
  FusedGrid(const FieldLayout& layout, size_t tile_samples, int num_threads);
  ~FusedGrid();

  // Features of some points, samples x encoding_width. Reads up to 15 numbers
  // beyond the end of the positions.
  //   level_weights: factor on each level's features; empty = all one.
  void Encode(const float* x,
              const float* y,
              const float* z,
              size_t num_samples,
              const std::vector<float>& level_weights,
              int thread,
              float* encoding) const;

  // Makes room for the gradients of more tiles, numbered from the end of what
  // there is, and returns the number of the first.
  size_t AddTiles(size_t num_tiles);

  // Takes in the gradient by the features of one tile's points. Returns for how
  // many of them it is more than rounding.
  //   d_encoding: samples x encoding_width.
  size_t SetTileGradient(size_t tile,
                         const float* x,
                         const float* y,
                         const float* z,
                         size_t num_samples,
                         const std::vector<float>& level_weights,
                         const float* d_encoding,
                         int thread);

  // The table in regions that are updated on their own.
  size_t NumBuckets() const { return buckets_.size(); }

  // Updates the entries of a bucket that have a gradient. Returns false if a
  // gradient was not finite; its entry then stays as it was. Adds the time it
  // takes to `clock`.
  bool UpdateBucket(size_t bucket_idx,
                    const AdamStep& step,
                    int thread,
                    StageClock* clock);

  // Forgets all tiles.
  void ClearTiles() { num_tiles_ = 0; }

  // num_grid_entries x kGridFeatures each.
  std::vector<float> Parameters() const;
  void SetParameters(const std::vector<float>& parameters);
  std::vector<float> Gradients() const;

  // Lets the optimiser start anew.
  void ClearMoments();

  // Parameters and moments, as they are stored.
  void SaveState(StateWriter* writer) const;
  void LoadState(StateReader* reader);

 private:
  struct TileGradient;
  struct Level;
  struct Scratch;

  // Sums up the gradient of one bucket and returns how many entries it
  // touches, which scratch->touched_entries then lists.
  size_t SumBucket(size_t level, size_t bucket, Scratch* scratch) const;

  const FieldLayout& layout_;
  const size_t tile_samples_;
  std::vector<Level> levels_;
  std::vector<std::unique_ptr<Scratch>> scratch_;  // per thread

  // (level, bucket) in the order in which threads take them.
  std::vector<std::pair<uint32_t, uint32_t>> buckets_;

  size_t num_tiles_ = 0;  // that hold a gradient
};

}  // namespace structnerf
