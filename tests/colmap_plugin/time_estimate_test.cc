#include "colmap_plugin/time_estimate.h"

#include <string>
#include <utility>
#include <vector>

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
  const std::vector<PinholeCamera> large_cameras(
      20, PinholeCamera{1600, 1200, 1250, 1250, 800, 600});
  for (const char* quality : {"low", "medium", "high", "extreme"}) {
    const double seconds =
        EstimateTime(MakeOptions(quality), large_cameras).Total();
    EXPECT_GT(seconds, last) << quality;
    last = seconds;
  }
  const StructNerfOptions medium = MakeOptions("medium");
  EXPECT_GT(EstimateTime(medium, kCameras).Total(),
            EstimateTime(medium, {kCameras[0], kCameras[1]}).Total());
}

TEST(TimeEstimate, ThreadsShareTheWork) {
  StructNerfOptions options = MakeOptions("medium");
  const double two = EstimateTime(options, kCameras).training;
  options.reconstruction.training.num_threads = 4;
  EXPECT_NEAR(EstimateTime(options, kCameras).training, two / 2, 1e-6 * two);
}

// Runs of this size took 39 and 51 s (README, redkitchen) on a machine that is
// 1.5 times as fast as the one of the rates.
TEST(TimeEstimate, IsOfTheRightSize) {
  const std::vector<PinholeCamera> cameras(23, kCameras[0]);
  const double medium = EstimateTime(MakeOptions("medium"), cameras).Total();
  EXPECT_GT(medium, 58 / 1.3);
  EXPECT_LT(medium, 58 * 1.3);
  const double high = EstimateTime(MakeOptions("high"), cameras).Total();
  EXPECT_GT(high, 76 / 1.3);
  EXPECT_LT(high, 76 * 1.3);
}

void ExpectChoice(const double minutes,
                  const std::string& quality,
                  const int num_sweeps) {
  SCOPED_TRACE(minutes);
  StructNerfOptions options = MakeOptions("medium");
  options.max_minutes = minutes;
  const QualityChoice choice = QualityForTime(options, kCameras, 1);
  EXPECT_EQ(choice.quality, quality);
  EXPECT_EQ(choice.num_sweeps, num_sweeps);
}

TEST(QualityForTime, TakesTheBestThatFits) {
  for (const auto& [minutes, quality] : {std::pair(0.35, "low"),
                                         std::pair(0.8, "medium"),
                                         std::pair(1000.0, "high")}) {
    ExpectChoice(
        minutes, quality, QualityPreset(quality).stereo.num_iterations);
  }
}

TEST(QualityForTime, SpendsMoreOnLargePhotographs) {
  StructNerfOptions options = MakeOptions("medium");
  options.max_minutes = 1000;
  std::vector<PinholeCamera> cameras = kCameras;
  cameras.back() = cameras.back().Resized(1600, 1200);
  EXPECT_EQ(QualityForTime(options, cameras, 1).quality, "extreme");
}

TEST(QualityForTime, SavesSweepsBeforeItTakesALowerQuality) {
  ExpectChoice(0.6, "medium", 1);
  // But nothing of the kind where there is no matching.
  StructNerfOptions options = MakeOptions("medium");
  options.max_minutes = 0.6;
  options.method = "nerf";
  EXPECT_EQ(QualityForTime(options, kCameras, 1).num_sweeps, 0);
}

TEST(QualityForTime, DoesNotMatchIfThereIsNoTime) {
  ExpectChoice(0.01, "low", 0);
}

TEST(QualityForTime, NeedsMoreTimeOnASlowMachine) {
  StructNerfOptions options = MakeOptions("medium");
  options.max_minutes = 1;
  EXPECT_EQ(QualityForTime(options, kCameras, 4).quality, "low");
}

TEST(QualityForTime, NeedsMoreTimeForMoreImages) {
  StructNerfOptions options = MakeOptions("medium");
  options.max_minutes = 1;
  const std::vector<PinholeCamera> many(200, kCameras[0]);
  EXPECT_EQ(QualityForTime(options, many, 1).quality, "low");
}

}  // namespace
}  // namespace structnerf
