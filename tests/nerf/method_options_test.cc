#include "nerf/method_options.h"

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(ChangePreset, KeepsWhatWasChanged) {
  const ReconstructionOptions low = QualityPreset("low");
  const ReconstructionOptions high = QualityPreset("high");
  ReconstructionOptions options = low;
  options.training.num_steps = 7;
  options.loss.sparse_form = "kl";
  options.stereo.complete_planes = false;
  options = ChangePreset(options, low, high);
  EXPECT_EQ(options.training.num_steps, 7);
  EXPECT_EQ(options.loss.sparse_form, "kl");
  EXPECT_FALSE(options.stereo.complete_planes);
  EXPECT_EQ(options.training.max_image_size, high.training.max_image_size);
  EXPECT_EQ(options.stereo.num_iterations, high.stereo.num_iterations);
  // Back to where it was.
  options = ChangePreset(options, high, low);
  EXPECT_EQ(options.training.num_steps, 7);
  EXPECT_EQ(options.training.max_image_size, low.training.max_image_size);
  EXPECT_EQ(options.stereo.num_iterations, low.stereo.num_iterations);
}

}  // namespace
}  // namespace structnerf
