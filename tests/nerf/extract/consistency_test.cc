#include "nerf/extract/consistency.h"

#include "nerf/extract/map_resolution.h"
#include "tests/nerf/plane_scene.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr int kWidth = 40;
constexpr int kHeight = 30;

// Cameras side by side in front of a slanted wall, with the wall's exact depth
// in every map.
struct PlaneMaps {
  explicit PlaneMaps(const std::vector<double>& camera_xs) {
    plane.normal = {0.1, -0.2, -1};
    for (const double x : camera_xs) {
      // Different cameras, so that intrinsics cannot be mixed up.
      const int size = static_cast<int>(scene.views.size());
      AddView(MakeView("view",
                       {kWidth + 2 * size,
                        kHeight + size,
                        50.0 + size,
                        52.0 + size,
                        0.5 * kWidth + size,
                        0.5 * kHeight},
                       {x, 0.02 * x, -0.1 * x}));
    }
  }

  void AddView(const View& view) {
    scene.views.push_back(view);
    maps.push_back(plane.DepthMap(view));
  }

  float& Depth(const int view_idx, const int col, const int row) {
    return maps[view_idx].depth[row * maps[view_idx].width + col];
  }

  ViewConsistency Check(const std::vector<int>& sources) const {
    ThreadPool pool(2);
    Progress progress;
    return CheckConsistency(scene, maps, 0, sources, options, &pool, &progress);
  }

  // View indices by pixel.
  std::map<std::pair<int, int>, std::vector<int>> Find(
      const std::vector<int>& sources) const {
    std::map<std::pair<int, int>, std::vector<int>> found;
    const std::vector<int> graph = Check(sources).graph;
    for (auto record = graph.begin(); record != graph.end();) {
      const auto view_idxs = record + 3;
      const auto end = view_idxs + record[2];
      found[{record[0], record[1]}] = std::vector<int>(view_idxs, end);
      record = end;
    }
    return found;
  }

  TexturedPlane plane;
  Scene scene;
  std::vector<DenseMaps> maps;
  ExtractionOptions options = AnyAngle();

 private:
  static ExtractionOptions AnyAngle() {
    ExtractionOptions options;
    options.min_triangulation_angle = 0;
    return options;
  }
};

TEST(ReplaceUnconfirmed, TakesWhatIsNotConfirmedFromTheOtherMaps) {
  DenseMaps maps;
  maps.depth = {1, 2, 0, 4};
  maps.normal = {.1f, .2f, 0, .4f, .5f, .6f, 0, .8f, -1, -1, 0, -1};
  DenseMaps other;
  other.depth = {10, 20, 30, 40};
  other.normal.assign(12, 0.5f);
  ReplaceUnconfirmed({1, 0, 0, 1}, other, &maps);
  EXPECT_THAT(maps.depth, ElementsAre(1, 20, 0, 4));
  EXPECT_THAT(maps.normal,
              ElementsAre(.1f, .5f, 0, .4f, .5f, .5f, 0, .8f, -1, .5f, 0, -1));
}

TEST(CheckConsistency, ViewsOfAPlaneConfirmEachOther) {
  PlaneMaps test({0, 0.5, -0.4});
  test.options.min_num_consistent = 1;
  // Rounding to the nearest pixel of the other view moves a slanted plane a
  // little.
  test.options.max_relative_depth_error = 0.01;
  const auto found = test.Find({1, 2});
  int num_seen = 0;
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 0; col < kWidth; ++col) {
      const View& view = test.scene.views[0];
      const double depth = test.plane.Depth(view, col, row);
      const Eigen::Vector3d in_world = Unproject(view, col, row, depth);
      std::vector<int> expected;
      bool is_at_border = false;
      for (const int source : {1, 2}) {
        const Eigen::Vector3d pixel =
            Project(test.scene.views[source], in_world);
        // Pixels are centred at integers here.
        const double right = test.maps[source].width - 0.5 - pixel.x();
        const double bottom = test.maps[source].height - 0.5 - pixel.y();
        const double inside = std::min(std::min(pixel.x() + 0.5, right),
                                       std::min(pixel.y() + 0.5, bottom));
        is_at_border |= std::abs(inside) < 1e-3;
        if (inside > 0) {
          expected.push_back(source);
        }
      }
      if (is_at_border) {
        continue;
      }
      const auto record = found.find({col, row});
      EXPECT_EQ(record != found.end() ? record->second : std::vector<int>(),
                expected)
          << col << " " << row;
      num_seen += expected.size() == 2;
    }
  }
  EXPECT_GT(num_seen, kWidth * kHeight / 2);
}

TEST(CheckConsistency, AsManyViewsAsAskedFor) {
  PlaneMaps test({0, 0.1, -0.1, 0.2});
  const std::pair<int, int> middle(20, 15);
  for (int min_num_consistent = 1; min_num_consistent <= 3;
       ++min_num_consistent) {
    test.options.min_num_consistent = min_num_consistent;
    // Listed in any order, recorded in ascending order.
    EXPECT_THAT(test.Find({3, 1, 2})[middle], ElementsAre(1, 2, 3));
  }
  test.options.min_num_consistent = 4;
  EXPECT_THAT(test.Find({3, 1, 2}), IsEmpty());
  test.options.min_num_consistent = 2;
  EXPECT_THAT(test.Find({1}), IsEmpty());
  EXPECT_THAT(test.Find({}), IsEmpty());
  // Only the views that were asked.
  EXPECT_THAT(test.Find({1, 3})[middle], ElementsAre(1, 3));
}

TEST(CheckConsistency, TheGraphHasTheConfirmedPixelsRowByRow) {
  PlaneMaps test({0, 0.1, -0.1});
  const ViewConsistency consistency = test.Check({1, 2});
  std::vector<uint8_t> is_in_graph(kWidth * kHeight, 0);
  int last_pixel = -1;
  for (size_t i = 0; i < consistency.graph.size();
       i += 3 + consistency.graph[i + 2]) {
    const int pixel = consistency.graph[i + 1] * kWidth + consistency.graph[i];
    EXPECT_LT(last_pixel, pixel);
    is_in_graph[pixel] = 1;
    last_pixel = pixel;
  }
  EXPECT_EQ(consistency.is_confirmed, is_in_graph);
  EXPECT_GT(std::count(is_in_graph.begin(), is_in_graph.end(), 1), 100);
}

TEST(CheckConsistency, OutliersAndHolesAreNotConfirmed) {
  PlaneMaps test({0, 0.1, -0.1});
  test.Depth(0, 20, 15) *= 1.1f;
  test.Depth(0, 21, 15) *= 0.9f;
  test.Depth(0, 22, 15) = 0;
  const auto found = test.Find({1, 2});
  EXPECT_EQ(found.count({20, 15}), 0u);
  EXPECT_EQ(found.count({21, 15}), 0u);
  EXPECT_EQ(found.count({22, 15}), 0u);
  EXPECT_EQ(found.count({23, 15}), 1u);
}

TEST(CheckConsistency, OccludedPixelsAreNotConfirmed) {
  PlaneMaps test({0, 0.1, -0.1});
  // Something stands in front of half of view 1; view 2 has no depth there.
  for (int row = 0; row < test.maps[1].height; ++row) {
    for (int col = 0; col < 20; ++col) {
      test.Depth(1, col, row) = 1.0f;
      test.Depth(2, col, row) = 0.0f;
    }
  }
  test.options.min_num_consistent = 1;
  const auto found = test.Find({1, 2});
  EXPECT_EQ(found.count({8, 15}), 0u);
  EXPECT_THAT(found.at({32, 15}), ElementsAre(1, 2));
}

TEST(CheckConsistency, PointsBehindASourceAreNotConfirmed) {
  PlaneMaps test({0, 0.1});
  // Behind the wall, looking on; its map holds the negative of the truth.
  test.AddView(MakeView("behind", test.scene.views[0].camera, {0, 0, 8}));
  for (float& depth : test.maps[2].depth) {
    ASSERT_LT(depth, 0);
    depth = -depth;
  }
  test.options.min_num_consistent = 1;
  const auto found = test.Find({1, 2});
  EXPECT_FALSE(found.empty());
  for (const auto& [pixel, view_idxs] : found) {
    EXPECT_THAT(view_idxs, ElementsAre(1));
  }
}

TEST(CheckConsistency, DepthErrorLimit) {
  PlaneMaps test({0, 0.1});
  test.plane.normal = {0, 0, -1};
  test.options.min_num_consistent = 1;
  test.options.max_relative_depth_error = 0.05;
  test.options.max_reprojection_error = 100;
  // A frontal wall at 4 m, so that nothing but the scaling differs.
  Scene scene;
  scene.views = {MakeView("a", MakeCamera(kWidth, kHeight, 50), {0, 0, 0}),
                 MakeView("b", MakeCamera(kWidth, kHeight, 50), {0.1, 0, 0})};
  test.scene = scene;
  for (const float ratio : {0.945f, 0.955f, 1.0f, 1.045f, 1.055f}) {
    for (int v = 0; v < 2; ++v) {
      test.maps[v].width = kWidth;
      test.maps[v].height = kHeight;
      test.maps[v].depth.assign(kWidth * kHeight, v == 0 ? 4.0f : 4 * ratio);
    }
    EXPECT_EQ(test.Find({1}).count({20, 15}),
              std::abs(ratio - 1) < 0.05f ? 1u : 0u)
        << ratio;
  }
}

TEST(CheckConsistency, ReprojectionErrorLimit) {
  PlaneMaps test({0, 0.1});
  Scene scene;
  // A wide baseline: 1 % of depth is 50 * 2 / 4 * 0.01 = 0.25 pixels.
  scene.views = {
      MakeView("a", MakeCamera(kWidth, kHeight, 50), {0, 0, 0}),
      MakeView("b", MakeCamera(kWidth, kHeight, 50), {2, 0, 0}, {-0.5, 0, 1})};
  test.scene = scene;
  test.plane.normal = {0, 0, -1};
  test.options.min_num_consistent = 1;
  test.options.max_relative_depth_error = 0.02;
  test.maps.clear();
  test.scene.views.clear();
  for (const View& view : scene.views) {
    test.AddView(view);
  }
  for (float& depth : test.maps[1].depth) {
    depth *= 1.01f;
  }
  test.options.max_reprojection_error = 1.0;
  EXPECT_EQ(test.Find({1}).count({20, 15}), 1u);
  test.options.max_reprojection_error = 0.1;
  EXPECT_EQ(test.Find({1}).count({20, 15}), 0u);
}

// What view 0 sees at pixel (20, 15).
Eigen::Vector3d PointAtMiddle(const PlaneMaps& test) {
  const View& view = test.scene.views[0];
  return view.WorldFromCam(test.plane.Depth(view, 20, 15) *
                           view.camera.CalibrationMatrix().inverse() *
                           Eigen::Vector3d(20, 15, 1));
}

// Between the rays of view 0 and of a source to that point, in degrees.
double AngleAtMiddle(const PlaneMaps& test, const int source) {
  const Eigen::Vector3d point = PointAtMiddle(test);
  const Eigen::Vector3d ray1 = point - test.scene.views[0].ProjectionCenter();
  const Eigen::Vector3d ray2 =
      point - test.scene.views[source].ProjectionCenter();
  return std::acos(ray1.normalized().dot(ray2.normalized())) * 180 / M_PI;
}

TEST(CheckConsistency, AnglesAreThoseOfTheWidestConfirmation) {
  PlaneMaps test({0, 0.1, -0.3});
  const size_t middle = 15 * kWidth + 20;
  EXPECT_NEAR(test.Check({1}).angles[middle], AngleAtMiddle(test, 1), 1e-4);
  EXPECT_NEAR(test.Check({1, 2}).angles[middle], AngleAtMiddle(test, 2), 1e-4);
  // A view that does not confirm does not count.
  for (float& depth : test.maps[2].depth) {
    depth *= 1.1f;
  }
  EXPECT_NEAR(test.Check({1, 2}).angles[middle], AngleAtMiddle(test, 1), 1e-4);
  EXPECT_EQ(test.Check({2}).angles[middle], 0);
}

TEST(CheckConsistency, OneConfirmationMustBeWideEnough) {
  PlaneMaps test({0, 0.1, -0.3});
  const std::pair<int, int> middle(20, 15);
  test.options.min_triangulation_angle = AngleAtMiddle(test, 2) - 0.01;
  EXPECT_THAT(test.Find({1, 2})[middle], ElementsAre(1, 2));
  test.options.min_triangulation_angle = AngleAtMiddle(test, 2) + 0.01;
  EXPECT_EQ(test.Find({1, 2}).count(middle), 0);
}

TEST(CheckConsistency, TheLimitInPixelsIsForMapsOfTheReferenceSize) {
  for (const int width : {kReferenceMapSize, 2 * kReferenceMapSize}) {
    PlaneMaps test({});
    test.options.min_num_consistent = 1;
    test.options.max_reprojection_error = 2;
    for (const double x : {0.0, 0.5}) {
      test.AddView(MakeView("view", MakeCamera(width, 4, 1600), {x, 0, 0}));
    }
    // Pixels come back about three pixels away.
    const int col = width / 2;
    const double depth = test.plane.Depth(test.scene.views[0], col, 2);
    for (float& source_depth : test.maps[1].depth) {
      source_depth *= static_cast<float>(1 + 3 * depth / (1600 * 0.5));
    }
    EXPECT_EQ(test.Find({1}).count({col, 2}) == 1, width > kReferenceMapSize)
        << width;
  }
}

TEST(FitToScene, AsksForNoMoreThanTheSceneOffers) {
  PlaneMaps test({0, 0.1, -0.3});
  test.options.min_triangulation_angle = 4;
  test.options.min_num_consistent = 3;
  SparsePoint point;
  point.xyz = PointAtMiddle(test);
  // Points that were found once say nothing about angles.
  point.track = {{0, {20, 15}}};
  test.scene.points.assign(5, point);
  EXPECT_EQ(FitToScene(test.options, test.scene, 3).min_triangulation_angle, 4);
  point.track = {{0, {20, 15}}, {1, {20, 15}}};
  test.scene.points.push_back(point);
  const ExtractionOptions fitted = FitToScene(test.options, test.scene, 3);
  EXPECT_NEAR(
      fitted.min_triangulation_angle, 0.5 * AngleAtMiddle(test, 1), 1e-6);
  EXPECT_EQ(fitted.min_num_consistent, 2);
  // A view that is held out confirms none.
  EXPECT_EQ(FitToScene(test.options, test.scene, 2).min_num_consistent, 1);
}

}  // namespace
}  // namespace structnerf
