#include "colmap_plugin/time_estimate.h"

#include <gtest/gtest.h>

namespace structnerf {
namespace {

const std::vector<PinholeCamera> kCameras(20,
                                          PinholeCamera{
                                              640, 480, 500, 500, 320, 240});

StructNerfOptions MakeOptions(const std::string& quality) {
  StructNerfOptions options;
  options.reconstruction = QualityPreset(quality);
  options.reconstruction.training.num_threads = 2;
  return options;
}

TEST(TimeEstimate, RisesWithQualityImagesAndSteps) {
  double last = 0;
  for (const char* quality : {"low", "medium", "high", "extreme"}) {
    const double seconds = EstimateSeconds(MakeOptions(quality), kCameras);
    EXPECT_GT(seconds, last) << quality;
    last = seconds;
  }
  EXPECT_GT(EstimateSeconds(MakeOptions("medium"), kCameras),
            EstimateSeconds(MakeOptions("medium"), {kCameras[0], kCameras[1]}));
}

TEST(TimeEstimate, ThreadsShareTheWork) {
  StructNerfOptions options = MakeOptions("medium");
  const double two = EstimateSeconds(options, kCameras);
  options.reconstruction.training.num_threads = 4;
  EXPECT_NEAR(EstimateSeconds(options, kCameras), two / 2, 1e-6 * two);
}

// Runs of this size took 24 and 74 s of two cores (README, redkitchen).
TEST(TimeEstimate, IsOfTheRightSize) {
  const std::vector<PinholeCamera> cameras(23, kCameras[0]);
  const double medium = EstimateSeconds(MakeOptions("medium"), cameras);
  EXPECT_GT(medium, 40 / 1.5);
  EXPECT_LT(medium, 40 * 1.5);
  const double high = EstimateSeconds(MakeOptions("high"), cameras);
  EXPECT_GT(high, 74 / 1.5);
  EXPECT_LT(high, 74 * 1.5);
}

}  // namespace
}  // namespace structnerf
