#include "nerf/engine/fused_grid.h"

#include "nerf/kernels/grid_encoding.h"
#include "nerf/kernels/half_precision.h"

#include <algorithm>
#include <iterator>

#include <hwy/cache_control.h>

namespace structnerf {
namespace {

// Samples whose grid corners are computed at a time; the corners of one level
// then stay in the first-level cache.
constexpr size_t kCornerChunk = 128;

float LevelWeight(const std::vector<float>& level_weights, const size_t level) {
  return level_weights.empty() ? 1.0f : level_weights[level];
}

void PrefetchBytes(const void* data, const size_t num_bytes) {
  constexpr size_t kCacheLine = 64;
  for (size_t i = 0; i < num_bytes; i += kCacheLine) {
    hwy::Prefetch(static_cast<const char*>(data) + i);
  }
}

}  // namespace

// One tile's share of one level's gradient.
struct FusedGrid::TileGradient {
  TileGradient(const size_t tile_samples, const size_t num_buckets)
      : pairs(8 * tile_samples),
        bucket_begin(num_buckets + 1),
        d_encoding(tile_samples * kGridFeatures) {}

  // See SortCornerPairs.
  AlignedBuffer<CornerPair> pairs;
  AlignedBuffer<uint16_t> bucket_begin;
  AlignedBuffer<float> d_encoding;  // samples x kGridFeatures
};

struct FusedGrid::Level {
  explicit Level(const GridLevel& level)
      : num_buckets((level.num_entries + kBucketEntries - 1) / kBucketEntries),
        table(level.num_entries * kGridFeatures),
        state(level.num_entries) {}

  size_t num_buckets;
  AlignedBuffer<hwy::float16_t> table;
  AlignedBuffer<GridEntryState> state;
  std::vector<TileGradient> tiles;
};

// What one thread needs.
struct FusedGrid::Scratch {
  Scratch(const size_t tile_samples, const size_t max_buckets)
      : entries(8 * kCornerChunk),
        weights(8 * kCornerChunk),
        position{AlignedBuffer<float>(tile_samples),
                 AlignedBuffer<float>(tile_samples),
                 AlignedBuffer<float>(tile_samples)},
        selected(tile_samples + 1),
        buckets(4 * tile_samples),
        pairs(4 * tile_samples),
        sort(4 * max_buckets),
        gradient(kBucketEntries * kGridFeatures),
        touched(kBucketEntries),
        touched_entries(kBucketEntries) {}

  AlignedBuffer<uint32_t> entries;
  AlignedBuffer<float> weights;
  AlignedBuffer<float> position[3];
  AlignedBuffer<uint16_t> selected;
  AlignedBuffer<uint32_t> buckets;
  AlignedBuffer<CornerPair> pairs;
  AlignedBuffer<uint16_t> sort;
  AlignedBuffer<float> gradient;
  AlignedBuffer<uint8_t> touched;
  AlignedBuffer<uint16_t> touched_entries;
};

FusedGrid::FusedGrid(const FieldLayout& layout,
                     const size_t tile_samples,
                     const int num_threads)
    : layout_(layout), tile_samples_((tile_samples + 15) / 16 * 16) {
  size_t max_buckets = 0;
  for (const GridLevel& level : layout.levels) {
    levels_.emplace_back(level);
    max_buckets = std::max(max_buckets, levels_.back().num_buckets);
  }
  for (int thread = 0; thread < num_threads; ++thread) {
    scratch_.push_back(std::make_unique<Scratch>(tile_samples_, max_buckets));
  }
  for (uint32_t level = 0; level < levels_.size(); ++level) {
    for (uint32_t bucket = 0; bucket < levels_[level].num_buckets; ++bucket) {
      buckets_.emplace_back(level, bucket);
    }
  }
}

FusedGrid::~FusedGrid() = default;

void FusedGrid::Encode(const float* x,
                       const float* y,
                       const float* z,
                       const size_t num_samples,
                       const std::vector<float>& level_weights,
                       const int thread,
                       float* encoding) const {
  Scratch& scratch = *scratch_[thread];
  const size_t width = layout_.encoding_width;
  for (size_t begin = 0; begin < num_samples; begin += kCornerChunk) {
    const size_t size = std::min(kCornerChunk, num_samples - begin);
    for (size_t level = 0; level < levels_.size(); ++level) {
      float* const features = encoding + begin * width + level * kGridFeatures;
      const float level_weight = LevelWeight(level_weights, level);
      if (level_weight == 0) {
        for (size_t s = 0; s < size; ++s) {
          std::fill(
              features + s * width, features + s * width + kGridFeatures, 0.0f);
        }
        continue;
      }
      GridCorners(layout_.levels[level],
                  x + begin,
                  y + begin,
                  z + begin,
                  size,
                  kCornerChunk,
                  scratch.entries.data(),
                  scratch.weights.data());
      GridInterpolate(levels_[level].table.data(),
                      scratch.entries.data(),
                      scratch.weights.data(),
                      size,
                      kCornerChunk,
                      level_weight,
                      width,
                      features);
    }
  }
}

size_t FusedGrid::AddTiles(const size_t num_tiles) {
  const size_t first_tile = num_tiles_;
  num_tiles_ += num_tiles;
  for (Level& level : levels_) {
    while (level.tiles.size() < num_tiles_) {
      level.tiles.emplace_back(tile_samples_, level.num_buckets);
    }
  }
  return first_tile;
}

size_t FusedGrid::SetTileGradient(const size_t tile,
                                  const float* x,
                                  const float* y,
                                  const float* z,
                                  const size_t num_samples,
                                  const std::vector<float>& level_weights,
                                  const float* d_encoding,
                                  const int thread) {
  Scratch& scratch = *scratch_[thread];
  const size_t width = layout_.encoding_width;
  const size_t num_selected = SelectSamples(d_encoding,
                                            num_samples,
                                            width,
                                            kNegligibleGradient,
                                            scratch.selected.data());
  const float* const coordinates[3] = {x, y, z};
  for (int axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < num_selected; ++i) {
      scratch.position[axis][i] = coordinates[axis][scratch.selected[i]];
    }
  }
  for (size_t level = 0; level < levels_.size(); ++level) {
    const float level_weight = LevelWeight(level_weights, level);
    TileGradient& gradient = levels_[level].tiles[tile];
    if (level_weight == 0 || num_selected == 0) {
      std::fill(gradient.bucket_begin.data(),
                gradient.bucket_begin.data() + gradient.bucket_begin.size(),
                uint16_t{0});
      continue;
    }
    PrefetchBytes(gradient.pairs.data(), 4 * num_selected * sizeof(CornerPair));
    GridCornerPairs(layout_.levels[level],
                    scratch.position[0].data(),
                    scratch.position[1].data(),
                    scratch.position[2].data(),
                    num_selected,
                    tile_samples_,
                    scratch.buckets.data(),
                    scratch.pairs.data());
    SortCornerPairs(scratch.buckets.data(),
                    scratch.pairs.data(),
                    num_selected,
                    tile_samples_,
                    levels_[level].num_buckets,
                    scratch.sort.data(),
                    gradient.bucket_begin.data(),
                    gradient.pairs.data());
    CopyFeatures(d_encoding + level * kGridFeatures,
                 scratch.selected.data(),
                 num_selected,
                 width,
                 level_weight,
                 gradient.d_encoding.data());
  }
  return num_selected;
}

size_t FusedGrid::SumBucket(const size_t level,
                            const size_t bucket,
                            Scratch* scratch) const {
  const std::vector<TileGradient>& tiles = levels_[level].tiles;
  const auto tile_corners = [&](const size_t tile) {
    TileCorners corners;
    if (tile < num_tiles_) {
      const uint16_t* const begin = tiles[tile].bucket_begin.data() + bucket;
      corners.pairs = tiles[tile].pairs.data() + begin[0];
      corners.num_pairs = begin[1] - begin[0];
      corners.d_encoding = tiles[tile].d_encoding.data();
    }
    return corners;
  };
  TileCorners corners = tile_corners(0);
  TileCorners next = tile_corners(1);
  for (size_t tile = 0; tile < num_tiles_; ++tile) {
    const TileCorners after_next = tile_corners(tile + 2);
    PrefetchBytes(after_next.pairs, after_next.num_pairs * sizeof(CornerPair));
    SumCorners(
        corners, next, scratch->gradient.data(), scratch->touched.data());
    corners = next;
    next = after_next;
  }
  return ListTouched(scratch->touched.data(), scratch->touched_entries.data());
}

bool FusedGrid::UpdateBucket(const size_t bucket_idx,
                             const AdamStep& step,
                             const int thread,
                             StageClock* clock) {
  const auto [level, bucket] = buckets_[bucket_idx];
  Scratch& scratch = *scratch_[thread];
  clock->Start();
  const size_t num_touched = SumBucket(level, bucket, &scratch);
  clock->Stop(EngineStage::kSumGradient);
  const size_t first_entry = static_cast<size_t>(bucket) * kBucketEntries;
  const bool is_finite =
      AdamUpdateGrid(step,
                     scratch.touched_entries.data(),
                     num_touched,
                     scratch.gradient.data(),
                     levels_[level].state.data() + first_entry,
                     levels_[level].table.data() + first_entry * kGridFeatures);
  clock->Stop(EngineStage::kUpdateGrid);
  return is_finite;
}

std::vector<float> FusedGrid::Parameters() const {
  std::vector<float> parameters(layout_.num_grid_entries * kGridFeatures);
  for (size_t level = 0; level < levels_.size(); ++level) {
    float* values =
        parameters.data() + layout_.levels[level].first_entry * kGridFeatures;
    const AlignedBuffer<GridEntryState>& state = levels_[level].state;
    for (size_t entry = 0; entry < state.size(); ++entry) {
      std::copy(state[entry].value, state[entry].value + kGridFeatures, values);
      values += kGridFeatures;
    }
  }
  return parameters;
}

void FusedGrid::SetParameters(const std::vector<float>& parameters) {
  for (size_t level = 0; level < levels_.size(); ++level) {
    const float* const values =
        parameters.data() + layout_.levels[level].first_entry * kGridFeatures;
    AlignedBuffer<GridEntryState>& state = levels_[level].state;
    for (size_t entry = 0; entry < state.size(); ++entry) {
      std::copy(values + entry * kGridFeatures,
                values + (entry + 1) * kGridFeatures,
                state[entry].value);
    }
    HalfFromFloat(
        values, state.size() * kGridFeatures, levels_[level].table.data());
  }
}

void FusedGrid::ClearMoments() {
  for (Level& level : levels_) {
    for (size_t entry = 0; entry < level.state.size(); ++entry) {
      GridEntryState& state = level.state[entry];
      std::fill(std::begin(state.first_moment),
                std::end(state.first_moment),
                uint16_t{0});
      std::fill(std::begin(state.root_second_moment),
                std::end(state.root_second_moment),
                uint16_t{0});
    }
  }
}

std::vector<float> FusedGrid::Gradients() const {
  std::vector<float> gradients(layout_.num_grid_entries * kGridFeatures);
  Scratch& scratch = *scratch_[0];
  for (const auto& [level, bucket] : buckets_) {
    const size_t num_touched = SumBucket(level, bucket, &scratch);
    float* const bucket_gradients =
        gradients.data() + (layout_.levels[level].first_entry +
                            static_cast<size_t>(bucket) * kBucketEntries) *
                               kGridFeatures;
    for (size_t i = 0; i < num_touched; ++i) {
      const size_t entry = scratch.touched_entries[i];
      float* const gradient = scratch.gradient.data() + entry * kGridFeatures;
      std::copy(gradient,
                gradient + kGridFeatures,
                bucket_gradients + entry * kGridFeatures);
      std::fill(gradient, gradient + kGridFeatures, 0.0f);
    }
  }
  return gradients;
}

void FusedGrid::SaveState(StateWriter* writer) const {
  for (const Level& level : levels_) {
    writer->Write(level.state.data(),
                  level.state.size() * sizeof(GridEntryState));
  }
}

void FusedGrid::LoadState(StateReader* reader) {
  for (Level& level : levels_) {
    reader->Read(level.state.data(),
                 level.state.size() * sizeof(GridEntryState));
  }
  SetParameters(Parameters());  // the tables
}

}  // namespace structnerf
