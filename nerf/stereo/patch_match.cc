#include "nerf/stereo/patch_match.h"

#include "nerf/util/random.h"

#include <algorithm>
#include <cmath>

// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nerf/stereo/patch_match.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
#include "nerf/stereo/window_cost-inl.h"
// clang-format on

namespace structnerf {
#ifndef NERF_STEREO_PATCH_MATCH_ONCE_
#define NERF_STEREO_PATCH_MATCH_ONCE_

// Rows worked on between two looks at whether to abort.
constexpr int kRowsPerBatch = 64;

// What a sweep over one view reads and writes.
struct PatchMatchSweep {
  const ViewWarp* warps = nullptr;  // of this view's sources
  int num_slots = 0;
  const uint16_t* grays = nullptr;
  size_t first_pixel = 0;  // of this view's image
  const StereoOptions* options = nullptr;
  const float* seed_rho = nullptr;
  PlaneMaps* maps = nullptr;
  int32_t* best_slots = nullptr;  // num_used_slots per pixel
  int num_used_slots = 0;
  // -1 = evaluate the seed and choose the sources, num_iterations = measure
  // distinctness.
  int iteration = -1;
  int color = 0;  // of the checkerboard
};

#endif  // NERF_STEREO_PATCH_MATCH_ONCE_
}  // namespace structnerf

HWY_BEFORE_NAMESPACE();
namespace structnerf {
namespace HWY_NAMESPACE {

// Relative changes of inverse depth at which a match must be worse.
constexpr float kDistinctChanges[] = {-0.06f, -0.03f, 0.03f, 0.06f};

// One vector of pixels of one colour in one row.
class PixelBlock {
 public:
  PixelBlock(const PatchMatchSweep& sweep,
             const int row,
             const int first_col,
             const int num_pixels)
      : sweep_(sweep), row_(row), num_pixels_(num_pixels) {
    const D d;
    HWY_ALIGN float x[16] = {};
    HWY_ALIGN float y[16] = {};
    HWY_ALIGN float seed[16];
    std::fill(seed, seed + 16, 1.0f);
    for (int i = 0; i < num_pixels; ++i) {
      cols_[i] = first_col + 2 * i;
      x[i] = static_cast<float>(cols_[i]) + 0.5f;
      y[i] = static_cast<float>(row) + 0.5f;
      seed[i] = sweep.seed_rho[Index(i)];
    }
    x_ = hn::Load(d, x);
    y_ = hn::Load(d, y);
    seed_rho_ = hn::Load(d, seed);
    ReadWindow(*sweep.options,
               sweep.grays + sweep.first_pixel,
               sweep.maps->width,
               sweep.maps->height,
               num_pixels,
               cols_,
               row,
               &window_);
  }

  // Cost of the seed in all sources; the best become those that are used.
  void ChooseSources() {
    const D d;
    const DI di;
    const Planes planes = Load();
    HWY_ALIGN float costs[kMaxSourceSlots][16];
    for (int slot = 0; slot < sweep_.num_slots; ++slot) {
      const PixelWarp warp = Warp(hn::Set(di, slot));
      hn::Store(
          SourceCost(sweep_.grays, warp, window_, planes), d, costs[slot]);
    }
    for (int i = 0; i < num_pixels_; ++i) {
      int order[kMaxSourceSlots];
      for (int slot = 0; slot < sweep_.num_slots; ++slot) {
        order[slot] = slot;
      }
      std::partial_sort(
          order,
          order + sweep_.num_used_slots,
          order + sweep_.num_slots,
          [&](const int a, const int b) { return costs[a][i] < costs[b][i]; });
      std::copy(order,
                order + sweep_.num_used_slots,
                sweep_.best_slots + Index(i) * sweep_.num_used_slots);
    }
  }

  void LoadSources() {
    const DI di;
    for (int k = 0; k < sweep_.num_used_slots; ++k) {
      HWY_ALIGN int32_t slots[16] = {};
      for (int i = 0; i < num_pixels_; ++i) {
        slots[i] = sweep_.best_slots[Index(i) * sweep_.num_used_slots + k];
      }
      warps_[k] = Warp(hn::Load(di, slots));
    }
  }

  // A pixel without a seed keeps the cost of one that no source sees: neither
  // is improved.
  void EvaluateCurrent() {
    const D d;
    const Planes planes = Load();
    const V cost = Cost(planes);
    Keep(planes,
         cost,
         hn::And(hn::Gt(seed_rho_, hn::Zero(d)),
                 hn::Lt(cost, hn::Set(d, kWorstCost))));
  }

  // Compares with the same plane, nearer and farther away. What no source sees
  // has nothing to compare.
  void MeasureDistinctness() {
    const D d;
    const Planes planes = Load();
    const V cost = LoadFrom(sweep_.maps->cost.data());
    V nearest_cost = hn::Set(d, kWorstCost);
    for (const float change : kDistinctChanges) {
      const V factor = hn::Set(d, 1.0f + change);
      V other_cost = Cost({hn::Mul(planes.rho, factor),
                           hn::Mul(planes.rho_x, factor),
                           hn::Mul(planes.rho_y, factor)});
      // Out of sight is no evidence.
      other_cost = hn::IfThenElse(
          hn::Lt(other_cost, hn::Set(d, kWorstCost)), other_cost, cost);
      nearest_cost = hn::Min(nearest_cost, other_cost);
    }
    HWY_ALIGN float values[16] = {};
    hn::Store(hn::IfThenElseZero(hn::Lt(cost, hn::Set(d, kWorstCost)),
                                 hn::Sub(nearest_cost, cost)),
              d,
              values);
    for (int i = 0; i < num_pixels_; ++i) {
      sweep_.maps->distinctness[Index(i)] = values[i];
    }
  }

  // Tries the planes of neighbours and random changes of the own.
  void Improve() {
    const D d;
    best_ = Load();
    best_cost_ = LoadFrom(sweep_.maps->cost.data());
    // Odd offsets only: those pixels have the other colour.
    constexpr int kOffsets[8][2] = {
        {-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-5, 0}, {5, 0}, {0, -5}, {0, 5}};
    for (const auto& offset : kOffsets) {
      TryNeighbor(offset[0], offset[1]);
    }
    // Depth, slope, and both, at a scale that halves from sweep to sweep.
    const float scale = std::ldexp(
        static_cast<float>(sweep_.options->perturbation), -sweep_.iteration);
    for (int kind = 0; kind < 3; ++kind) {
      HWY_ALIGN float noise[3][16] = {};
      for (int i = 0; i < num_pixels_; ++i) {
        Random random(Index(i), sweep_.iteration, kind);
        for (auto& values : noise) {
          values[i] = 2 * random.NextFloat() - 1;
        }
      }
      Planes planes = best_;
      if (kind != 1) {
        planes.rho = hn::MulAdd(hn::Mul(best_.rho, hn::Set(d, scale)),
                                hn::Load(d, noise[0]),
                                planes.rho);
      }
      if (kind != 0) {
        // Over a window's radius, a slope moves the depth as much again.
        const V slope_scale = hn::Mul(
            best_.rho, hn::Set(d, 2 * scale / sweep_.options->window_radius));
        planes.rho_x =
            hn::MulAdd(slope_scale, hn::Load(d, noise[1]), planes.rho_x);
        planes.rho_y =
            hn::MulAdd(slope_scale, hn::Load(d, noise[2]), planes.rho_y);
      }
      Try(planes, hn::Eq(x_, x_));
    }
    Keep(best_, best_cost_, hn::Eq(x_, x_));
  }

 private:
  size_t Index(const int i) const {
    return static_cast<size_t>(row_) * sweep_.maps->width + cols_[i];
  }

  V LoadFrom(const float* values) const {
    HWY_ALIGN float lanes[16];
    std::fill(lanes, lanes + 16, 1.0f);
    for (int i = 0; i < num_pixels_; ++i) {
      lanes[i] = values[Index(i)];
    }
    return hn::Load(D(), lanes);
  }

  Planes Load() const {
    return {LoadFrom(sweep_.maps->rho.data()),
            LoadFrom(sweep_.maps->rho_x.data()),
            LoadFrom(sweep_.maps->rho_y.data())};
  }

  void Keep(const Planes& planes, const V cost, const M improved) const {
    const D d;
    HWY_ALIGN float values[4][16];
    HWY_ALIGN float is_improved[16];
    hn::Store(planes.rho, d, values[0]);
    hn::Store(planes.rho_x, d, values[1]);
    hn::Store(planes.rho_y, d, values[2]);
    hn::Store(cost, d, values[3]);
    hn::Store(hn::IfThenElseZero(improved, hn::Set(d, 1.0f)), d, is_improved);
    float* const targets[4] = {sweep_.maps->rho.data(),
                               sweep_.maps->rho_x.data(),
                               sweep_.maps->rho_y.data(),
                               sweep_.maps->cost.data()};
    for (int i = 0; i < num_pixels_; ++i) {
      if (is_improved[i] > 0) {
        for (int k = 0; k < 4; ++k) {
          targets[k][Index(i)] = values[k][i];
        }
      }
    }
  }

  PixelWarp Warp(const VI slot) const {
    return MakePixelWarp(GatherWarps(sweep_.warps, slot), x_, y_);
  }

  V Cost(const Planes& planes) {
    V costs[kMaxSourceSlots];
    for (int k = 0; k < sweep_.num_used_slots; ++k) {
      costs[k] = SourceCost(sweep_.grays, warps_[k], window_, planes);
    }
    return MeanOfBest(
        costs, sweep_.num_used_slots, sweep_.options->num_best_sources);
  }

  void Try(const Planes& planes, M allowed) {
    const D d;
    // Planes behind the camera, or far outside of what the seed leaves open.
    allowed = hn::And(allowed,
                      hn::Gt(planes.rho, hn::Mul(seed_rho_, hn::Set(d, 0.2f))));
    if (hn::AllFalse(d, allowed)) {
      return;
    }
    const V cost = Cost(planes);
    // What does not match at all is as good as what has no texture: no reason
    // to leave the seed for another plane that does not match, either.
    const M is_seen = hn::Lt(best_cost_, hn::Set(d, kWorstCost));
    const M better =
        hn::And(hn::And(allowed, is_seen),
                hn::Lt(cost, hn::Min(best_cost_, hn::Set(d, 1.0f))));
    best_.rho = hn::IfThenElse(better, planes.rho, best_.rho);
    best_.rho_x = hn::IfThenElse(better, planes.rho_x, best_.rho_x);
    best_.rho_y = hn::IfThenElse(better, planes.rho_y, best_.rho_y);
    best_cost_ = hn::IfThenElse(better, cost, best_cost_);
  }

  void TryNeighbor(const int dx, const int dy) {
    const D d;
    const PlaneMaps& maps = *sweep_.maps;
    const int row = row_ + dy;
    if (row < 0 || row >= maps.height) {
      return;
    }
    HWY_ALIGN float values[3][16] = {};
    HWY_ALIGN float exists[16] = {};
    for (int i = 0; i < num_pixels_; ++i) {
      const int col = cols_[i] + dx;
      if (col >= 0 && col < maps.width) {
        const size_t index = static_cast<size_t>(row) * maps.width + col;
        values[0][i] =
            maps.rho[index] - dx * maps.rho_x[index] - dy * maps.rho_y[index];
        values[1][i] = maps.rho_x[index];
        values[2][i] = maps.rho_y[index];
        exists[i] = 1;
      }
    }
    Try({hn::Load(d, values[0]),
         hn::Load(d, values[1]),
         hn::Load(d, values[2])},
        hn::Gt(hn::Load(d, exists), hn::Zero(d)));
  }

  const PatchMatchSweep& sweep_;
  const int row_;
  const int num_pixels_;
  int cols_[16];
  V x_;
  V y_;
  V seed_rho_;
  Window window_;
  PixelWarp warps_[kMaxSourceSlots];  // of the sources that are used
  Planes best_;
  V best_cost_;
};

void SweepRow(const PatchMatchSweep& sweep, const int row) {
  const int lanes = static_cast<int>(hn::Lanes(D()));
  const int width = sweep.maps->width;
  for (int col = (row + sweep.color) % 2; col < width; col += 2 * lanes) {
    const int num_pixels = std::min(lanes, (width - col + 1) / 2);
    PixelBlock block(sweep, row, col, num_pixels);
    if (sweep.iteration < 0) {
      block.ChooseSources();
      block.LoadSources();
      block.EvaluateCurrent();
    } else if (sweep.iteration < sweep.options->num_iterations) {
      block.LoadSources();
      block.Improve();
    } else {
      block.LoadSources();
      block.MeasureDistinctness();
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace structnerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace structnerf {

HWY_EXPORT(SweepRow);

PatchMatch::PatchMatch(const Scene& scene,
                       const SceneFrame& frame,
                       const TrainingViews& views,
                       const std::vector<std::vector<int>>& sources,
                       const StereoOptions& options)
    : views_(views),
      options_(options),
      source_warps_(MakeSourceWarps(scene, frame, views, sources)) {}

void PatchMatch::Refine(const int view_idx,
                        ThreadPool* pool,
                        Progress* progress,
                        PlaneMaps* maps) const {
  const size_t num_pixels = static_cast<size_t>(maps->width) * maps->height;
  maps->cost.assign(num_pixels, 2.0f);
  maps->distinctness.assign(num_pixels, 0.0f);
  const int num_slots = source_warps_.num_slots;
  if (num_slots == 0) {
    return;
  }
  const std::vector<float> seed_rho = maps->rho;
  PatchMatchSweep sweep;
  sweep.warps =
      source_warps_.warps.data() + static_cast<size_t>(view_idx) * num_slots;
  sweep.num_slots = num_slots;
  sweep.grays = views_.Grays();
  sweep.first_pixel = views_.image(view_idx).first_pixel;
  sweep.options = &options_;
  sweep.seed_rho = seed_rho.data();
  sweep.maps = maps;
  sweep.num_used_slots = std::min(num_slots, options_.num_used_sources);
  std::vector<int32_t> best_slots(num_pixels * sweep.num_used_slots);
  sweep.best_slots = best_slots.data();
  for (int iteration = -1; iteration <= options_.num_iterations; ++iteration) {
    sweep.iteration = iteration;
    for (sweep.color = 0; sweep.color < 2; ++sweep.color) {
      for (int begin = 0; begin < maps->height; begin += kRowsPerBatch) {
        PauseOrAbort(progress);
        pool->ParallelFor(std::min(kRowsPerBatch, maps->height - begin),
                          [&](const size_t row, int) {
                            HWY_DYNAMIC_DISPATCH(SweepRow)
                            (sweep, begin + static_cast<int>(row));
                          });
      }
    }
  }
}

}  // namespace structnerf
#endif  // HWY_ONCE
