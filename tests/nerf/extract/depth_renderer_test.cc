#include "nerf/extract/depth_renderer.h"

#include "tests/nerf/fake_engine.h"
#include "tests/nerf/plane_scene.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// Field coordinates of a far-away world in other units.
SceneFrame MakeFrame() {
  SceneFrame frame;
  frame.origin = Eigen::Vector3d(1e6 - 3, -2e6 - 3, -1);
  frame.scale = 0.1;
  frame.near = 1e-3;
  return frame;
}

View MakeTestView(const int width, const int height) {
  PinholeCamera camera{
      width, height, 600, 550, 0.5 * width + 1.3, 0.5 * height - 0.7};
  return MakeView("view", camera, {1e6, -2e6, 0.5}, {0.2, -0.1, 1});
}

// Depth along a ray in field coordinates where it meets a plane of the world.
float PlaneDepth(const TexturedPlane& plane,
                 const SceneFrame& frame,
                 const RayTile& rays,
                 const int ray) {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
  for (int axis = 0; axis < 3; ++axis) {
    origin[axis] = rays.origin[axis][ray];
    direction[axis] = rays.direction[axis][ray];
  }
  const Eigen::Vector3d point = frame.FieldFromWorld(plane.point);
  return static_cast<float>(plane.normal.dot(point - origin) /
                            plane.normal.dot(direction));
}

TexturedPlane MakePlane() {
  TexturedPlane plane;
  plane.point = {1e6, -2e6, 4.5};
  plane.normal = {0.4, 0.3, -1};
  return plane;
}

class DepthRendererSizes : public testing::TestWithParam<std::pair<int, int>> {
};

// Every pixel holds the depth along the ray through the image point (col, row),
// interpolated or not.
TEST_P(DepthRendererSizes, PlaneIsExactAtIntegerImagePoints) {
  const auto [width, height] = GetParam();
  const View view = MakeTestView(width, height);
  const TexturedPlane plane = MakePlane();
  const SceneFrame frame = MakeFrame();
  FakeEngine engine;
  engine.depth = [&](const RayTile& rays, const int ray) {
    return PlaneDepth(plane, frame, rays, ray);
  };
  engine.relative_std = [](const RayTile&, int) { return 0.125f; };
  Progress progress;
  const DenseMaps maps = RenderDepth(view, frame, &engine, &progress);
  ASSERT_EQ(maps.width, width);
  ASSERT_EQ(maps.height, height);
  ASSERT_EQ(maps.depth.size(), static_cast<size_t>(width) * height);
  ASSERT_EQ(maps.relative_std.size(), maps.depth.size());
  for (int row = 0; row < height; ++row) {
    for (int col = 0; col < width; ++col) {
      const double expected = plane.Depth(view, col, row);
      ASSERT_NEAR(maps.depth[row * width + col], expected, 2e-6 * expected)
          << col << " " << row;
      ASSERT_NEAR(maps.relative_std[row * width + col], 0.125, 1e-6);
    }
  }
  // Where neighbours agree about a quarter of the pixels is rendered.
  const int lattice_cols = width / 2 + 1;
  const int lattice_rows = height / 2 + 1;
  EXPECT_LE(engine.num_rendered_rays,
            static_cast<size_t>(lattice_cols) * lattice_rows);
}

INSTANTIATE_TEST_SUITE_P(Sizes,
                         DepthRendererSizes,
                         testing::Values(std::pair(1, 1),
                                         std::pair(1, 5),
                                         std::pair(5, 1),
                                         std::pair(2, 2),
                                         std::pair(2, 3),
                                         std::pair(3, 2),
                                         std::pair(4, 4),
                                         std::pair(16, 17),
                                         std::pair(33, 20),
                                         std::pair(40, 30),
                                         std::pair(51, 49)));

// A step from 2 to 3 metres between columns 20 and 21: pixels whose neighbours
// disagree are rendered, so the edge is where it belongs.
TEST(RenderDepth, EdgesAreRenderedNotInterpolated) {
  const View view = MakeView("view", MakeCamera(41, 31, 50), {0, 0, 0});
  SceneFrame frame;
  frame.scale = 0.1;
  frame.near = 1e-3;
  FakeEngine engine;
  engine.depth = [&](const RayTile& rays, const int ray) {
    const double col = 50 * rays.direction[0][ray] + 20.5;
    return col < 20.25 ? 0.2f : 0.3f;
  };
  Progress progress;
  const DenseMaps maps = RenderDepth(view, frame, &engine, &progress);
  for (int row = 0; row < 31; ++row) {
    for (int col = 0; col < 41; ++col) {
      EXPECT_NEAR(maps.depth[row * 41 + col], col <= 20 ? 2 : 3, 1e-5);
    }
  }
  // The lattice and the 31 pixels between the two columns of it.
  EXPECT_EQ(engine.num_rendered_rays, 21u * 16 + 31);
}

TEST(RenderDepth, UncertaintyIsInterpolatedToo) {
  const View view = MakeView("view", MakeCamera(9, 1, 50), {0, 0, 0});
  SceneFrame frame;
  frame.near = 1e-3;
  FakeEngine engine;
  engine.relative_std = [](const RayTile& rays, const int ray) {
    return 0.1f * (50 * rays.direction[0][ray] + 4.5f);
  };
  Progress progress;
  const DenseMaps maps = RenderDepth(view, frame, &engine, &progress);
  for (int col = 0; col < 9; ++col) {
    EXPECT_NEAR(maps.relative_std[col], 0.1 * col, 1e-4);
  }
}

// Every value differs from its neighbours: all pixels are rendered, each once.
TEST(RenderDepth, RoughScenesAreRenderedOncePerPixel) {
  const View view = MakeView("view", MakeCamera(37, 23, 50), {0, 0, 0});
  SceneFrame frame;
  frame.near = 1e-3;
  FakeEngine engine;
  engine.depth = [](const RayTile& rays, const int ray) {
    const double col = std::round(50 * rays.direction[0][ray] + 18.5);
    const double row = std::round(50 * rays.direction[1][ray] + 11.5);
    return static_cast<float>(1 + 0.1 * std::fmod(7 * col + 13 * row, 31));
  };
  Progress progress;
  const DenseMaps maps = RenderDepth(view, frame, &engine, &progress);
  EXPECT_EQ(engine.num_rendered_rays, 37u * 23);
  for (int row = 0; row < 23; ++row) {
    for (int col = 0; col < 37; ++col) {
      EXPECT_NEAR(maps.depth[row * 37 + col],
                  1 + 0.1 * std::fmod(7 * col + 13 * row, 31),
                  1e-5);
    }
  }
}

TEST(RenderDepth, TilesAreFilled) {
  const View view = MakeView("view", MakeCamera(64, 64, 50), {0, 0, 0});
  SceneFrame frame;
  frame.near = 1e-3;
  FakeEngine engine;
  Progress progress;
  RenderDepth(view, frame, &engine, &progress);
  EXPECT_EQ(engine.num_rendered_tiles,
            (engine.num_rendered_rays + kMaxTileRays - 1) / kMaxTileRays);
}

TEST(RenderDepth, AbortsWhenTold) {
  class AbortLater : public Progress {
   public:
    bool ShouldAbort() override { return ++num_asked_ > 2; }
    int num_asked_ = 0;
  };
  const View view = MakeView("view", MakeCamera(640, 480, 500), {0, 0, 0});
  SceneFrame frame;
  frame.near = 1e-3;
  FakeEngine engine;
  AbortLater progress;
  EXPECT_THROW(RenderDepth(view, frame, &engine, &progress), Aborted);
  EXPECT_LT(engine.num_rendered_rays, 640u * 480 / 4);
}

}  // namespace
}  // namespace structnerf
