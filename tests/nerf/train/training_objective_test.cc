// Which rays are drawn. What they are worth is in training_loss_test.cc.

#include "nerf/train/training_objective.h"

#include "tests/nerf/train/objective_scene.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

using ImagePoint = ObjectiveScene::ImagePoint;

// The same rays, bit for bit.
bool AreEqual(const RayTile& a, const RayTile& b) {
  bool are_equal = a.num_rays == b.num_rays;
  for (int ray = 0; are_equal && ray < a.num_rays; ++ray) {
    for (int axis = 0; axis < 3; ++axis) {
      are_equal &= a.origin[axis][ray] == b.origin[axis][ray] &&
                   a.direction[axis][ray] == b.direction[axis][ray];
    }
  }
  return are_equal;
}

// Calls visit(step, rays, ray) for the rays of some steps' tiles.
void ForEachRay(
    const TrainingObjective& objective,
    const std::vector<int>& steps,
    const std::function<void(int step, const RayTile& rays, int ray)>& visit) {
  const auto tile_objective = objective.MakeTileObjective();
  for (const int step : steps) {
    for (int tile = 0; tile < objective.NumTiles(); ++tile) {
      RayTile rays;
      tile_objective->DrawRays(step, tile, &rays);
      ASSERT_EQ(rays.num_rays, kMaxTileRays);
      for (int ray = 0; ray < rays.num_rays; ++ray) {
        visit(step, rays, ray);
      }
    }
  }
}

std::vector<int> FirstSteps(const int count) {
  std::vector<int> steps;
  for (int step = 0; step < count; ++step) {
    steps.push_back(step);
  }
  return steps;
}

bool IsPixelCenter(const ImagePoint& point) {
  return std::abs(point.x - point.Col() - 0.5) < 1e-3 &&
         std::abs(point.y - point.Row() - 0.5) < 1e-3;
}

TEST(DrawRays, TilesHoldTheRaysOfAStep) {
  ObjectiveScene test;
  for (const int rays_per_step : {32, 33, 256, 1000}) {
    test.training.rays_per_step = rays_per_step;
    EXPECT_EQ(test.MakeObjective().NumTiles(), (rays_per_step + 31) / 32);
  }
}

TEST(DrawRays, DependOnSeedStepAndTileOnly) {
  ObjectiveScene test;
  const TrainingObjective objective = test.MakeObjective();
  const auto first = objective.MakeTileObjective();
  const auto second = objective.MakeTileObjective();
  RayTile rays;
  RayTile same;
  // Whatever was drawn before, and by whom.
  second->DrawRays(4, 1, &same);
  second->DrawRays(7, 3, &same);
  first->DrawRays(7, 3, &rays);
  EXPECT_TRUE(AreEqual(rays, same));

  RayTile other;
  first->DrawRays(7, 2, &other);
  EXPECT_FALSE(AreEqual(rays, other));
  first->DrawRays(8, 3, &other);
  EXPECT_FALSE(AreEqual(rays, other));
  test.training.seed = 1;
  test.MakeObjective().MakeTileObjective()->DrawRays(7, 3, &other);
  EXPECT_FALSE(AreEqual(rays, other));
}

TEST(DrawRays, GoThroughPixelsOrSparsePoints) {
  ObjectiveScene test;
  const TrainingObjective objective = test.MakeObjective();
  int num_sparse = 0;
  ForEachRay(
      objective, {0, 1, 2}, [&](int, const RayTile& rays, const int ray) {
        const ImagePoint point = test.Identify(rays, ray);
        const RgbImage& image = test.scene.views[point.view_idx].image;
        ASSERT_GE(point.x, 0);
        ASSERT_LT(point.x, image.width);
        ASSERT_GE(point.y, 0);
        ASSERT_LT(point.y, image.height);
        if (IsPixelCenter(point)) {
          return;
        }
        ++num_sparse;
        bool is_observation = false;
        for (const SparsePoint& sparse : test.scene.points) {
          for (const Observation& observation : sparse.track) {
            is_observation |=
                observation.view_idx == point.view_idx &&
                std::abs(0.5 * observation.xy.x() - point.x) < 1e-3 &&
                std::abs(0.5 * observation.xy.y() - point.y) < 1e-3;
          }
        }
        EXPECT_TRUE(is_observation) << point.x << " " << point.y;
      });
  EXPECT_GE(num_sparse, 3 * objective.NumTiles());
}

TEST(DrawRays, SparsePointsAreDrawnInTheFirstPartOnly) {
  ObjectiveScene test;
  test.loss.sparse_fraction = 0.5;
  std::map<int, int> num_sparse;
  ForEachRay(test.MakeObjective(),
             {0, 48, 49, 50, 51, 99},
             [&](const int step, const RayTile& rays, const int ray) {
               num_sparse[step] += !IsPixelCenter(test.Identify(rays, ray));
             });
  EXPECT_GT(num_sparse[0], 0);
  EXPECT_EQ(num_sparse[48], num_sparse[0]);
  EXPECT_EQ(num_sparse[49], num_sparse[0]);
  EXPECT_EQ(num_sparse[50], 0);
  EXPECT_EQ(num_sparse[51], 0);
  EXPECT_EQ(num_sparse[99], 0);
}

TEST(DrawRays, EverySparsePointComesUp) {
  ObjectiveScene test;
  std::set<std::pair<int, int>> places;
  ForEachRay(test.MakeObjective(),
             FirstSteps(45),
             [&](int, const RayTile& rays, const int ray) {
               const ImagePoint point = test.Identify(rays, ray);
               if (!IsPixelCenter(point)) {
                 places.insert({point.view_idx,
                                static_cast<int>(1e3 * point.x + 0.5) * 100000 +
                                    static_cast<int>(1e3 * point.y + 0.5)});
               }
             });
  size_t num_observations = 0;
  for (const SparsePoint& point : test.scene.points) {
    num_observations += point.track.size();
  }
  EXPECT_GT(places.size(), 0.95 * num_observations);
}

TEST(DrawRays, HeldOutViewsAreNeverDrawn) {
  ObjectiveScene test;
  test.train_view_idxs = {0, 3};
  std::map<int, int> counts;
  ForEachRay(test.MakeObjective(),
             FirstSteps(60),
             [&](int, const RayTile& rays, const int ray) {
               ++counts[test.Identify(rays, ray).view_idx];
             });
  EXPECT_EQ(counts.count(1), 0u);
  EXPECT_EQ(counts.count(2), 0u);
  EXPECT_GT(counts[0], 1000);
  EXPECT_GT(counts[3], 1000);
}

TEST(IsHeldOut, OneOf256PixelsIfNoViewIs) {
  ObjectiveScene test;
  const auto count = [&] {
    const TrainingObjective objective = test.MakeObjective();
    int num_held_out = 0;
    for (int row = 0; row < 160; ++row) {
      for (int col = 0; col < 320; ++col) {
        num_held_out += objective.IsHeldOut(col, row);
      }
    }
    return num_held_out;
  };
  test.training.test_every = 0;
  EXPECT_EQ(count(), 320 * 160 / 256);
  test.training.test_every = 2;
  EXPECT_EQ(count(), 0);
}

TEST(DrawRays, PixelsAreEquallyLikely) {
  ObjectiveScene test;
  test.loss.sparse_weight = 0;
  test.loss.planar_weight = 0;
  // An image of its own size: views count by their pixels.
  test.plane.Photograph(12, 9, &test.scene.views[2]);
  test.scene.views[2].segments.clear();
  std::map<int, int> view_counts;
  std::map<int, int> pixel_counts;
  ForEachRay(test.MakeObjective(),
             FirstSteps(400),
             [&](int, const RayTile& rays, const int ray) {
               const ImagePoint point = test.Identify(rays, ray);
               ++view_counts[point.view_idx];
               if (point.view_idx == 1) {
                 ++pixel_counts[point.Row() * 24 + point.Col()];
               }
             });
  const double num_rays = 400 * 256;
  const double num_pixels = 3 * 24 * 18 + 12 * 9;
  EXPECT_NEAR(view_counts[2], num_rays * 12 * 9 / num_pixels, 300);
  EXPECT_NEAR(view_counts[1], num_rays * 24 * 18 / num_pixels, 900);
  // 73 in the mean; six standard deviations.
  ASSERT_EQ(pixel_counts.size(), 24u * 18);
  for (const auto& [pixel, count] : pixel_counts) {
    EXPECT_NEAR(count, num_rays / num_pixels, 51) << pixel;
  }
}

// Masks that leave a few pixels, not under the sparse points and in part of
// the superpixels.
TEST(DrawRays, MaskedPixelsAreNeverDrawn) {
  ObjectiveScene test;
  const std::set<int> unmasked = {0, 23, 30, 31, 200, 431};
  for (View& view : test.scene.views) {
    view.mask.assign(24 * 18, 0);
  }
  for (const int pixel : unmasked) {
    test.scene.views[1].mask[pixel] = 255;
  }
  std::map<int, int> counts;
  ForEachRay(test.MakeObjective(),
             FirstSteps(100),
             [&](int, const RayTile& rays, const int ray) {
               const ImagePoint point = test.Identify(rays, ray);
               ASSERT_EQ(point.view_idx, 1);
               ++counts[point.Row() * 24 + point.Col()];
             });
  // Each of them, and nothing else.
  ASSERT_EQ(counts.size(), unmasked.size());
  for (const int pixel : unmasked) {
    EXPECT_GT(counts[pixel], 100 * 256 / 12) << pixel;
  }
}

TEST(DrawRays, MasksThatLeaveNothingAreRefused) {
  ObjectiveScene test;
  for (View& view : test.scene.views) {
    view.mask.assign(24 * 18, 0);
  }
  EXPECT_THROW(test.MakeObjective(), std::invalid_argument);
  // Nor does a held-out view help.
  test.scene.views[2].mask.clear();
  test.train_view_idxs = {0, 1, 3};
  EXPECT_THROW(test.MakeObjective(), std::invalid_argument);
  test.train_view_idxs = {0, 1, 2};
  EXPECT_NO_THROW(test.MakeObjective());
}

// Rays that only the planar term looks at are those of its groups.
TEST(DrawRays, PlanarGroupsLieInOneSegment) {
  ObjectiveScene test;
  test.loss.patch_weight = 0;
  test.loss.sparse_weight = 0;
  test.loss.prior_weight = 0;
  const TrainingObjective objective = test.MakeObjective();
  const auto tile_objective = objective.MakeTileObjective();
  std::map<int, int> label_counts;
  for (int step = 0; step < 60; ++step) {
    for (int tile = 0; tile < objective.NumTiles(); ++tile) {
      RayTile rays;
      tile_objective->DrawRays(step, tile, &rays);
      // Far from any plane, so that all four have a gradient.
      RayOutputs outputs = test.TrueOutputs(rays);
      for (int ray = 0; ray < rays.num_rays; ++ray) {
        outputs.depth[ray] *= 1 + 0.1f * static_cast<float>(ray % 7);
      }
      RayGradients gradients;
      tile_objective->Evaluate(outputs, &gradients);
      std::vector<ImagePoint> members;
      for (int ray = 0; ray < rays.num_rays; ++ray) {
        if (gradients.d_depth[ray] != 0) {
          members.push_back(test.Identify(rays, ray));
        }
      }
      ASSERT_GE(members.size(), 3u);
      for (const ImagePoint& point : members) {
        const int label = test.scene.views[point.view_idx]
                              .segments[point.Row() * 24 + point.Col()];
        EXPECT_GE(label, 0);
        ++label_counts[label];
      }
    }
  }
  // By area: 12 x 18 against 8 x 12 pixels.
  ASSERT_EQ(label_counts.size(), 2u);
  EXPECT_NEAR(static_cast<double>(label_counts[3]) / label_counts[8],
              12 * 18 / (8.0 * 12),
              0.6);
}

TEST(DrawRays, NoSegmentsOrPoints) {
  ObjectiveScene test;
  test.scene.points.clear();
  for (View& view : test.scene.views) {
    view.segments.clear();
  }
  ForEachRay(
      test.MakeObjective(), {0}, [&](int, const RayTile& rays, const int ray) {
        EXPECT_TRUE(IsPixelCenter(test.Identify(rays, ray)));
      });
}

}  // namespace
}  // namespace structnerf
