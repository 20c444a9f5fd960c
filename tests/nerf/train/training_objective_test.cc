// How the objective has rays drawn, step by step. Which these are is in
// ray_drawer_test.cc, what they are worth in training_loss_test.cc.

#include "nerf/train/training_objective.h"

#include "tests/nerf/train/objective_scene.h"

#include <map>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

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

TEST(DrawRays, SparsePointsAreDrawnInTheFirstPartOnly) {
  ObjectiveScene test;
  test.loss.sparse_fraction = 0.5;
  std::map<int, int> num_sparse;
  const TrainingObjective objective = test.MakeObjective();
  const auto tile_objective = objective.MakeTileObjective();
  for (const int step : {0, 48, 49, 50, 51, 99}) {
    for (int tile = 0; tile < objective.NumTiles(); ++tile) {
      RayTile rays;
      tile_objective->DrawRays(step, tile, &rays);
      for (int ray = 0; ray < rays.num_rays; ++ray) {
        num_sparse[step] += !test.Identify(rays, ray).IsPixelCenter();
      }
    }
  }
  EXPECT_GT(num_sparse[0], 0);
  EXPECT_EQ(num_sparse[48], num_sparse[0]);
  EXPECT_EQ(num_sparse[49], num_sparse[0]);
  EXPECT_EQ(num_sparse[50], 0);
  EXPECT_EQ(num_sparse[51], 0);
  EXPECT_EQ(num_sparse[99], 0);
}

TEST(DrawRays, PriorsGuideTheirViewsRays) {
  ObjectiveScene test;
  test.AddPrior(1.1f);
  const TrainingObjective objective(test.scene,
                                    test.frame,
                                    test.train_view_idxs,
                                    {{1}, {0}, {0}, {0}},
                                    test.loss,
                                    test.training,
                                    /*is_guided=*/true);
  RayTile rays;
  objective.MakeTileObjective()->DrawRays(0, 0, &rays);
  EXPECT_TRUE(rays.is_guided);
  for (int ray = 0; ray < rays.num_rays; ++ray) {
    const auto point = test.Identify(rays, ray);
    if (point.view_idx == 1) {
      EXPECT_NEAR(
          rays.guide_depth[ray],
          1.1 * test.TrueDepth({1, point.Col() + 0.5, point.Row() + 0.5}),
          1e-4);
      EXPECT_NEAR(rays.guide_deviation[ray], 1e-3 * test.frame.scale, 1e-6);
    } else {
      EXPECT_EQ(rays.guide_depth[ray], 0);
    }
  }
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
  EXPECT_EQ(count(), 320 * 160 / 256);
  // Of fewer views than that, none is.
  test.training.test_every = 100;
  EXPECT_EQ(count(), 320 * 160 / 256);
  test.train_view_idxs.pop_back();
  EXPECT_EQ(count(), 0);
}

TEST(BlankShare, IsThatOfTheFarTerm) {
  ObjectiveScene test;
  test.loss.far_weight = 0.01;
  const double textured = test.MakeObjective().BlankShare();
  // One of four views shows nothing.
  RgbImage& image = test.scene.views[0].image;
  image = PlainImage(image.width, image.height, 99);
  const double with_blank = test.MakeObjective().BlankShare();
  EXPECT_LT(textured, 0.5);
  EXPECT_GT(with_blank, textured + 0.25 * (1 - textured) * 0.9);
  EXPECT_LE(with_blank, 1);
  test.loss.far_weight = 0;
  EXPECT_EQ(test.MakeObjective().BlankShare(), 0);
}

}  // namespace
}  // namespace structnerf
