#include "tests/benchmarks/roofline_model.h"

#include "nerf/kernels/adam.h"

namespace structnerf {
namespace {

constexpr double kEntryBytes = kGridFeatures * 2;
constexpr double kLineBytes = 64;

// Lines that the eight corners of a cell lie in.
constexpr double kLinesPerLevel = 4 * (1 + kEntryBytes / kLineBytes);

// Cycles for index and interpolation at one level, forward and backward: 300
// for 16 levels of two features, and these have four times as many.
constexpr double kCyclesPerLevel = 300.0 / 16 * 2;

// Bytes moved for an entry: its state is read and written, its copy written.
constexpr double kAdamBytes = 2 * sizeof(GridEntryState) + kEntryBytes;

double Flops(const double num_inputs, const double num_outputs) {
  return 3 * 2 * num_inputs * num_outputs;
}

}  // namespace

double NetworkFlops(const FieldLayout& layout, const double color_share) {
  constexpr double kNumChannels = 3;
  return Flops(layout.encoding_width, layout.hidden_width) +
         Flops(layout.hidden_width, kGeometryWidth) +
         color_share * (Flops(kGeometryWidth, layout.hidden_width) +
                        Flops(layout.hidden_width, kNumChannels));
}

double TableBytes(const FieldLayout& layout) {
  return kEntryBytes * static_cast<double>(layout.num_grid_entries);
}

double SecondsPerSample(const FieldLayout& layout,
                        const MachineRates& rates,
                        const StepWork& work,
                        const double network_efficiency) {
  const double num_levels = static_cast<double>(layout.levels.size());
  const double network = NetworkFlops(layout, work.color_share) /
                         (network_efficiency * rates.flops);
  const double grid = 2 * num_levels * kLinesPerLevel / rates.table_lines +
                      num_levels * kCyclesPerLevel / rates.clock;
  const double adam = kAdamBytes * work.num_touched_entries /
                      (rates.bandwidth * work.num_samples);
  return network + grid + adam;
}

}  // namespace structnerf
