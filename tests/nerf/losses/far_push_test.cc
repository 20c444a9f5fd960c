#include "nerf/losses/far_push.h"

#include "nerf/scene_frame.h"
#include "tests/nerf/plane_scene.h"

#include <cmath>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

Scene BlankScene() {
  Scene scene;
  for (const double x : {0.0, 1.0}) {
    View view = MakeView("view", MakeCamera(64, 48, 50), {x, 0, 0});
    view.image = PlainImage(64, 48, 90);
    scene.views.push_back(view);
  }
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      scene.points.push_back(MakePoint(scene, {x, y, 4}, {0, 1}));
    }
  }
  return scene;
}

// One view whose left half is blank and whose right half is a checkerboard.
Scene HalfBlankScene() {
  Scene scene = BlankScene();
  RgbImage& image = scene.views[0].image;
  for (int row = 0; row < image.height; ++row) {
    for (int col = 0; col < image.width; ++col) {
      const bool is_white = col >= image.width / 2 && (row / 2 + col / 2) % 2;
      for (int c = 0; c < 3; ++c) {
        image.data[3 * (row * image.width + col) + c] = is_white ? 255 : 90;
      }
    }
  }
  return scene;
}

TEST(MeasureBlankness, TellsBlankFromTextured) {
  const Scene scene = HalfBlankScene();
  const TrainingViews views(scene, ComputeSceneFrame(scene));
  const std::vector<uint8_t> blankness = MeasureBlankness(views, 0);
  const int width = views.image(0).width;
  const int row = views.image(0).height / 2;
  ASSERT_EQ(blankness.size(),
            static_cast<size_t>(width) * views.image(0).height);
  EXPECT_EQ(blankness[row * width + width / 4], 255);
  EXPECT_EQ(blankness[row * width + 3 * width / 4], 0);
  EXPECT_EQ(blankness[0], 255);  // the window ends at the image's border
}

TEST(MeasureBlankness, FallsWithContrast) {
  uint8_t last = 255;
  for (const int contrast : {4, 10, 20}) {
    Scene scene = BlankScene();
    RgbImage& image = scene.views[0].image;
    for (size_t i = 0; i < image.data.size(); ++i) {
      const size_t pixel = i / 3;
      const size_t stripe = pixel % image.width / 2 % 2;
      image.data[i] = static_cast<uint8_t>(100 + contrast * stripe);
    }
    const TrainingViews views(scene, ComputeSceneFrame(scene));
    const int width = views.image(0).width;
    const uint8_t blankness = MeasureBlankness(
        views, 0)[views.image(0).height / 2 * width + width / 2];
    EXPECT_LT(blankness, last);
    last = blankness;
  }
  EXPECT_GT(last, 0);
}

TEST(MeasureBlankness, LeavesMaskedPixelsOut) {
  Scene scene = HalfBlankScene();
  View& view = scene.views[0];
  view.mask.assign(static_cast<size_t>(view.image.width) * view.image.height,
                   255);
  view.mask[0] = 0;
  const TrainingViews views(scene, ComputeSceneFrame(scene));
  const std::vector<uint8_t> blankness = MeasureBlankness(views, 0);
  EXPECT_EQ(blankness[0], 0);
  // Its colour does not count for its neighbours either.
  EXPECT_EQ(blankness[1], 255);
}

TEST(EvaluateFarPush, HasTheDerivativeOfItsValue) {
  for (const double depth : {1e-3, 0.3, 40.0}) {
    float d_depth = 0;
    const float loss =
        EvaluateFarPush(200, static_cast<float>(depth), &d_depth);
    const double weight = 200.0 / 255.0;
    EXPECT_NEAR(loss, -weight * std::log(depth), 1e-5);
    const double step = 1e-6 * depth;
    const double difference =
        -weight * (std::log(depth + step) - std::log(depth - step)) /
        (2 * step);
    EXPECT_NEAR(d_depth / difference, 1, 1e-5);
  }
}

TEST(EvaluateFarPush, LeavesTexturedPixelsAlone) {
  float d_depth = 1;
  EXPECT_EQ(EvaluateFarPush(0, 2.0f, &d_depth), 0);
  EXPECT_EQ(d_depth, 0);
}

}  // namespace
}  // namespace structnerf
