#include "nerf/planes/plane_completion.h"

#include "nerf/util/random.h"
#include "tests/nerf/planes/room_scene.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

struct Completed {
  std::vector<DenseMaps> maps;
  std::vector<size_t> num_pixels;
};

Completed Complete(const Room& room,
                   const int num_threads = 2,
                   const size_t num_added = 5,
                   const std::vector<int>& voter_idxs = {0, 1, 2, 3, 4}) {
  const TrainingViews views(room.scene, room.frame);
  PlaneCompletion completion(
      room.scene, room.frame, views, voter_idxs, room.sources, 5);
  ThreadPool pool(num_threads);
  Completed result;
  result.maps = room.maps;
  for (size_t v = 0; v < std::min(room.maps.size(), num_added); ++v) {
    completion.AddView(static_cast<int>(v), room.maps[v], &pool);
  }
  Progress progress;
  completion.FindPlanes(&pool, &progress);
  for (size_t v = 0; v < room.maps.size(); ++v) {
    result.num_pixels.push_back(
        completion.Complete(static_cast<int>(v), &pool, &result.maps[v]));
  }
  return result;
}

void ExpectUnchanged(const Completed& result, const Room& room) {
  for (size_t v = 0; v < room.maps.size(); ++v) {
    EXPECT_EQ(result.num_pixels[v], 0u) << v;
    EXPECT_EQ(result.maps[v].depth, room.maps[v].depth) << v;
    EXPECT_EQ(result.maps[v].normal, room.maps[v].normal) << v;
  }
}

class PlaneCompletionSizesTest
    : public testing::TestWithParam<std::tuple<int, int>> {};

TEST_P(PlaneCompletionSizesTest, BlankWallsAreMovedBackToWhereTheyAre) {
  const auto& [camera_width, image_width] = GetParam();
  const Room room = MakeRoom(camera_width, image_width);
  const Completed result = Complete(room);
  for (size_t v = 0; v < room.maps.size(); ++v) {
    const DenseMaps& maps = result.maps[v];
    const DenseMaps& truth = room.truth[v];
    const size_t num_pixels = maps.depth.size();
    size_t num_blank = 0;
    size_t num_good = 0;
    size_t num_changed = 0;
    for (size_t i = 0; i < num_pixels; ++i) {
      const Surface surface = SurfaceOfMapPixel(room.scene.views[v], i);
      num_blank += surface == Surface::kBlank;
      if (maps.depth[i] == room.maps[v].depth[i]) {
        continue;
      }
      ++num_changed;
      // At the segment's edge the sizes' pixels differ by less than one.
      EXPECT_NE(surface, Surface::kNothing);
      EXPECT_NE(surface, Surface::kFloor);
      double cosine = 0;
      double norm2 = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const double value = maps.normal[axis * num_pixels + i];
        norm2 += value * value;
        cosine += value * truth.normal[axis * num_pixels + i];
      }
      EXPECT_NEAR(norm2, 1, 1e-5);
      EXPECT_GT(cosine, std::cos(3 * M_PI / 180));
      EXPECT_NEAR(maps.depth[i] / truth.depth[i], 1, 0.01);
      num_good += surface == Surface::kBlank;
    }
    EXPECT_GE(result.num_pixels[v], num_changed);
    EXPECT_GT(num_good, 0.95 * num_blank) << v;
    EXPECT_GT(num_blank, num_pixels / 10) << v;
    EXPECT_EQ(maps.distinctness, room.maps[v].distinctness);
  }
}

// The last ones have lattice cells of two pixels, which the sizes are no
// multiple of.
INSTANTIATE_TEST_SUITE_P(Sizes,
                         PlaneCompletionSizesTest,
                         testing::Values(std::tuple(160, 160),
                                         std::tuple(200, 96),
                                         std::tuple(324, 323)));

TEST(PlaneCompletion, ReliablePixelsAndThoseWithoutDepthStay) {
  Room room = MakeRoom(160, 160);
  for (size_t v = 0; v < room.maps.size(); ++v) {
    DenseMaps& maps = room.maps[v];
    for (size_t i = 0; i < maps.depth.size(); i += 7) {
      for (int axis = 0; axis < 3; ++axis) {
        maps.normal[axis * maps.depth.size() + i] = 0;
      }
      maps.depth[i] = 0;
      maps.distinctness[i] = 0;
    }
  }
  const Completed result = Complete(room);
  for (size_t v = 0; v < room.maps.size(); ++v) {
    const size_t num_pixels = room.maps[v].depth.size();
    size_t num_in_picture = 0;
    for (size_t i = 0; i < num_pixels; ++i) {
      const Surface surface = SurfaceOfMapPixel(room.scene.views[v], i);
      // Not where it ends, for there the views may not agree.
      const auto is_in_picture = [&](const size_t index) {
        return SurfaceOfMapPixel(room.scene.views[v], index) ==
               Surface::kPicture;
      };
      const bool is_within = surface == Surface::kPicture &&
                             is_in_picture(i - 3 * 160 - 3) &&
                             is_in_picture(i + 3 * 160 + 3);
      if (i % 7 == 0 || is_within) {
        EXPECT_EQ(result.maps[v].depth[i], room.maps[v].depth[i]);
        for (int axis = 0; axis < 3; ++axis) {
          EXPECT_EQ(result.maps[v].normal[axis * num_pixels + i],
                    room.maps[v].normal[axis * num_pixels + i]);
        }
        num_in_picture += is_within;
      }
    }
    EXPECT_GT(num_in_picture, 20u);
    EXPECT_GT(result.num_pixels[v], num_pixels / 10);
  }
}

TEST(PlaneCompletion, ThreadsDoNotMatter) {
  const Room room = MakeRoom(160, 80);
  const Completed expected = Complete(room, 1);
  const Completed result = Complete(room, 3);
  EXPECT_EQ(result.num_pixels, expected.num_pixels);
  for (size_t v = 0; v < room.maps.size(); ++v) {
    EXPECT_GT(expected.num_pixels[v], 0u);
    EXPECT_EQ(result.maps[v].depth, expected.maps[v].depth);
    EXPECT_EQ(result.maps[v].normal, expected.maps[v].normal);
  }
}

TEST(PlaneCompletion, WithoutADominantDirectionNothingChanges) {
  Room room = MakeRoom(160, 160);
  Random random(5);
  for (DenseMaps& maps : room.maps) {
    const size_t num_pixels = maps.depth.size();
    for (size_t i = 0; i < num_pixels; ++i) {
      // Within the half that faces the camera.
      const Eigen::Vector3f normal = Eigen::Vector3f(2 * random.NextFloat() - 1,
                                                     2 * random.NextFloat() - 1,
                                                     -0.6f - random.NextFloat())
                                         .normalized();
      for (int axis = 0; axis < 3; ++axis) {
        maps.normal[axis * num_pixels + i] = normal[axis];
      }
    }
  }
  ExpectUnchanged(Complete(room), room);
}

TEST(PlaneCompletion, WithoutReliablePixelsNothingChanges) {
  Room room = MakeRoom(160, 80);
  for (DenseMaps& maps : room.maps) {
    maps.distinctness.assign(maps.depth.size(), 0);
  }
  ExpectUnchanged(Complete(room), room);
}

// Each of them alone may be wrong in the same way everywhere.
TEST(PlaneCompletion, WhatNoOtherViewConfirmsIsNotReliable) {
  Room room = MakeRoom(160, 80);
  for (size_t v = 0; v < room.maps.size(); ++v) {
    for (float& depth : room.maps[v].depth) {
      depth *= 1 + 0.04f * static_cast<float>(v);
    }
  }
  ExpectUnchanged(Complete(room), room);
}

TEST(PlaneCompletion, WithoutSegmentsNothingChanges) {
  Room room = MakeRoom(160, 80);
  for (View& view : room.scene.views) {
    view.segments.clear();
  }
  ExpectUnchanged(Complete(room), room);
}

TEST(PlaneCompletion, PlanesThatTooFewViewsNameAreNotTaken) {
  Room room = MakeRoom(160, 160);
  for (size_t v = 0; v < room.maps.size(); ++v) {
    // No picture, which all would see.
    for (size_t i = 0; i < room.maps[v].distinctness.size(); ++i) {
      if (SurfaceOfMapPixel(room.scene.views[v], i) == Surface::kPicture) {
        room.maps[v].distinctness[i] = 0;
      }
    }
  }
  // The first view needs two others. The last ones take the floor instead of
  // the wall for a segment.
  for (const size_t num_naming : {3, 2, 1}) {
    for (size_t v = num_naming; v < room.scene.views.size(); ++v) {
      View& view = room.scene.views[v];
      for (size_t i = 0; i < view.segments.size(); ++i) {
        view.segments[i] =
            SurfaceOfMapPixel(view, i) == Surface::kFloor ? 0 : -1;
      }
    }
    const Completed result = Complete(room);
    if (num_naming == 3) {
      EXPECT_GT(result.num_pixels[0], room.maps[0].depth.size() / 20);
    } else {
      EXPECT_EQ(result.num_pixels[0], 0u);
      EXPECT_EQ(result.maps[0].depth, room.maps[0].depth);
    }
  }
}

TEST(PlaneCompletion, MaskedPixelsStay) {
  Room room = MakeRoom(160, 160);
  View& view = room.scene.views[2];
  view.mask.assign(view.segments.size(), 255);
  for (size_t i = 0; i < view.mask.size(); ++i) {
    if (i % 160 < 80) {
      view.mask[i] = 0;
    }
  }
  const Completed result = Complete(room);
  size_t num_changed = 0;
  for (size_t i = 0; i < view.mask.size(); ++i) {
    const bool is_changed = result.maps[2].depth[i] != room.maps[2].depth[i];
    EXPECT_FALSE(is_changed && view.mask[i] == 0);
    num_changed += is_changed;
  }
  EXPECT_GT(num_changed, view.mask.size() / 20);
}

TEST(PlaneCompletion, ViewsThatWereNotAddedAreLeftOut) {
  const Room room = MakeRoom(160, 80);
  const Completed result = Complete(room, 2, 4);
  EXPECT_GT(result.num_pixels[0], 0u);
  EXPECT_EQ(result.num_pixels[4], 0u);
  EXPECT_EQ(result.maps[4].depth, room.maps[4].depth);
}

TEST(PlaneCompletion, ViewsWithoutASayAreCompletedAlone) {
  const std::vector<int> voter_idxs = {0, 1, 2, 3};
  Room room = MakeRoom(160, 80);
  for (std::vector<int>& of_view : room.sources) {
    of_view.erase(std::remove(of_view.begin(), of_view.end(), 4),
                  of_view.end());
  }
  const Completed expected = Complete(room, 2, 5, voter_idxs);
  EXPECT_GT(expected.num_pixels[4], 0u);
  Room other = room;
  for (size_t i = 0; i < other.maps[4].depth.size(); ++i) {
    other.maps[4].depth[i] *= 1.0f + 0.001f * static_cast<float>(i % 160);
  }
  const Completed with_other = Complete(other, 2, 5, voter_idxs);
  const Completed with_its_say = Complete(other);
  bool has_influence = false;
  for (size_t v = 0; v < 4; ++v) {
    EXPECT_GT(expected.num_pixels[v], 0u);
    EXPECT_EQ(with_other.maps[v].depth, expected.maps[v].depth);
    EXPECT_EQ(with_other.maps[v].normal, expected.maps[v].normal);
    has_influence |= with_its_say.maps[v].depth != expected.maps[v].depth;
  }
  EXPECT_TRUE(has_influence);
}

TEST(PlaneCompletion, EndsBetweenViewsWhenTold) {
  class AbortLater : public Progress {
   public:
    bool ShouldAbort() override { return ++num_asked > 7; }
    int num_asked = 0;
  };
  const Room room = MakeRoom(160, 80);
  const TrainingViews views(room.scene, room.frame);
  const std::vector<int> voter_idxs = {0, 1, 2, 3, 4};
  PlaneCompletion completion(
      room.scene, room.frame, views, voter_idxs, room.sources, 5);
  ThreadPool pool(1);
  for (size_t v = 0; v < room.maps.size(); ++v) {
    completion.AddView(static_cast<int>(v), room.maps[v], &pool);
  }
  AbortLater progress;
  EXPECT_THROW(completion.FindPlanes(&pool, &progress), Aborted);
  EXPECT_EQ(progress.num_asked, 8);
}

TEST(PlaneCompletion, WithoutSourcesNothingChanges) {
  Room room = MakeRoom(160, 80);
  room.scene.views.resize(1);
  room.maps.resize(1);
  room.sources = {{}};
  ExpectUnchanged(Complete(room), room);
}

TEST(PlaneCompletion, ImagesOfAFewPixelsAreHandled) {
  for (const auto& [camera_width, image_width] :
       {std::tuple(2, 2), {7, 2}, {5, 5}}) {
    const Room room = MakeRoom(camera_width, image_width);
    const Completed result = Complete(room);
    for (size_t v = 0; v < room.maps.size(); ++v) {
      for (size_t i = 0; i < result.maps[v].depth.size(); ++i) {
        EXPECT_NEAR(result.maps[v].depth[i], room.truth[v].depth[i], 2) << i;
      }
    }
  }
}

}  // namespace
}  // namespace structnerf
