#include "nerf/stereo/depth_refinement.h"

#include "tests/nerf/losses/patch_scene.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// Three views of a slanted wall. The first one's image is smaller than its
// camera by the given sizes.
Scene MakeScene(TexturedPlane* plane, const int width, const int height) {
  plane->normal = Eigen::Vector3d(0.5, -0.4, -1);
  plane->wavelength = 0.35;
  Scene scene;
  const PinholeCamera camera = MakeCamera(128, 96, 170);
  scene.views = {MakeView("middle", camera, Eigen::Vector3d(0, 0, 0)),
                 MakeView("right",
                          camera,
                          Eigen::Vector3d(0.6, 0.1, 0.1),
                          Eigen::Vector3d(-0.15, 0, 1)),
                 MakeView("left",
                          camera,
                          Eigen::Vector3d(-0.5, -0.2, 0),
                          Eigen::Vector3d(0.13, 0.03, 1))};
  plane->Photograph(width, height, &scene.views[0]);
  plane->Photograph(64, 48, &scene.views[1]);
  plane->Photograph(64, 48, &scene.views[2]);
  return scene;
}

// The truth, at the image points of DenseMaps, with depths off by a factor.
DenseMaps MakeMaps(const TexturedPlane& plane,
                   const View& view,
                   const double factor) {
  DenseMaps maps = plane.DepthMap(view, factor);
  maps.relative_std.assign(maps.depth.size(), 0.01f);
  const Eigen::Vector3d normal = plane.NormalInView(view);
  for (int axis = 0; axis < 3; ++axis) {
    maps.normal.insert(
        maps.normal.end(), maps.depth.size(), static_cast<float>(normal[axis]));
  }
  return maps;
}

struct Errors {
  double depth = 0;   // largest, relative
  double normal = 0;  // largest distance
};

Errors ErrorsOf(const DenseMaps& maps, const DenseMaps& truth) {
  Errors errors;
  const size_t n = maps.depth.size();
  for (size_t i = 0; i < n; ++i) {
    double distance2 = 0;
    for (int axis = 0; axis < 3; ++axis) {
      distance2 +=
          std::pow(maps.normal[axis * n + i] - truth.normal[axis * n + i], 2.0);
    }
    errors.depth = std::max<double>(
        errors.depth, std::abs(maps.depth[i] / truth.depth[i] - 1));
    errors.normal = std::max(errors.normal, std::sqrt(distance2));
  }
  return errors;
}

void RefineMaps(const Scene& scene,
                const StereoOptions& options,
                DenseMaps* maps) {
  const SceneFrame frame = MakePatchFrame();
  const TrainingViews views(scene, frame);
  const PatchMatch patch_match(scene, frame, views, {{1, 2}, {}, {}}, options);
  ThreadPool pool(2);
  Progress progress;
  RefineDepth(scene.views[0],
              0,
              frame,
              views.image(0),
              patch_match,
              &pool,
              &progress,
              maps);
}

// Without a sweep the planes go to the image's pixels and back. On a plane this
// must lose nothing, whatever the sizes; half a pixel off would show.
TEST(DepthRefinement, ResolutionsAreMappedExactly) {
  StereoOptions options;
  options.num_iterations = 0;
  for (const auto& [width, height] :
       {std::pair(128, 96), {64, 48}, {51, 40}, {17, 96}}) {
    TexturedPlane plane;
    const Scene scene = MakeScene(&plane, width, height);
    const DenseMaps truth = MakeMaps(plane, scene.views[0], 1.0);
    ASSERT_GT(std::abs(truth.depth[1] / truth.depth[0] - 1), 1e-3);
    DenseMaps maps = truth;
    RefineMaps(scene, options, &maps);
    const Errors errors = ErrorsOf(maps, truth);
    EXPECT_LT(errors.depth, 1e-5) << width;
    EXPECT_LT(errors.normal, 1e-4) << width;
    EXPECT_EQ(maps.relative_std, truth.relative_std);
  }
}

// Also where the image's pixels lie between those of the maps.
TEST(DepthRefinement, PlanesOfASlantedWallAreThoseOfItsMaps) {
  for (const auto& [width, height] :
       {std::pair(128, 96), {64, 48}, {51, 40}, {17, 96}}) {
    TexturedPlane plane;
    const Scene scene = MakeScene(&plane, width, height);
    const View& view = scene.views[0];
    const SceneFrame frame = MakePatchFrame();
    const TrainingViews views(scene, frame);
    ThreadPool pool(2);
    DenseMaps maps = MakeMaps(plane, view, 1.0);
    const PlaneMaps planes =
        PlanesOfMaps(view, frame, views.image(0), &pool, maps);
    ASSERT_EQ(planes.width, width);
    ASSERT_EQ(planes.height, height);
    const auto rho_at = [&](const double col, const double row) {
      const double depth = plane.Depth(
          view, (col + 0.5) * 128 / width, (row + 0.5) * 96 / height);
      return 1 / (depth * frame.scale);
    };
    for (int row = 0; row < height; ++row) {
      for (int col = 0; col < width; ++col) {
        const size_t i = static_cast<size_t>(row) * width + col;
        const double rho = rho_at(col, row);
        EXPECT_NEAR(planes.rho[i], rho, 1e-5 * rho);
        EXPECT_NEAR(planes.rho_x[i], rho_at(col + 1, row) - rho, 1e-5 * rho);
        EXPECT_NEAR(planes.rho_y[i], rho_at(col, row + 1) - rho, 1e-5 * rho);
      }
    }
    // No depth, no plane.
    maps.depth.assign(maps.depth.size(), 0);
    const std::vector<float> zeros(planes.rho.size(), 0);
    EXPECT_EQ(PlanesOfMaps(view, frame, views.image(0), &pool, maps).rho,
              zeros);
  }
}

TEST(DepthRefinement, DepthAndNormalsConverge) {
  TexturedPlane plane;
  const Scene scene = MakeScene(&plane, 64, 48);
  StereoOptions options;
  options.num_iterations = 4;
  const DenseMaps truth = MakeMaps(plane, scene.views[0], 1.0);
  DenseMaps maps = MakeMaps(plane, scene.views[0], 1.03);
  const size_t n = maps.depth.size();
  // Normals that look straight at the camera.
  for (size_t i = 0; i < n; ++i) {
    maps.normal[i] = 0;
    maps.normal[n + i] = 0;
    maps.normal[2 * n + i] = -1;
  }
  RefineMaps(scene, options, &maps);
  int num_good = 0;
  int num_all = 0;
  for (int row = 14; row < 82; ++row) {
    for (int col = 14; col < 114; ++col) {
      const size_t i = static_cast<size_t>(row) * 128 + col;
      double cosine = 0;
      double norm2 = 0;
      for (int axis = 0; axis < 3; ++axis) {
        cosine += maps.normal[axis * n + i] * truth.normal[axis * n + i];
        norm2 += maps.normal[axis * n + i] * maps.normal[axis * n + i];
      }
      EXPECT_NEAR(norm2, 1.0, 1e-5);
      num_good += std::abs(maps.depth[i] / truth.depth[i] - 1) < 0.005 &&
                  cosine > std::cos(5 * M_PI / 180);
      ++num_all;
    }
  }
  EXPECT_GT(num_good, 0.95 * num_all);
}

TEST(DepthRefinement, WhatDoesNotMatchStays) {
  TexturedPlane plane;
  Scene scene = MakeScene(&plane, 64, 48);
  for (View& view : scene.views) {
    view.image = PlainImage(view.image.width, view.image.height, 90);
  }
  const DenseMaps before = MakeMaps(plane, scene.views[0], 1.03);
  DenseMaps maps = before;
  RefineMaps(scene, StereoOptions(), &maps);
  EXPECT_EQ(maps.depth, before.depth);
  EXPECT_EQ(maps.normal, before.normal);
  EXPECT_EQ(maps.distinctness, std::vector<float>(maps.depth.size(), 0));
}

TEST(DepthRefinement, WhatMatchesIsDistinct) {
  TexturedPlane plane;
  const Scene scene = MakeScene(&plane, 64, 48);
  DenseMaps maps = MakeMaps(plane, scene.views[0], 1.0);
  maps.depth[48 * 128 + 64] = 0;
  RefineMaps(scene, StereoOptions(), &maps);
  ASSERT_EQ(maps.distinctness.size(), maps.depth.size());
  EXPECT_EQ(maps.distinctness[48 * 128 + 64], 0.0f);
  double sum = 0;
  for (int row = 14; row < 82; ++row) {
    for (int col = 14; col < 114; ++col) {
      sum += maps.distinctness[static_cast<size_t>(row) * 128 + col];
    }
  }
  EXPECT_GT(sum / (68 * 100), 0.03);
}

TEST(DepthRefinement, PixelsWithoutDepthOrNormalDoNoHarm) {
  TexturedPlane plane;
  const Scene scene = MakeScene(&plane, 64, 48);
  const DenseMaps truth = MakeMaps(plane, scene.views[0], 1.0);
  DenseMaps maps = truth;
  const size_t n = maps.depth.size();
  const auto is_empty = [](const size_t i) { return i % 5 == 0; };
  const auto is_without_normal = [](const size_t i) { return i % 7 == 0; };
  for (size_t i = 0; i < n; ++i) {
    if (is_empty(i)) {
      maps.depth[i] = 0;
    }
    if (is_empty(i) || is_without_normal(i)) {
      for (int axis = 0; axis < 3; ++axis) {
        maps.normal[axis * n + i] = 0;
      }
    }
  }
  RefineMaps(scene, StereoOptions(), &maps);
  int num_with_normal = 0;
  for (size_t i = 0; i < n; ++i) {
    const Eigen::Vector3f normal(
        maps.normal[i], maps.normal[n + i], maps.normal[2 * n + i]);
    if (is_empty(i)) {
      EXPECT_EQ(maps.depth[i], 0.0f);
      EXPECT_EQ(normal.norm(), 0.0f);
    } else {
      EXPECT_NEAR(maps.depth[i], truth.depth[i], 0.02 * truth.depth[i]);
      EXPECT_TRUE(normal.norm() == 0 || std::abs(normal.norm() - 1) < 1e-5);
      num_with_normal += is_without_normal(i) && normal.norm() > 0;
    }
  }
  // Matching gives most of them one.
  EXPECT_GT(num_with_normal, static_cast<int>(0.5 * n * 4 / 5 / 7));
}

}  // namespace
}  // namespace structnerf
