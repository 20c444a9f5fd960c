#pragma once

#include "nerf/util/state_stream.h"

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// Coarse picture of the field's density over the scene box, one byte per cell.
// Rays read it to find where to sample. Blocks of 4 x 4 x 4 cells share a cache
// line, so that a ray has several cells of its way in each line it reads.
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

  // Cells per axis.
  const int* Dimensions() const { return dimensions_; }

  // Bytes of the cells, CellIndex() tells where. Padding makes a four-byte read
  // at any cell valid.
  const uint8_t* Data() const { return cells_.data(); }

  // Index of a cell into Data(): 64 times the number of its block, x fastest,
  // plus its number in the block, x fastest.
  size_t CellIndex(int x, int y, int z) const {
    return 64 * (static_cast<size_t>(x >> 2) +
                 static_cast<size_t>(y >> 2) * BlockStrides()[0] +
                 static_cast<size_t>(z >> 2) * BlockStrides()[1]) +
           ((z & 3) << 4 | (y & 3) << 2 | (x & 3));
  }

  // Blocks between neighbours in y and in z.
  const int* BlockStrides() const { return block_strides_; }

  // Forgets everything, the order of visits included: no light ends anywhere.
  void Clear();

  // The cells want to know their density in turn: every one comes up once in
  // NumCells() visits, neighbours far apart. Claims the next `count` visits and
  // returns the number of the first.
  size_t NextVisits(size_t count);

  // Writes the points, in field coordinates, at which these visits want the
  // density: a place in the cell that changes from round to round.
  void VisitPoints(
      size_t first_visit, size_t count, float* x, float* y, float* z) const;

  // Gives the answers, see Observe. Visits of one round may be answered by
  // several threads at a time.
  void Update(size_t first_visit,
              const float* log_density,
              size_t count,
              float decay);

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

  // All that changes. LoadState throws std::runtime_error if the state is that
  // of another number of cells.
  void SaveState(StateWriter* writer) const;
  void LoadState(StateReader* reader);

 private:
  // Calls visit(i, x, y, z) with the i-th visit's cell, i < count.
  template <typename Visit>
  void ForEachVisitedCell(size_t first_visit,
                          size_t count,
                          const Visit& visit) const;
  void ObserveCell(size_t index, float log_density, float decay);

  float cells_per_unit_;
  int dimensions_[3];
  int block_strides_[2];
  size_t num_cells_;
  size_t stride_;  // between cells that are visited one after the other
  size_t next_visit_ = 0;
  std::vector<uint8_t> cells_;
};

}  // namespace structnerf
