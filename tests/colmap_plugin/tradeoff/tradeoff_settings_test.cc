#include "colmap_plugin/tradeoff/tradeoff_settings.h"

#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string ErrorOf(const std::string& text) {
  try {
    ParseTradeoffSettings(text);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(TradeoffSettings, OptionsBecomeArguments) {
  const auto settings = ParseTradeoffSettings(
      "quality=low,  quality=high   num_steps=6000 "
      "StereoFusion.min_num_pixels=3");
  ASSERT_EQ(settings.size(), 2u);
  EXPECT_EQ(settings[0].name, "quality=low");
  EXPECT_THAT(settings[0].arguments, ElementsAre("--StructNeRF.quality=low"));
  EXPECT_EQ(settings[1].name,
            "quality=high num_steps=6000 StereoFusion.min_num_pixels=3");
  EXPECT_THAT(settings[1].arguments,
              ElementsAre("--StructNeRF.quality=high",
                          "--StructNeRF.num_steps=6000",
                          "--StereoFusion.min_num_pixels=3"));
}

TEST(TradeoffSettings, FolderNamesHaveNoStrangeCharacters) {
  const auto settings = ParseTradeoffSettings("prior_path=../a/b num_steps=1");
  EXPECT_EQ(settings[0].FolderName(), "prior_path=..+a+b+num_steps=1");
}

TEST(TradeoffSettings, WhatIsWrongIsNamed) {
  EXPECT_THAT(ErrorOf(""), HasSubstr("--settings is empty"));
  EXPECT_THAT(ErrorOf("quality=low,,quality=high"), HasSubstr("two commas"));
  EXPECT_THAT(ErrorOf("low"), HasSubstr("\"low\""));
  EXPECT_THAT(ErrorOf("quality="), HasSubstr("\"quality=\""));
  EXPECT_THAT(ErrorOf("=low"), HasSubstr("name=value"));
  EXPECT_THAT(ErrorOf("seed=3"), HasSubstr("sets itself"));
  EXPECT_THAT(ErrorOf("quality=low, quality=low"), HasSubstr("twice"));
}

}  // namespace
}  // namespace structnerf
