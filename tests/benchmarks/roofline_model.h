#pragma once

#include "nerf/field/field_layout.h"

namespace structnerf {

// What RooflineProbe measured, per thread.
struct MachineRates {
  double clock = 0;        // cycles per second
  double flops = 0;        // multiply-adds in registers
  double table_lines = 0;  // random lines of a buffer of the table's size
  double bandwidth = 0;    // bytes per second
};

// Work of one training step.
struct StepWork {
  double num_samples = 0;
  double color_share = 1;          // of the samples that have a colour
  double num_touched_entries = 0;  // of the grid
};

// Operations of the networks' matrix products per sample, forward and backward
// (by weights and by inputs): 2 per multiply-add, 3 products per layer. What is
// done per ray is left out.
double NetworkFlops(const FieldLayout& layout, double color_share);

// Bytes of the half-precision tables that rays read.
double TableBytes(const FieldLayout& layout);

// Least processor time per sample of a training step if nothing overlaps:
//   t_network = NetworkFlops / (efficiency * flops)
//   t_grid    = 2 L lines / table_lines + I / clock
//   t_adam    = bytes per entry * touched entries / (bandwidth * samples)
// for L levels. Eight corners are four pairs of neighbours, a pair lies in one
// line but for the last entry of a line: four entries per line make 5 lines.
// I is what vectorised index and interpolation arithmetic takes.
double SecondsPerSample(const FieldLayout& layout,
                        const MachineRates& rates,
                        const StepWork& work,
                        double network_efficiency);

}  // namespace structnerf
