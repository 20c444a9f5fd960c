#include "nerf/field/density_cache.h"

#include "nerf/util/random.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace structnerf {
namespace {

// The byte that stands for a density, not rounded yet. 0 for NaN.
float Level(const float log_density) {
  return std::min(255.0f,
                  std::max(0.0f,
                           (log_density - DensityCache::kMinLogDensity) *
                               DensityCache::kLevelsPerUnit));
}

}  // namespace

DensityCache::DensityCache(const int resolution,
                           const Eigen::Vector3f& extent,
                           const float initial_density)
    : cells_per_unit_(static_cast<float>(resolution)), num_cells_(1) {
  int num_blocks[3];
  for (int axis = 0; axis < 3; ++axis) {
    dimensions_[axis] =
        std::max(1, static_cast<int>(std::ceil(extent[axis] * resolution)));
    num_cells_ *= dimensions_[axis];
    num_blocks[axis] = (dimensions_[axis] + 3) / 4;
  }
  block_strides_[0] = num_blocks[0];
  block_strides_[1] = num_blocks[0] * num_blocks[1];
  cells_.assign(
      static_cast<size_t>(block_strides_[1]) * num_blocks[2] * 64 + 3,
      static_cast<uint8_t>(std::ceil(Level(std::log(initial_density)))));
  // Near the golden section, consecutive visits spread evenly; a stride coprime
  // to the number of cells visits each once.
  stride_ = static_cast<size_t>(0.6180339887 * num_cells_) | 1;
  while (std::gcd(stride_, num_cells_) != 1) {
    stride_ += 2;
  }
}

void DensityCache::Clear() {
  std::fill(cells_.begin(), cells_.end(), uint8_t{0});
  next_visit_ = 0;
}

size_t DensityCache::NextVisits(const size_t count) {
  const size_t first_visit = next_visit_;
  next_visit_ += count;
  return first_visit;
}

template <typename Visit>
void DensityCache::ForEachVisitedCell(const size_t first_visit,
                                      const size_t count,
                                      const Visit& visit) const {
  size_t cell = first_visit % num_cells_ * stride_ % num_cells_;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t row = static_cast<uint32_t>(cell) / dimensions_[0];
    visit(i,
          static_cast<int>(static_cast<uint32_t>(cell) % dimensions_[0]),
          static_cast<int>(row % dimensions_[1]),
          static_cast<int>(row / dimensions_[1]));
    cell += stride_;
    cell -= cell >= num_cells_ ? num_cells_ : 0;
  }
}

void DensityCache::VisitPoints(const size_t first_visit,
                               const size_t count,
                               float* x,
                               float* y,
                               float* z) const {
  const float inverse = 1.0f / cells_per_unit_;
  ForEachVisitedCell(first_visit,
                     count,
                     [&](const size_t i,
                         const int cell_x,
                         const int cell_y,
                         const int cell_z) {
                       Random random(first_visit + i);
                       x[i] = (cell_x + random.NextFloat()) * inverse;
                       y[i] = (cell_y + random.NextFloat()) * inverse;
                       z[i] = (cell_z + random.NextFloat()) * inverse;
                     });
}

void DensityCache::Update(const size_t first_visit,
                          const float* log_density,
                          const size_t count,
                          const float decay) {
  ForEachVisitedCell(
      first_visit,
      count,
      [&](const size_t i, const int x, const int y, const int z) {
        ObserveCell(CellIndex(x, y, z), log_density[i], decay);
      });
}

void DensityCache::Observe(const float* x,
                           const float* y,
                           const float* z,
                           const float* log_density,
                           const size_t count,
                           const float decay) {
  const auto coordinate = [&](const float position, const int axis) {
    // In this order, NaN becomes zero.
    return static_cast<int>(
        std::min(std::max(0.0f, position * cells_per_unit_),
                 static_cast<float>(dimensions_[axis] - 1)));
  };
  for (size_t i = 0; i < count; ++i) {
    ObserveCell(
        CellIndex(
            coordinate(x[i], 0), coordinate(y[i], 1), coordinate(z[i], 2)),
        log_density[i],
        decay);
  }
}

void DensityCache::SaveState(StateWriter* writer) const {
  writer->WriteValue(static_cast<uint64_t>(next_visit_));
  writer->WriteArray(cells_);
}

void DensityCache::LoadState(StateReader* reader) {
  const auto next_visit = reader->ReadValue<uint64_t>();
  auto cells = reader->ReadArray<std::vector<uint8_t>>();
  if (cells.size() != cells_.size()) {
    throw std::runtime_error("the state has a density cache of another size");
  }
  next_visit_ = static_cast<size_t>(next_visit);
  cells_ = std::move(cells);
}

void DensityCache::ObserveCell(const size_t index,
                               const float log_density,
                               const float decay) {
  const float level = Level(log_density);
  const float old_level = cells_[index];
  // Rounded towards the new level, or a small difference would never close.
  if (level > old_level) {
    const int floor = static_cast<int>(level);
    cells_[index] = static_cast<uint8_t>(floor + (floor < level));
  } else {
    cells_[index] = static_cast<uint8_t>(level + decay * (old_level - level));
  }
}

}  // namespace structnerf
