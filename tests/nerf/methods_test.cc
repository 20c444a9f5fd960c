#include "nerf/methods.h"

#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

TEST(ApplyMethod, StructNerfChangesNothing) {
  const ReconstructionOptions before = QualityPreset("high");
  const ReconstructionOptions after = ApplyMethod("structnerf", before);
  EXPECT_EQ(after.loss.patch_weight, before.loss.patch_weight);
  EXPECT_EQ(after.loss.planar_weight, before.loss.planar_weight);
  EXPECT_EQ(after.loss.sparse_weight, before.loss.sparse_weight);
  EXPECT_EQ(after.loss.sparse_fraction, before.loss.sparse_fraction);
  EXPECT_EQ(after.loss.sparse_form, before.loss.sparse_form);
  EXPECT_EQ(after.stereo.num_iterations, before.stereo.num_iterations);
}

TEST(ApplyMethod, NerfHasColorOnly) {
  const ReconstructionOptions options =
      ApplyMethod("nerf", QualityPreset("medium"));
  EXPECT_GT(options.loss.color_weight, 0);
  EXPECT_EQ(options.loss.patch_weight, 0);
  EXPECT_EQ(options.loss.planar_weight, 0);
  EXPECT_EQ(options.loss.sparse_weight, 0);
  EXPECT_EQ(options.loss.prior_weight, 0);
  EXPECT_EQ(options.stereo.num_iterations, 0);
}

TEST(ApplyMethod, DsNerfNeverSwitchesSparseDepthOff) {
  const ReconstructionOptions options =
      ApplyMethod("dsnerf", QualityPreset("medium"));
  EXPECT_GT(options.loss.sparse_weight, 0);
  EXPECT_EQ(options.loss.sparse_fraction, 1);
  EXPECT_EQ(options.loss.sparse_form, "squared");
  EXPECT_EQ(options.loss.patch_weight, 0);
  EXPECT_EQ(options.loss.planar_weight, 0);
  EXPECT_EQ(options.stereo.num_iterations, 0);
}

TEST(ApplyMethod, DsNerfHasThePapersWeightAmongThePapersLosses) {
  EXPECT_EQ(ApplyMethod("dsnerf", QualityPreset("paper")).loss.sparse_weight,
            0.1);
  EXPECT_EQ(ApplyMethod("dsnerf", QualityPreset("low")).loss.sparse_weight,
            QualityPreset("low").loss.sparse_weight);
}

TEST(ApplyMethod, OthersNeedPriors) {
  const ReconstructionOptions dense =
      ApplyMethod("dense_depth_prior", QualityPreset("medium"));
  EXPECT_EQ(dense.loss.dense_prior_weight, 0.008);
  EXPECT_TRUE(dense.sampling.guide_by_prior);
  EXPECT_FALSE(dense.sampling.bound_by_prior);
  EXPECT_EQ(dense.loss.patch_weight + dense.loss.sparse_weight, 0);
  EXPECT_TRUE(dense.NeedsPrior());
  const ReconstructionOptions mvs =
      ApplyMethod("nerfing_mvs", QualityPreset("medium"));
  EXPECT_TRUE(mvs.sampling.bound_by_prior);
  EXPECT_EQ(mvs.loss.dense_prior_weight, 0);
  EXPECT_EQ(mvs.loss.patch_weight + mvs.loss.sparse_weight, 0);
  EXPECT_TRUE(mvs.NeedsPrior());
  for (const char* const method : {"structnerf", "nerf", "dsnerf"}) {
    EXPECT_FALSE(ApplyMethod(method, QualityPreset("medium")).NeedsPrior());
  }
}

// Size of the field and length of the training stay those of the quality.
TEST(ApplyMethod, WorkIsThatOfTheQuality) {
  for (const char* const method :
       {"structnerf", "nerf", "dsnerf", "dense_depth_prior", "nerfing_mvs"}) {
    for (const char* const quality : {"low", "extreme"}) {
      const ReconstructionOptions before = QualityPreset(quality);
      const ReconstructionOptions after = ApplyMethod(method, before);
      EXPECT_EQ(after.training.num_steps, before.training.num_steps);
      EXPECT_EQ(after.field.log2_table_size, before.field.log2_table_size);
      std::string error;
      EXPECT_TRUE(after.Check(&error)) << error;
    }
  }
}

TEST(ApplyMethod, OtherWordsAreRefusedWithAList) {
  try {
    ApplyMethod("NeRF", ReconstructionOptions());
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("structnerf, nerf, dsnerf, dense_depth_prior or "
                          "nerfing_mvs"));
    EXPECT_THAT(error.what(), HasSubstr("\"NeRF\""));
  }
}

}  // namespace
}  // namespace structnerf
