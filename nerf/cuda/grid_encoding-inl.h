#pragma once

#include "nerf/cuda/host_device.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace structnerf {

// The hash grid of nerf/kernels/grid_encoding.h, one call per point and level.

constexpr uint32_t kDeviceFeatures = 8;  // kGridFeatures
constexpr uint32_t kMaxDeviceLevels = 16;

// GridLevel as plain data.
struct DeviceGridLevel {
  float cells_per_unit;
  uint32_t vertices[3];
  bool is_hashed;
  uint32_t num_entries;
  size_t first_entry;
  float weight;  // factor on the features
};

struct DeviceGrid {
  DeviceGridLevel levels[kMaxDeviceLevels];
  uint32_t num_levels;
};

struct DevicePoints {
  const float* x;  // field coordinates
  const float* y;
  const float* z;
};

// The eight corners around a point: entries from the level's first, and
// trilinear weights. Bits 0, 1, 2 of a corner tell the side in x, y and z.
struct GridCell {
  uint32_t entries[8];
  float weights[8];

  STRUCTNERF_HOST_DEVICE GridCell(const DeviceGridLevel& level,
                                  const DevicePoints& points,
                                  const size_t point) {
    const float coordinates[3] = {
        points.x[point], points.y[point], points.z[point]};
    uint32_t cell[3];
    float share[3];
    for (int axis = 0; axis < 3; ++axis) {
      const float last_cell = static_cast<float>(level.vertices[axis] - 2);
      float position = coordinates[axis] * level.cells_per_unit;
      // In this order, NaN becomes zero.
      position = position > 0 ? position : 0.0f;
      position = position < last_cell ? position : last_cell;
      cell[axis] = static_cast<uint32_t>(position);
      share[axis] = position - static_cast<float>(cell[axis]);
    }
    // Spatial hash of Teschner et al. 2003.
    const uint32_t factor_y = level.is_hashed ? 2654435761u : level.vertices[0];
    const uint32_t factor_z =
        level.is_hashed ? 805459861u : level.vertices[0] * level.vertices[1];
    for (uint32_t corner = 0; corner < 8; ++corner) {
      const uint32_t x = cell[0] + (corner & 1);
      const uint32_t y = (cell[1] + ((corner >> 1) & 1)) * factor_y;
      const uint32_t z = (cell[2] + (corner >> 2)) * factor_z;
      entries[corner] =
          level.is_hashed ? (x ^ y ^ z) & (level.num_entries - 1) : x + y + z;
      weights[corner] = ((corner & 1) != 0 ? share[0] : 1 - share[0]) *
                        ((corner & 2) != 0 ? share[1] : 1 - share[1]) *
                        ((corner & 4) != 0 ? share[2] : 1 - share[2]);
    }
  }
};

// Call point * num_levels + level writes the level's features of the point.
struct GridEncodeKernel {
  DeviceGrid grid;
  DevicePoints points;
  const float* table;  // entries x kDeviceFeatures
  uint32_t encoding_width;
  float* encoding;  // points x encoding_width

  STRUCTNERF_HOST_DEVICE void operator()(const size_t i) const {
    const size_t point = i / grid.num_levels;
    const uint32_t level_idx = static_cast<uint32_t>(i % grid.num_levels);
    const DeviceGridLevel& level = grid.levels[level_idx];
    const GridCell cell(level, points, point);
    float sums[kDeviceFeatures] = {};
    for (int corner = 0; corner < 8; ++corner) {
      const float* const features =
          table + (level.first_entry + cell.entries[corner]) * kDeviceFeatures;
      for (uint32_t f = 0; f < kDeviceFeatures; ++f) {
        sums[f] += cell.weights[corner] * features[f];
      }
    }
    float* const to =
        encoding + point * encoding_width + level_idx * kDeviceFeatures;
    for (uint32_t f = 0; f < kDeviceFeatures; ++f) {
      to[f] = level.weight * sums[f];
    }
  }
};

// Call i writes the largest number, by its absolute value, of the gradient of
// point i, and makes the largest of all points of its tile no less.
struct LargestGradientKernel {
  const float* d_encoding;  // points x encoding_width
  uint32_t encoding_width;
  uint32_t tile_points;
  float* largest;          // points
  float* largest_of_tile;  // zero before

  STRUCTNERF_HOST_DEVICE void operator()(const size_t i) const {
    float value = 0;
    for (uint32_t f = 0; f < encoding_width; ++f) {
      const float magnitude = fabsf(d_encoding[i * encoding_width + f]);
      value = magnitude > value ? magnitude : value;  // never NaN
    }
    largest[i] = value;
    AtomicMax(value, largest_of_tile + i / tile_points);
  }
};

// Adds to the gradient of the table what call point * num_levels + level has
// for it. Points whose gradient is not larger than a share of the largest of
// their tile add nothing.
struct GridBackwardKernel {
  DeviceGrid grid;
  DevicePoints points;
  const float* d_encoding;  // points x encoding_width
  uint32_t encoding_width;
  const float* largest;  // see LargestGradientKernel
  const float* largest_of_tile;
  uint32_t tile_points;
  float negligible_share;
  float* gradient;  // entries x kDeviceFeatures

  STRUCTNERF_HOST_DEVICE void operator()(const size_t i) const {
    const size_t point = i / grid.num_levels;
    if (!(largest[point] >
          negligible_share * largest_of_tile[point / tile_points])) {
      return;
    }
    const uint32_t level_idx = static_cast<uint32_t>(i % grid.num_levels);
    const DeviceGridLevel& level = grid.levels[level_idx];
    // `gradient` might be the same memory for all that the compiler knows.
    float d_features[kDeviceFeatures];
    for (uint32_t f = 0; f < kDeviceFeatures; ++f) {
      d_features[f] =
          d_encoding[point * encoding_width + level_idx * kDeviceFeatures + f];
    }
    const GridCell cell(level, points, point);
    for (int corner = 0; corner < 8; ++corner) {
      float* const to = gradient + (level.first_entry + cell.entries[corner]) *
                                       kDeviceFeatures;
      const float factor = level.weight * cell.weights[corner];
      if (factor == 0) {
        continue;
      }
      for (uint32_t f = 0; f < kDeviceFeatures; ++f) {
        AtomicAdd(factor * d_features[f], to + f);
      }
    }
  }
};

}  // namespace structnerf
