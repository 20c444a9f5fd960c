#include "nerf/util/aligned_buffer.h"

#include <cstdint>
#include <utility>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(AlignedBuffer, AlignedAndZero) {
  for (const size_t size : {1u, 15u, 16u, 17u, 100000u, 3000000u}) {
    const AlignedBuffer<float> buffer(size);
    ASSERT_EQ(buffer.size(), size);
    EXPECT_EQ(reinterpret_cast<uintptr_t>(buffer.data()) % 64, 0u);
    for (size_t i = 0; i < size; ++i) {
      ASSERT_EQ(buffer[i], 0.0f);
    }
  }
}

TEST(AlignedBuffer, Empty) {
  AlignedBuffer<int> buffer;
  EXPECT_EQ(buffer.size(), 0u);
  buffer.Allocate(0);
  EXPECT_EQ(buffer.size(), 0u);
  EXPECT_NE(buffer.data(), nullptr);
}

TEST(AlignedBuffer, AllocateAgainIsZeroAgain) {
  AlignedBuffer<int> buffer(100);
  buffer[7] = 3;
  buffer.Allocate(200);
  ASSERT_EQ(buffer.size(), 200u);
  EXPECT_EQ(buffer[7], 0);
}

TEST(AlignedBuffer, Moves) {
  AlignedBuffer<int> buffer(10);
  buffer[3] = 5;
  const AlignedBuffer<int> moved = std::move(buffer);
  EXPECT_EQ(moved.size(), 10u);
  EXPECT_EQ(moved[3], 5);
}

}  // namespace
}  // namespace structnerf
