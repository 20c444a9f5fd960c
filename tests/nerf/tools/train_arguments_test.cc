#include "nerf/tools/train_arguments.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

std::vector<std::string> WithPaths(const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {
      "--scene_path", "scene.bin", "--output_path=maps"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

void ExpectError(const std::vector<std::string>& arguments,
                 const std::string& message) {
  EXPECT_THAT([&]() { ParseTrainArguments(arguments); },
              ThrowsMessage<std::invalid_argument>(HasSubstr(message)));
}

TEST(TrainArguments, DefaultsAreThoseOfTheCommand) {
  const TrainArguments arguments = ParseTrainArguments(WithPaths({}));
  EXPECT_EQ(arguments.scene_path, "scene.bin");
  EXPECT_EQ(arguments.output_path, "maps");
  EXPECT_EQ(arguments.options.training.num_steps,
            QualityPreset("medium").training.num_steps);
  EXPECT_EQ(arguments.device, "cpu");
}

// What the option stands for depends on the field, which comes later here.
TEST(TrainArguments, TheDeviceIsOneThatTheMachineHas) {
  EXPECT_EQ(ParseTrainArguments(WithPaths({"--StructNeRF.device=auto",
                                           "--StructNeRF.field=mlp"}))
                .device,
            "cpu");
  ExpectError(WithPaths({"--StructNeRF.device=cuda", "--StructNeRF.field=mlp"}),
              "--StructNeRF.device is cuda, but");
  ExpectError(WithPaths({"--StructNeRF.device=tpu"}),
              "must be auto, cpu or cuda");
}

TEST(TrainArguments, OptionsChangeQualityAndMethodInAnyOrder) {
  const TrainArguments arguments =
      ParseTrainArguments(WithPaths({"--StructNeRF.num_steps=7",
                                     "--StructNeRF.stereo_complete_planes",
                                     "0",
                                     "--StructNeRF.far_weight",
                                     "0.25",
                                     "--StructNeRF.quality",
                                     "high",
                                     "--StructNeRF.method=dsnerf"}));
  EXPECT_EQ(arguments.options.training.num_steps, 7);
  EXPECT_FALSE(arguments.options.stereo.complete_planes);
  EXPECT_EQ(arguments.options.loss.far_weight, 0.25);
  EXPECT_EQ(arguments.options.training.rays_per_step,
            QualityPreset("high").training.rays_per_step);
  EXPECT_EQ(arguments.options.loss.sparse_form, "squared");
}

TEST(TrainArguments, WhatIsWrongIsNamed) {
  ExpectError({}, "--scene_path is missing");
  ExpectError({"--scene_path=a"}, "--output_path is missing");
  ExpectError(WithPaths({"maps"}), "argument maps");
  ExpectError(WithPaths({"--StructNeRF.seed"}), "--StructNeRF.seed needs");
  ExpectError(WithPaths({"--StructNeRF.sed=1"}), "no option --StructNeRF.sed");
  ExpectError(WithPaths({"--StructNeRF.max_image_size=64"}),
              "no option --StructNeRF.max_image_size");
  for (const char* text : {"many", "1.5", "1 ", ""}) {
    ExpectError(WithPaths({std::string("--StructNeRF.seed=") + text}),
                "--StructNeRF.seed cannot be read");
  }
  ExpectError(WithPaths({"--StructNeRF.stereo_complete_planes=yes"}),
              "cannot be read: yes");
  ExpectError(WithPaths({"--StructNeRF.num_steps=0"}),
              "--StructNeRF.num_steps must be");
  ExpectError(WithPaths({"--StructNeRF.quality=best"}),
              "--StructNeRF.quality must be");
  ExpectError(WithPaths({"--StructNeRF.method=magic"}),
              "--StructNeRF.method must be");
}

TEST(TrainArguments, UsageListsOptions) {
  EXPECT_THAT(TrainUsage(), HasSubstr("--StructNeRF.patch_weight "));
  EXPECT_THAT(TrainUsage(), HasSubstr("--scene_path"));
}

}  // namespace
}  // namespace structnerf
