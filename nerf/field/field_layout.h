#pragma once

#include "nerf/options.h"

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// Features per grid entry. Eight floats are one AVX register; four levels of
// eight cost half the cache lines of eight levels of four for the same input
// width.
constexpr int kGridFeatures = 8;

// Outputs of the density network: the first is the raw log density, all of them
// are inputs of the colour network.
constexpr int kGeometryWidth = 16;

// Spherical harmonics of the viewing direction are padded with zeros; up to
// degree 2 there are 9.
constexpr int kDirectionWidth = 16;
constexpr int kMaxNumHarmonics = 9;

constexpr int kColorInputWidth = kGeometryWidth + kDirectionWidth;

// Width of the colour network's output; the first three are red, green, blue.
constexpr int kColorOutputWidth = 16;

// One level of the multi-resolution grid. Vertex (x, y, z) lies at
// (x, y, z) / cells_per_unit in field coordinates.
struct GridLevel {
  float cells_per_unit = 0;
  uint32_t vertices[3] = {0, 0, 0};  // per axis
  bool hashed = false;               // else dense, x fastest
  uint32_t num_entries = 0;          // a power of two if hashed
  size_t first_entry = 0;            // into the table of all levels
};

// A fully connected layer y = x W + b.
struct LayerLayout {
  int num_inputs = 0;
  int num_outputs = 0;
  size_t weights = 0;  // offset of W, num_inputs x num_outputs, row-major
  size_t biases = 0;   // offset of b, num_outputs
};

// A layer whose parameters follow `*num_parameters` others, to which they are
// added.
LayerLayout AddLayer(int num_inputs, int num_outputs, size_t* num_parameters);

// Shapes of the field's parameters: a hash grid (Mueller et al. 2022), a
// density network encoding -> hidden -> geometry, a colour network geometry +
// direction -> hidden -> colour. Hidden layers are rectified.
struct FieldLayout {
  // `extent`: size of the scene box in field coordinates, largest side 1.
  FieldLayout(const FieldOptions& options, const Eigen::Vector3f& extent);

  std::vector<GridLevel> levels;
  size_t num_grid_entries = 0;  // each of kGridFeatures numbers

  // Width of the encoding: kGridFeatures per level, zero-padded to a multiple
  // of 16.
  int encoding_width = 0;
  int hidden_width = 0;

  // Numbers of the direction's encoding that are not padding.
  int num_harmonics = 0;

  LayerLayout density_hidden;
  LayerLayout density_output;
  LayerLayout color_hidden;
  LayerLayout color_output;
  size_t num_network_parameters = 0;

  size_t NumParameters() const;
};

// Parameters in full precision, as initialised, checkpointed and exchanged.
struct FieldParameters {
  std::vector<float> grid;     // num_grid_entries * kGridFeatures
  std::vector<float> network;  // num_network_parameters
};

// Small uniform grid features, He-initialised weights, zero biases: the density
// starts near `initial_density` everywhere.
FieldParameters InitialParameters(const FieldLayout& layout,
                                  float initial_density,
                                  uint64_t seed);

}  // namespace structnerf
