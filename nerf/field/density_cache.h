#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// Coarse picture of the field's density over the scene box, one byte per cell,
// small enough for the second-level cache. Rays read it to find where to
// sample.
//
// A byte b stands for the density exp(b / kLevelsPerUnit + kMinLogDensity).
class DensityCache {
 public:
  static constexpr float kMinLogDensity = -4.0f;
  static constexpr float kLevelsPerUnit = 16.0f;

  // Most cells that are evaluated per refresh.
  static constexpr size_t kRefreshCells = size_t{1} << 16;

  // `resolution`: cells along the longest side of the box (side 1 in field
  // coordinates).
  DensityCache(int resolution,
               const Eigen::Vector3f& extent,
               float initial_density);

  size_t NumCells() const { return num_cells_; }
  float CellsPerUnit() const { return cells_per_unit_; }
  const int* Dimensions() const { return dimensions_; }

  // Cells in x-fastest order, followed by padding that makes a four-byte read
  // at any cell valid.
  const uint8_t* Data() const { return cells_.data(); }

  // Forgets everything, the order of visits included: no light ends anywhere.
  void Clear();

  // Writes the points, in field coordinates, at which the next `count` cells
  // want to know the density: every cell comes up once in NumCells() points,
  // neighbours far apart, at a place in the cell that changes from round to
  // round.
  void NextPoints(size_t count, float* x, float* y, float* z);

  // Gives the answers, see Observe.
  void Update(const float* log_density, size_t count, float decay);

  // Tells the cache the density at some points. A cell takes on a density that
  // is larger than what it holds; towards a smaller one it moves by a share of
  // 1 - decay of the way in log density, so that a thin surface that most
  // points of the cell miss is not forgotten, but fog that has cleared is.
  void Observe(const float* x,
               const float* y,
               const float* z,
               const float* log_density,
               size_t count,
               float decay);

 private:
  void ObserveCell(size_t cell, float log_density, float decay);

  float cells_per_unit_;
  int dimensions_[3];
  size_t num_cells_;
  size_t stride_;  // between cells that are visited one after the other
  size_t first_visit_ = 0;  // number of the first visit NextPoints last gave
  size_t next_visit_ = 0;
  std::vector<uint8_t> cells_;
};

}  // namespace structnerf
