#include "colmap_plugin/depth_map_cache.h"

#include "colmap_plugin/dense_workspace.h"
#include "tests/support/temp_dir.h"

#include <filesystem>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

constexpr int kNumPixels = 6;
constexpr size_t kMapBytes = 4 * kNumPixels * sizeof(float);

class DepthMapCacheTest : public testing::Test {
 protected:
  DepthMapCacheTest()
      : workspace_(temp_dir_ / "dense"),
        names_({"0.png", "1.png", "2.png", "3.png"}) {
    workspace_.CreateFolders(names_);
  }

  DepthMapCache MakeCache(const size_t max_bytes) {
    return DepthMapCache(
        [this](const size_t view_idx) {
          return workspace_.ReadInterimMaps(names_[view_idx],
                                            InterimStage::kCompleted);
        },
        names_.size(),
        max_bytes);
  }

  void Fill(DepthMapCache* cache) {
    for (size_t i = 0; i < names_.size(); ++i) {
      DenseMaps maps;
      maps.width = 3;
      maps.height = 2;
      maps.depth.assign(kNumPixels, 1 + i);
      maps.normal.assign(3 * kNumPixels, -1.0f * i);
      workspace_.WriteInterimMaps(names_[i], InterimStage::kCompleted, maps);
      cache->Insert(i, maps);
    }
  }

  void ExpectMap(const DenseMaps& maps, int view_idx) {
    ASSERT_EQ(maps.width, 3);
    ASSERT_EQ(maps.height, 2);
    EXPECT_EQ(maps.depth, std::vector<float>(kNumPixels, 1 + view_idx));
    EXPECT_EQ(maps.normal,
              std::vector<float>(3 * kNumPixels, -1.0f * view_idx));
  }

  TempDir temp_dir_;
  DenseWorkspace workspace_;
  const std::vector<std::string> names_;
};

TEST_F(DepthMapCacheTest, WithEnoughMemoryNothingIsReadBack) {
  DepthMapCache cache = MakeCache(4 * kMapBytes);
  Fill(&cache);
  std::filesystem::remove_all(temp_dir_ / "dense");
  const auto& maps = cache.Require({2, 0, 1, 3});
  for (int i = 0; i < 4; ++i) {
    ExpectMap(maps[i], i);
  }
}

TEST_F(DepthMapCacheTest, HoldsNoMoreThanAllowed) {
  DepthMapCache cache = MakeCache(2 * kMapBytes);
  Fill(&cache);
  for (const std::vector<int>& required :
       {std::vector<int>{0, 1}, {1, 2}, {3, 0}, {0, 3}}) {
    const auto& maps = cache.Require(required);
    size_t num_present = 0;
    for (const DenseMaps& map : maps) {
      num_present += !map.depth.empty();
    }
    EXPECT_EQ(num_present, 2);
    for (const int view_idx : required) {
      ExpectMap(maps[view_idx], view_idx);
    }
  }
}

TEST_F(DepthMapCacheTest, OneRequestMayNeedMore) {
  DepthMapCache cache = MakeCache(1);
  Fill(&cache);
  const auto& maps = cache.Require({0, 1, 2});
  for (int i = 0; i < 3; ++i) {
    ExpectMap(maps[i], i);
  }
  ExpectMap(cache.Require({3})[3], 3);
}

}  // namespace
}  // namespace structnerf
