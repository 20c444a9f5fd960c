#include "nerf/extract/preview_renderer.h"

#include "tests/nerf/fake_engine.h"
#include "tests/nerf/plane_scene.h"

#include <chrono>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// Watches one view.
class WatchingProgress : public Progress {
 public:
  int PreviewViewIdx() override { return view_idx; }
  void ShowPreview(const Preview& preview) override {
    previews.push_back(preview);
  }

  int view_idx = -1;
  std::vector<Preview> previews;
};

class PreviewRendererTest : public testing::Test {
 protected:
  PreviewRendererTest() {
    plane_.normal = {0.4, 0.3, -1};
    for (int v = 0; v < 2; ++v) {
      scene_.views.push_back(
          MakeView("view", MakeCamera(640, 480, 500), {0.2 * v, 0, 0}));
      plane_.Photograph(320, 240, &scene_.views.back());
    }
    frame_.origin = {-3, -3, -1};
    frame_.scale = 0.1;
    frame_.near = 1e-3;
    views_ = std::make_unique<TrainingViews>(scene_, frame_);
    // Where the ray meets the plane, in field coordinates.
    const Eigen::Vector3d point = frame_.FieldFromWorld(plane_.point);
    engine_.depth = [this, point](const RayTile& rays, const int ray) {
      Eigen::Vector3d origin;
      Eigen::Vector3d direction;
      for (int axis = 0; axis < 3; ++axis) {
        origin[axis] = rays.origin[axis][ray];
        direction[axis] = rays.direction[axis][ray];
      }
      return static_cast<float>(plane_.normal.dot(point - origin) /
                                plane_.normal.dot(direction));
    };
    engine_.color = {1.0f, 0.5f, -0.1f};
    previews_ = std::make_unique<PreviewRenderer>(
        scene_,
        frame_,
        *views_,
        std::vector<Appearance>{{4, 4}, {5, 6}},
        &engine_);
  }

  TexturedPlane plane_;
  Scene scene_;
  SceneFrame frame_;
  std::unique_ptr<TrainingViews> views_;
  FakeEngine engine_;
  std::unique_ptr<PreviewRenderer> previews_;
  WatchingProgress progress_;
};

TEST_F(PreviewRendererTest, ShowsWhatTheFieldRenders) {
  const Preview preview = previews_->Render(1);
  EXPECT_EQ(preview.view_idx, 1);
  ASSERT_EQ(preview.width, 160);
  ASSERT_EQ(preview.height, 120);
  const View& view = scene_.views[1];
  const Eigen::Vector3d normal = plane_.NormalInView(view);
  const size_t num_pixels = 160 * 120;
  for (const int row : {0, 50, 119}) {
    for (const int col : {0, 77, 159}) {
      const size_t i = row * 160 + col;
      EXPECT_NEAR(preview.depth[i],
                  plane_.Depth(view, 4 * (col + 0.5), 4 * (row + 0.5)),
                  1e-3);
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(preview.normal[axis * num_pixels + i], normal[axis], 0.01);
      }
      EXPECT_EQ(preview.color[3 * i], 255);
      EXPECT_NEAR(preview.color[3 * i + 1], 128, 1);
      EXPECT_EQ(preview.color[3 * i + 2], 0);
      EXPECT_EQ(preview.photograph[3 * i],
                view.image.data[3 * (2 * row * 320 + 2 * col)]);
    }
  }
}

TEST_F(PreviewRendererTest, ShowsColorsWithTheLatentCodesOfTheView) {
  engine_.depth = [](const RayTile& rays, const int ray) {
    EXPECT_EQ(rays.appearance[0][ray], 5);
    EXPECT_EQ(rays.appearance[1][ray], 6);
    return 0.5f;
  };
  EXPECT_FALSE(previews_->Render(1).color.empty());
}

TEST_F(PreviewRendererTest, ShowsColorsAsThePhotographIsExposed) {
  scene_.views[1].exposure.gain = {0.5f, 0.5f, 1};
  scene_.views[1].exposure.offset = {0.25f, 0, 2};
  const Preview preview = previews_->Render(1);
  EXPECT_NEAR(preview.color[0], 191, 1);
  EXPECT_NEAR(preview.color[1], 64, 1);
  EXPECT_EQ(preview.color[2], 255);
}

TEST_F(PreviewRendererTest, SmallPhotographsKeepTheirSize) {
  for (View& view : scene_.views) {
    view.image = PlainImage(15, 40, 77);
  }
  const TrainingViews views(scene_, frame_);
  const Preview preview =
      PreviewRenderer(
          scene_, frame_, views, {kNoAppearance, kNoAppearance}, &engine_)
          .Render(0);
  EXPECT_EQ(preview.width, 15);
  EXPECT_EQ(preview.height, 40);
  EXPECT_EQ(preview.photograph, std::vector<uint8_t>(3 * 15 * 40, 77));
}

TEST_F(PreviewRendererTest, CostsNothingWhenNobodyWatches) {
  previews_->RenderIfWanted(1, &progress_);
  progress_.view_idx = 2;  // no such view
  previews_->RenderIfWanted(2, &progress_);
  EXPECT_EQ(engine_.num_rendered_rays, 0u);
  EXPECT_TRUE(progress_.previews.empty());
}

TEST_F(PreviewRendererTest, TakesOnlyAShareOfTheTraining) {
  progress_.view_idx = 0;
  previews_->RenderIfWanted(0, &progress_);
  EXPECT_EQ(progress_.previews.size(), 1u);
  previews_->RenderIfWanted(0, &progress_);
  previews_->RenderIfWanted(1e-6, &progress_);
  EXPECT_EQ(progress_.previews.size(), 1u);
  previews_->RenderIfWanted(1e6, &progress_);
  EXPECT_EQ(progress_.previews.size(), 2u);
}

TEST_F(PreviewRendererTest, AWatchedTrainingTakesAtMostFivePercentLonger) {
  using Clock = std::chrono::steady_clock;
  constexpr double kStepSeconds = 0.01;
  progress_.view_idx = 0;
  double training_seconds = 0;
  double preview_seconds = 0;
  for (int step = 0; step < 2000; ++step) {
    const auto begin = Clock::now();
    previews_->RenderIfWanted(training_seconds + preview_seconds, &progress_);
    preview_seconds +=
        std::chrono::duration<double>(Clock::now() - begin).count();
    training_seconds += kStepSeconds;
  }
  EXPECT_GT(progress_.previews.size(), 2u);
  EXPECT_LT(preview_seconds, 0.05 * training_seconds);
}

}  // namespace
}  // namespace structnerf
