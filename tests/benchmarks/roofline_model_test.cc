#include "tests/benchmarks/roofline_model.h"

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// Two levels of 16 and 32 cells, all dense.
FieldLayout SmallLayout() {
  FieldOptions options;
  options.num_levels = 2;
  options.min_resolution = 16;
  options.max_resolution = 32;
  options.log2_table_size = 20;
  options.hidden_width = 64;
  return FieldLayout(options, Eigen::Vector3f::Ones());
}

TEST(RooflineModel, CountsOperations) {
  const double density = 6 * (16 * 64 + 64 * 16);
  const double color = 6 * (16 * 64 + 64 * 3);
  EXPECT_DOUBLE_EQ(NetworkFlops(SmallLayout(), 0), density);
  EXPECT_DOUBLE_EQ(NetworkFlops(SmallLayout(), 0.25), density + color / 4);
}

TEST(RooflineModel, CountsTableBytes) {
  const FieldLayout layout = SmallLayout();
  EXPECT_DOUBLE_EQ(TableBytes(layout), 16.0 * layout.num_grid_entries);
}

TEST(RooflineModel, AddsUpWhatDoesNotOverlap) {
  const FieldLayout layout = SmallLayout();
  MachineRates rates;
  rates.clock = 3e9;
  rates.flops = 100e9;
  rates.table_lines = 200e6;
  rates.bandwidth = 10e9;
  StepWork work;
  work.num_samples = 1000;
  work.color_share = 0.5;
  work.num_touched_entries = 3000;
  const double network = NetworkFlops(layout, 0.5) / (0.5 * 100e9);
  const double grid = 2 * 2 * 5 / 200e6 + 2 * 37.5 / 3e9;
  const double adam = (64 + 64 + 16) * 3000 / (10e9 * 1000);
  EXPECT_NEAR(
      SecondsPerSample(layout, rates, work, 0.5), network + grid + adam, 1e-15);
}

}  // namespace
}  // namespace structnerf
