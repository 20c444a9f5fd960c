#include "nerf/util/random.h"

#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(Random, StreamsAreReproducibleAndDifferent) {
  std::set<uint32_t> first_numbers;
  for (const uint64_t seed : {0, 1, 2}) {
    for (const uint64_t stream : {0, 1, 2, 1000}) {
      for (const uint64_t substream : {0, 1, 2, 31}) {
        Random random(seed, stream, substream);
        Random same(seed, stream, substream);
        const uint32_t number = random.NextUint32();
        EXPECT_EQ(number, same.NextUint32());
        first_numbers.insert(number);
      }
    }
  }
  EXPECT_EQ(first_numbers.size(), 3u * 4 * 4);
}

TEST(Random, SwappedNamesAreOtherStreams) {
  EXPECT_NE(Random(1, 2, 3).NextUint32(), Random(3, 2, 1).NextUint32());
  EXPECT_NE(Random(1, 2, 3).NextUint32(), Random(1, 3, 2).NextUint32());
  EXPECT_NE(Random(~uint64_t{0}, 2, 3).NextUint32(),
            Random(0, 2, 3).NextUint32());
}

TEST(Random, FloatsAreUniformInTheUnitInterval) {
  // First numbers of consecutive streams, as tiles draw them, and consecutive
  // numbers of one stream.
  for (const bool one_stream : {false, true}) {
    Random random(5);
    std::vector<int> counts(10);
    double sum = 0;
    constexpr int kCount = 100000;
    for (int i = 0; i < kCount; ++i) {
      Random other(5, i);
      const float value = (one_stream ? random : other).NextFloat();
      ASSERT_GE(value, 0.0f);
      ASSERT_LT(value, 1.0f);
      ++counts[static_cast<int>(10 * value)];
      sum += value;
    }
    EXPECT_NEAR(sum / kCount, 0.5, 0.005);
    for (const int count : counts) {
      EXPECT_NEAR(count, kCount / 10, 500);
    }
  }
}

TEST(Random, NextBelowStaysBelowAndReachesAll) {
  Random random(6);
  for (const uint32_t bound : {1u, 2u, 3u, 10u}) {
    std::vector<int> counts(bound);
    for (int i = 0; i < 1000; ++i) {
      const uint32_t value = random.NextBelow(bound);
      ASSERT_LT(value, bound);
      ++counts[value];
    }
    for (const int count : counts) {
      EXPECT_GT(count, 0);
    }
  }
  double sum = 0;
  for (int i = 0; i < 10000; ++i) {
    sum += random.NextBelow(0xffffffffu);
  }
  EXPECT_NEAR(sum / 10000 / 4294967295.0, 0.5, 0.02);
}

}  // namespace
}  // namespace structnerf
