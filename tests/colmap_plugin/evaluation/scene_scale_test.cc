#include "colmap_plugin/evaluation/scene_scale.h"

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/input_check.h"
#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/temp_dir.h"

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// All points of the model have depth 4.
class SceneScaleTest : public testing::Test {
 protected:
  SceneScaleTest() {
    MakeTinyModel(3).WriteModel(temp_dir_ / "sparse");
    model_ = ReadModel(temp_dir_ / "sparse");
  }

  SceneScale Estimate(const std::vector<cv::Mat1f>& truths) const {
    SceneScaleEstimator estimator;
    const auto image_ids = RegisteredImageIds(model_);
    for (size_t i = 0; i < truths.size(); ++i) {
      estimator.AddImage(model_, model_.Image(image_ids[i]), truths[i]);
    }
    return estimator.Estimate();
  }

  TempDir temp_dir_;
  colmap::Reconstruction model_;
};

TEST_F(SceneScaleTest, IsTheMedianOverObservations) {
  // Of any resolution.
  const SceneScale scale = Estimate({cv::Mat1f(48, 64, 2.0f),
                                     cv::Mat1f(24, 32, 2.02f),
                                     cv::Mat1f(48, 64, 100.0f)});
  EXPECT_NEAR(scale.metres_per_unit, 0.505, 1e-6);
  // Deviations: 0.005 of the first image, 0, and 24.5 of the third.
  EXPECT_NEAR(scale.relative_spread, 1.4826 * 0.005 / 0.505, 1e-6);
  EXPECT_GT(scale.num_observations, 10);
  EXPECT_LE(scale.num_observations, 27);
}

TEST_F(SceneScaleTest, IsUnknownWithoutTruth) {
  const SceneScale scale = Estimate({cv::Mat1f(48, 64, 0.0f)});
  EXPECT_EQ(scale.num_observations, 0);
  EXPECT_EQ(scale.metres_per_unit, 0);
}

}  // namespace
}  // namespace structnerf
