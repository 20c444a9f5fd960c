#include "colmap_plugin/exposure_fit.h"

#include "tests/nerf/plane_scene.h"
#include "tests/support/synthetic_room.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

SyntheticRoomOptions RoomOptions() {
  SyntheticRoomOptions options;
  options.num_views = 8;
  options.exposure_sigma = 0;
  return options;
}

uint8_t ExposedByte(const double value,
                    const double gain,
                    const double offset) {
  return static_cast<uint8_t>(
      std::lround(255 * std::clamp(gain * value / 255 + offset, 0.0, 1.0)));
}

// Exposes a view as told.
void Expose(const Exposure& exposure, View* view) {
  for (size_t i = 0; i < view->image.data.size(); ++i) {
    view->image.data[i] = ExposedByte(
        view->image.data[i], exposure.gain[i % 3], exposure.offset[i % 3]);
  }
}

TEST(ExposureFit, FindsTheExposuresOfARoom) {
  Scene scene = MakeScene(MakeSyntheticRoom(RoomOptions()));
  std::vector<Exposure> exposures(scene.views.size());
  for (size_t v = 0; v < scene.views.size(); ++v) {
    const float log_gain = 0.05f * (static_cast<float>(v) - 3.5f);
    exposures[v].gain = {
        std::exp(log_gain), std::exp(-log_gain), std::exp(0.5f * log_gain)};
    exposures[v].offset.setConstant(v % 2 == 0 ? 0.02f : -0.02f);
    Expose(exposures[v], &scene.views[v]);
  }
  const ExposureFit fit = FitExposures(scene);
  ASSERT_EQ(fit.exposures.size(), scene.views.size());
  for (size_t v = 0; v < scene.views.size(); ++v) {
    for (int c = 0; c < 3; ++c) {
      // What they make of the colours of a room.
      for (const float color : {0.3f, 0.6f}) {
        const float expected =
            exposures[v].gain[c] * color + exposures[v].offset[c];
        EXPECT_NEAR(
            fit.exposures[v].gain[c] * color + fit.exposures[v].offset[c],
            expected,
            0.02)
            << v << " " << c;
      }
    }
  }
  EXPECT_TRUE(fit.IsSignificant());
  EXPECT_LT(fit.residual, 0.7 * fit.residual_before);
}

TEST(ExposureFit, TheMeanExposureIsNone) {
  Scene scene = MakeScene(MakeSyntheticRoom(RoomOptions()));
  for (View& view : scene.views) {
    Expose({Eigen::Vector3f::Constant(0.7f), Eigen::Vector3f::Constant(0.1f)},
           &view);
  }
  Eigen::Vector3f log_gain = Eigen::Vector3f::Zero();
  Eigen::Vector3f offset = Eigen::Vector3f::Zero();
  for (const Exposure& exposure : FitExposures(scene).exposures) {
    log_gain += exposure.gain.array().log().matrix();
    offset += exposure.offset;
  }
  EXPECT_LT(log_gain.norm(), 1e-4);
  EXPECT_LT(offset.norm(), 1e-4);
}

TEST(ExposureFit, EqualExposuresAreNotSignificant) {
  const Scene scene = MakeScene(MakeSyntheticRoom(RoomOptions()));
  const ExposureFit fit = FitExposures(scene);
  EXPECT_LT(fit.variation, 0.01);
  EXPECT_FALSE(fit.IsSignificant());
}

TEST(ExposureFit, RepeatsItself) {
  SyntheticRoomOptions options = RoomOptions();
  options.exposure_sigma = 0.2;
  const Scene scene = MakeScene(MakeSyntheticRoom(options));
  const ExposureFit first = FitExposures(scene);
  const ExposureFit second = FitExposures(scene);
  for (size_t v = 0; v < scene.views.size(); ++v) {
    EXPECT_EQ(first.exposures[v].gain, second.exposures[v].gain);
    EXPECT_EQ(first.exposures[v].offset, second.exposures[v].offset);
  }
}

TEST(ExposureFit, WithoutColorsAllAreEqual) {
  Scene scene = MakeScene(MakeSyntheticRoom(RoomOptions()));
  scene.views[0].image = PlainImage(320, 240, 255);  // saturated
  scene.views[1].mask.assign(320 * 240, 0);
  for (const size_t v : {0, 1}) {
    const Exposure exposure = FitExposures(scene).exposures[v];
    EXPECT_NEAR(exposure.gain.x(), 1, 0.05) << v;
    EXPECT_NEAR(exposure.offset.x(), 0, 0.05) << v;
  }
  scene.points.clear();
  const ExposureFit fit = FitExposures(scene);
  EXPECT_EQ(fit.variation, 0);
  EXPECT_EQ(fit.exposures[3].gain, Eigen::Vector3f::Ones());
}

TEST(ChooseExposures, DoesAsToldAndSaysWhy) {
  SyntheticRoomOptions options = RoomOptions();
  const Scene even = MakeScene(MakeSyntheticRoom(options));
  options.fault = RoomFault::kExposureJump;
  const Scene uneven = MakeScene(MakeSyntheticRoom(options));
  const auto is_exposed = [](const Scene& scene, const std::string& option) {
    Scene chosen = scene;
    const SceneDecision decision = ChooseExposures(option, &chosen);
    const bool is_equal =
        chosen.views.back().exposure.gain == Eigen::Vector3f::Ones();
    EXPECT_THAT(decision.choice,
                HasSubstr(is_equal ? "equal for all" : "gain and offset"));
    EXPECT_THAT(
        decision.reason,
        HasSubstr(option == "none" ? "not asked for" : "images differ by"));
    return !is_equal;
  };
  EXPECT_FALSE(is_exposed(even, "auto"));
  EXPECT_TRUE(is_exposed(even, "affine"));
  EXPECT_TRUE(is_exposed(uneven, "auto"));
  EXPECT_FALSE(is_exposed(uneven, "none"));
}

}  // namespace
}  // namespace structnerf
