#include "nerf/field/field_layout.h"

#include <gtest/gtest.h>

namespace structnerf {
namespace {

FieldLayout MakeLayout(const int num_levels) {
  FieldOptions options;
  options.num_levels = num_levels;
  options.min_resolution = 16;
  options.max_resolution = 128;
  return FieldLayout(options, Eigen::Vector3f(1, 0.5f, 0.25f));
}

TEST(FieldLayout, LevelsGrowInEqualRatiosToTheFinest) {
  const FieldLayout layout = MakeLayout(4);
  ASSERT_EQ(layout.levels.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    EXPECT_FLOAT_EQ(layout.levels[i].cells_per_unit, 16.0f * (1 << i));
  }
  EXPECT_EQ(layout.levels[0].vertices[0], 18u);
  EXPECT_EQ(layout.levels[0].vertices[1], 10u);
  EXPECT_EQ(layout.levels[0].vertices[2], 6u);
}

TEST(FieldLayout, ASingleLevelIsTheFinest) {
  const FieldLayout layout = MakeLayout(1);
  ASSERT_EQ(layout.levels.size(), 1u);
  EXPECT_FLOAT_EQ(layout.levels[0].cells_per_unit, 128);
}

TEST(FieldLayout, LevelsOfMoreVerticesThanEntriesAreHashed) {
  FieldOptions options;
  options.log2_table_size = 12;
  const FieldLayout layout(options, Eigen::Vector3f::Ones());
  EXPECT_TRUE(layout.levels.front().hashed);  // 18^3 vertices
  EXPECT_EQ(layout.levels.front().num_entries, 1u << 12);
}

}  // namespace
}  // namespace structnerf
