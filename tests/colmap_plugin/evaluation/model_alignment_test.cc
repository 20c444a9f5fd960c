#include "colmap_plugin/evaluation/model_alignment.h"

#include "tests/nerf/plane_scene.h"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

std::vector<View> MakeViews(const int num_views) {
  std::vector<View> views;
  for (int i = 0; i < num_views; ++i) {
    // On a line, which leaves a rotation open if centres were all that counts.
    views.push_back(MakeView(std::to_string(i),
                             MakeCamera(64, 48, 60),
                             {0.5 * i, 1, 2},
                             {0.1 * i, 0.2, 1}));
  }
  return views;
}

// The views seen from a world that is turned, moved and 2.5 times as large.
std::vector<View> MoveViews(const std::vector<View>& views) {
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, 2, 3).normalized())
          .toRotationMatrix();
  const Eigen::Vector3d translation(10, -20, 30);
  std::vector<View> moved = views;
  for (View& view : moved) {
    const Eigen::Vector3d center =
        2.5 * rotation * view.ProjectionCenter() + translation;
    view.cam_from_world_rotation =
        view.cam_from_world_rotation * rotation.transpose();
    view.cam_from_world_translation = -view.cam_from_world_rotation * center;
  }
  return moved;
}

TEST(AlignModelsTest, FindsTheSimilarity) {
  const std::vector<View> source = MakeViews(6);
  std::vector<View> target = MoveViews(source);
  const View unseen = target.back();
  target.pop_back();
  const ModelAlignment alignment = AlignModels(source, target);
  EXPECT_EQ(alignment.num_common_views, 5);
  EXPECT_NEAR(alignment.scale, 2.5, 1e-9);
  EXPECT_LT(alignment.relative_error, 1e-9);
  const View aligned = alignment.Apply(source.back());
  EXPECT_TRUE(aligned.cam_from_world_rotation.isApprox(
      unseen.cam_from_world_rotation, 1e-9));
  EXPECT_TRUE(aligned.cam_from_world_translation.isApprox(
      unseen.cam_from_world_translation, 1e-9));
}

TEST(AlignModelsTest, TellsHowBadlyModelsFit) {
  const std::vector<View> source = MakeViews(4);
  std::vector<View> target = MoveViews(source);
  std::swap(target[0].name, target[3].name);
  target[1].cam_from_world_translation.x() += 1;
  EXPECT_ANY_THROW({
    const ModelAlignment alignment = AlignModels(source, target);
    // Either refused, or known to be bad.
    if (alignment.relative_error > 0.3) {
      throw std::runtime_error("bad");
    }
  });
}

TEST(AlignModelsTest, NeedsTwoViewsAtDifferentPlaces) {
  const std::vector<View> views = MakeViews(3);
  EXPECT_THROW(AlignModels(views, {views[0]}), std::runtime_error);
  EXPECT_THROW(AlignModels(views, {}), std::runtime_error);
  EXPECT_NO_THROW(AlignModels(views, {views[0], views[1]}));
}

}  // namespace
}  // namespace structnerf
