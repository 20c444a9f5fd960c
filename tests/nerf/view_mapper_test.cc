#include "nerf/view_mapper.h"

#include "nerf/scene_frame.h"
#include "tests/nerf/fake_engine.h"
#include "tests/nerf/plane_scene.h"

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// Asked to stop after so many times.
class StoppingProgress : public Progress {
 public:
  bool ShouldStop() override { return num_left-- <= 0; }
  void Report(const ProgressUpdate& update) override {
    EXPECT_EQ(update.stage, "Matching views");
    EXPECT_GE(update.fraction, fraction);
    fraction = update.fraction;
  }

  int num_left = std::numeric_limits<int>::max();
  double fraction = 0;
};

// Four photographs, of half the camera's size, of a wall 4 units away, and an
// engine that has it 1 % too near.
class ViewMapperTest : public testing::Test {
 protected:
  ViewMapperTest() {
    for (int v = 0; v < 4; ++v) {
      View view = MakeView("view" + std::to_string(v),
                           MakeCamera(128, 96, 100),
                           {0.4 * (v % 2), 0.4 * (v / 2), 0});
      wall_.Photograph(64, 48, &view);
      scene_.views.push_back(view);
    }
    for (const double x : {-0.5, 0.1, 0.6}) {
      scene_.points.push_back(MakePoint(scene_, {x, 0.2, 4}, {0, 1, 2, 3}));
    }
    frame_ = ComputeSceneFrame(scene_);
    views_ = std::make_unique<TrainingViews>(scene_, frame_);
    options_.stereo.num_iterations = 4;
    const float depth = static_cast<float>(0.99 * 4 * frame_.scale);
    engine_.depth = [depth](const RayTile&, int) { return depth; };
  }

  std::shared_ptr<const MatchedDepth> Match(const std::vector<int>& view_idxs) {
    const ViewMapper mapper(
        scene_, frame_, *views_, sources_, options_, &engine_, &pool_);
    return mapper.Match(view_idxs, &progress_);
  }

  TexturedPlane wall_;
  Scene scene_;
  SceneFrame frame_;
  std::unique_ptr<TrainingViews> views_;
  std::vector<std::vector<int>> sources_ = {
      {1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}};
  ReconstructionOptions options_;
  FakeEngine engine_;
  ThreadPool pool_{2};
  StoppingProgress progress_;
};

TEST_F(ViewMapperTest, MatchesAtTheSizeOfTheTrainingImages) {
  const auto depth = Match({0, 1, 2, 3});
  ASSERT_NE(depth, nullptr);
  EXPECT_EQ(progress_.fraction, 1);
  const double truth = 4 * frame_.scale;
  for (const std::vector<float>& view : *depth) {
    ASSERT_EQ(view.size(), 64u * 48u);
    int num_right = 0;
    for (const float value : view) {
      num_right += std::abs(value / truth - 1) < 0.003;
    }
    EXPECT_GT(num_right, 0.6 * 64 * 48);
  }
  EXPECT_GT(ConfirmedShare(*depth), 0.6);
}

TEST_F(ViewMapperTest, KeepsOnlyWhatOthersConfirm) {
  // Nobody agrees with the last view, which is twice as far away.
  scene_.views[3].cam_from_world_translation.z() += 4;
  const auto depth = Match({0, 1, 2, 3});
  ASSERT_NE(depth, nullptr);
  EXPECT_LT(ConfirmedShare({(*depth)[3]}), 0.01);
  EXPECT_GT(ConfirmedShare({(*depth)[0]}), 0.3);
}

// As in training, where nothing in front of the bounds is learned.
TEST_F(ViewMapperTest, RaysStayWithinTheirBounds) {
  for (View& view : scene_.views) {
    view.near_depth.assign(64 * 48, 3);
    view.far_depth.assign(64 * 48, 5);
  }
  size_t num_rays = 0;
  engine_.depth = [&](const RayTile& rays, const int ray) {
    EXPECT_NEAR(rays.near[ray], 3 * frame_.scale, 1e-5);
    EXPECT_NEAR(rays.far[ray], 5 * frame_.scale, 1e-5);
    ++num_rays;
    return static_cast<float>(4 * frame_.scale);
  };
  EXPECT_NE(Match({0, 1, 2, 3}), nullptr);
  EXPECT_GT(num_rays, 0u);
}

TEST_F(ViewMapperTest, ViewsThatAreNotAskedForHaveNoSay) {
  sources_ = {{1, 2}, {0, 2}, {0, 1}, {0, 1, 2}};
  const auto depth = Match({0, 1, 2});
  ASSERT_NE(depth, nullptr);
  EXPECT_TRUE((*depth)[3].empty());
  EXPECT_GT(ConfirmedShare(*depth), 0.5);
}

TEST_F(ViewMapperTest, EndsWhenAskedTo) {
  progress_.num_left = 2;
  EXPECT_EQ(Match({0, 1, 2, 3}), nullptr);
  EXPECT_EQ(progress_.fraction, 0.5);
}

TEST_F(ViewMapperTest, MapsHaveTheSizeOfTheCamera) {
  const ViewMapper mapper(
      scene_, frame_, *views_, sources_, options_, &engine_, &pool_);
  DenseMaps field;
  const DenseMaps maps = mapper.MakeMaps(0, &progress_, &field);
  EXPECT_EQ(maps.width, 128);
  EXPECT_EQ(maps.height, 96);
  const size_t center = 48 * 128 + 64;
  EXPECT_NEAR(field.depth[center], 0.99 * 4, 1e-4);
  EXPECT_NEAR(maps.depth[center], 4, 0.01);
}

}  // namespace
}  // namespace structnerf
