#include "nerf/field/density_cache.h"

#include "nerf/util/random.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace structnerf {
DensityCache::DensityCache(const int resolution,
                           const Eigen::Vector3f& extent,
                           const float initial_density)
    : cells_per_unit_(static_cast<float>(resolution)), num_cells_(1) {
  for (int axis = 0; axis < 3; ++axis) {
    dimensions_[axis] =
        std::max(1, static_cast<int>(std::ceil(extent[axis] * resolution)));
    num_cells_ *= dimensions_[axis];
  }
  cells_.assign(num_cells_ + 3, 0);
  for (size_t cell = 0; cell < num_cells_; ++cell) {
    ObserveCell(cell, std::log(initial_density), 0.0f);
  }
  // Near the golden section, consecutive visits spread evenly; a stride coprime
  // to the number of cells visits each once.
  stride_ = static_cast<size_t>(0.6180339887 * num_cells_) | 1;
  while (std::gcd(stride_, num_cells_) != 1) {
    stride_ += 2;
  }
}

void DensityCache::Clear() {
  std::fill(cells_.begin(), cells_.end(), uint8_t{0});
  first_visit_ = 0;
  next_visit_ = 0;
}

void DensityCache::NextPoints(const size_t count,
                              float* x,
                              float* y,
                              float* z) {
  first_visit_ = next_visit_;
  next_visit_ += count;
  for (size_t i = 0; i < count; ++i) {
    const size_t visit = first_visit_ + i;
    const size_t cell = visit % num_cells_ * stride_ % num_cells_;
    Random random(cell, visit / num_cells_);
    const size_t row = cell / dimensions_[0];
    const float inverse = 1.0f / cells_per_unit_;
    x[i] = (cell % dimensions_[0] + random.NextFloat()) * inverse;
    y[i] = (row % dimensions_[1] + random.NextFloat()) * inverse;
    z[i] = (row / dimensions_[1] + random.NextFloat()) * inverse;
  }
}

void DensityCache::Update(const float* log_density,
                          const size_t count,
                          const float decay) {
  for (size_t i = 0; i < count; ++i) {
    ObserveCell((first_visit_ + i) % num_cells_ * stride_ % num_cells_,
                log_density[i],
                decay);
  }
}

void DensityCache::Observe(const float* x,
                           const float* y,
                           const float* z,
                           const float* log_density,
                           const size_t count,
                           const float decay) {
  const auto index = [&](const float position, const int axis) {
    return std::min(std::max(static_cast<int>(position * cells_per_unit_), 0),
                    dimensions_[axis] - 1);
  };
  for (size_t i = 0; i < count; ++i) {
    ObserveCell(index(x[i], 0) +
                    static_cast<size_t>(dimensions_[0]) *
                        (index(y[i], 1) +
                         static_cast<size_t>(dimensions_[1]) * index(z[i], 2)),
                log_density[i],
                decay);
  }
}

void DensityCache::ObserveCell(const size_t cell,
                               const float log_density,
                               const float decay) {
  const float level = std::min(
      std::max((log_density - kMinLogDensity) * kLevelsPerUnit, 0.0f), 255.0f);
  const float old_level = cells_[cell];
  // Rounded towards the new level, or a small difference would never close.
  cells_[cell] = static_cast<uint8_t>(
      level > old_level ? std::ceil(level)
                        : std::floor(level + decay * (old_level - level)));
}

}  // namespace structnerf
