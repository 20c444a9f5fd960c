#include "nerf/train/ray_drawer.h"

#include "nerf/train/keypoints.h"
#include "tests/nerf/train/objective_scene.h"

#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

using ImagePoint = ObjectiveScene::ImagePoint;

// A drawer and what it draws from.
class SceneDrawer {
 public:
  explicit SceneDrawer(const ObjectiveScene& test)
      : views_(test.scene, test.frame),
        hints_(test.scene, test.frame, test.train_view_idxs, views_, test.loss),
        drawer_(test.scene,
                test.train_view_idxs,
                views_,
                hints_,
                test.loss,
                test.training.seed,
                /*is_guided=*/false),
        num_tiles_(test.training.rays_per_step / kMaxTileRays),
        with_sparse_(test.loss.sparse_weight > 0 &&
                     !hints_.SparseRays().empty()) {}

  const TrainingViews& Views() const { return views_; }

  // Calls visit(drawn) for the tiles of the first steps.
  void ForEachTile(
      const int num_steps,
      const std::function<void(const DrawnRays& drawn)>& visit) const {
    DrawnRays drawn;
    for (int step = 0; step < num_steps; ++step) {
      for (int tile = 0; tile < num_tiles_; ++tile) {
        RayTile rays;
        drawer_.Draw(step, tile, with_sparse_, &rays, &drawn);
        ASSERT_EQ(rays.num_rays, kMaxTileRays);
        ASSERT_EQ(drawn.tile, &rays);
        visit(drawn);
      }
    }
  }

  // Calls visit(rays, ray) for their rays.
  void ForEachRay(
      const int num_steps,
      const std::function<void(const RayTile& rays, int ray)>& visit) const {
    ForEachTile(num_steps, [&](const DrawnRays& drawn) {
      for (int ray = 0; ray < drawn.tile->num_rays; ++ray) {
        visit(*drawn.tile, ray);
      }
    });
  }

 private:
  const TrainingViews views_;
  const SceneHints hints_;
  const RayDrawer drawer_;
  const int num_tiles_;
  const bool with_sparse_;
};

TEST(DrawnRays, GoThroughPixelsOrSparsePoints) {
  ObjectiveScene test;
  int num_sparse = 0;
  SceneDrawer(test).ForEachRay(3, [&](const RayTile& rays, const int ray) {
    const ImagePoint point = test.Identify(rays, ray);
    const RgbImage& image = test.scene.views[point.view_idx].image;
    ASSERT_GE(point.x, 0);
    ASSERT_LT(point.x, image.width);
    ASSERT_GE(point.y, 0);
    ASSERT_LT(point.y, image.height);
    if (point.IsPixelCenter()) {
      return;
    }
    ++num_sparse;
    bool is_observation = false;
    for (const SparsePoint& sparse : test.scene.points) {
      for (const Observation& observation : sparse.track) {
        is_observation |= observation.view_idx == point.view_idx &&
                          std::abs(0.5 * observation.xy.x() - point.x) < 1e-3 &&
                          std::abs(0.5 * observation.xy.y() - point.y) < 1e-3;
      }
    }
    EXPECT_TRUE(is_observation) << point.x << " " << point.y;
  });
  EXPECT_GE(num_sparse, 3 * 8);  // there are eight tiles
}

TEST(DrawnRays, EverySparsePointComesUp) {
  ObjectiveScene test;
  std::set<std::pair<int, int>> places;
  SceneDrawer(test).ForEachRay(45, [&](const RayTile& rays, const int ray) {
    const ImagePoint point = test.Identify(rays, ray);
    if (!point.IsPixelCenter()) {
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

TEST(DrawnRays, HeldOutViewsAreNeverDrawn) {
  ObjectiveScene test;
  test.train_view_idxs = {0, 3};
  std::map<int, int> counts;
  SceneDrawer(test).ForEachRay(60, [&](const RayTile& rays, const int ray) {
    ++counts[test.Identify(rays, ray).view_idx];
  });
  EXPECT_EQ(counts.count(1), 0u);
  EXPECT_EQ(counts.count(2), 0u);
  EXPECT_GT(counts[0], 1000);
  EXPECT_GT(counts[3], 1000);
}

TEST(DrawnRays, PixelsAreEquallyLikely) {
  ObjectiveScene test;
  test.loss.sparse_weight = 0;
  test.loss.planar_weight = 0;
  // An image of its own size: views count by their pixels.
  test.plane.Photograph(12, 9, &test.scene.views[2]);
  test.scene.views[2].segments.clear();
  std::map<int, int> view_counts;
  std::map<int, int> pixel_counts;
  SceneDrawer(test).ForEachRay(400, [&](const RayTile& rays, const int ray) {
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
TEST(DrawnRays, MaskedPixelsAreNeverDrawn) {
  ObjectiveScene test;
  const std::set<int> unmasked = {0, 23, 30, 31, 200, 431};
  for (View& view : test.scene.views) {
    view.mask.assign(24 * 18, 0);
  }
  for (const int pixel : unmasked) {
    test.scene.views[1].mask[pixel] = 255;
  }
  std::map<int, int> counts;
  SceneDrawer(test).ForEachRay(100, [&](const RayTile& rays, const int ray) {
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

TEST(DrawnRays, MasksThatLeaveNothingAreRefused) {
  ObjectiveScene test;
  for (View& view : test.scene.views) {
    view.mask.assign(24 * 18, 0);
  }
  EXPECT_THROW(SceneDrawer{test}, std::invalid_argument);
  // Nor does a held-out view help.
  test.scene.views[2].mask.clear();
  test.train_view_idxs = {0, 1, 3};
  EXPECT_THROW(SceneDrawer{test}, std::invalid_argument);
  test.train_view_idxs = {0, 1, 2};
  EXPECT_NO_THROW(SceneDrawer{test});
}

TEST(DrawnRays, PlanarGroupsLieInOneSegment) {
  ObjectiveScene test;
  std::map<int, int> label_counts;
  SceneDrawer(test).ForEachTile(60, [&](const DrawnRays& drawn) {
    ASSERT_EQ(drawn.first_sparse_ray, 4 * drawn.num_planar_groups);
    for (int group = 0; group < drawn.num_planar_groups; ++group) {
      // Barycentric coordinates of the last pixel.
      const float* const b = drawn.planar_groups[group].barycentric;
      const int* const col = drawn.col.data() + 4 * group;
      const int* const row = drawn.row.data() + 4 * group;
      EXPECT_NEAR(b[0] * col[0] + b[1] * col[1] + b[2] * col[2], col[3], 1e-3);
      EXPECT_NEAR(b[0] * row[0] + b[1] * row[1] + b[2] * row[2], row[3], 1e-3);
      const auto label = [&](const int k) {
        const ImagePoint point = test.Identify(*drawn.tile, 4 * group + k);
        EXPECT_EQ(point.view_idx, drawn.view_idx[4 * group]);
        return test.scene.views[point.view_idx]
            .segments[point.Row() * 24 + point.Col()];
      };
      EXPECT_GE(label(0), 0);
      for (int k = 1; k < 4; ++k) {
        EXPECT_EQ(label(k), label(0));
      }
      ++label_counts[label(0)];
    }
  });
  // By area: 12 x 18 against 8 x 12 pixels.
  ASSERT_EQ(label_counts.size(), 2u);
  EXPECT_NEAR(static_cast<double>(label_counts[3]) / label_counts[8],
              12 * 18 / (8.0 * 12),
              0.6);
}

TEST(DrawnRays, NoSegmentsOrPoints) {
  ObjectiveScene test;
  test.scene.points.clear();
  for (View& view : test.scene.views) {
    view.segments.clear();
  }
  SceneDrawer(test).ForEachRay(1, [&](const RayTile& rays, const int ray) {
    EXPECT_TRUE(test.Identify(rays, ray).IsPixelCenter());
  });
}

// What is remembered of a tile is true of its rays, part by part.
TEST(DrawnRays, AreAsRemembered) {
  ObjectiveScene test;
  test.loss.patch_sampling = "keypoints";
  const SceneDrawer drawer(test);
  std::vector<std::set<uint32_t>> keypoints;
  for (int v = 0; v < 4; ++v) {
    const std::vector<uint32_t> pixels = SelectKeypoints(drawer.Views(), v);
    keypoints.emplace_back(pixels.begin(), pixels.end());
  }
  drawer.ForEachTile(10, [&](const DrawnRays& drawn) {
    EXPECT_EQ(drawn.first_keypoint_ray,
              drawn.first_sparse_ray + kNumSparseRays);
    EXPECT_EQ(drawn.first_random_ray,
              (drawn.first_keypoint_ray + kMaxTileRays) / 2);
    for (int ray = 0; ray < kMaxTileRays; ++ray) {
      const ImagePoint point = test.Identify(*drawn.tile, ray);
      ASSERT_EQ(drawn.view_idx[ray], point.view_idx);
      EXPECT_EQ(drawn.tile->appearance[0][ray], point.view_idx);
      EXPECT_EQ(drawn.tile->appearance[1][ray], point.view_idx);
      EXPECT_NEAR(drawn.col[ray] + 0.5, point.x, 0.501);
      EXPECT_NEAR(drawn.row[ray] + 0.5, point.y, 0.501);
      if (drawn.IsSparse(ray)) {
        EXPECT_NEAR(
            drawn.sparse_target[ray].depth, test.TrueDepth(point), 1e-4);
        EXPECT_GT(drawn.sparse_target[ray].weight, 0);
        continue;
      }
      EXPECT_TRUE(point.IsPixelCenter());
      if (ray >= drawn.first_keypoint_ray && ray < drawn.first_random_ray) {
        EXPECT_EQ(
            keypoints[point.view_idx].count(24 * point.Row() + point.Col()),
            1u);
      }
    }
  });
}

}  // namespace
}  // namespace structnerf
