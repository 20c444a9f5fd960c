#include "colmap_plugin/tradeoff/tradeoff_report.h"

#include "tests/support/temp_dir.h"
#include "tests/support/text_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

using testing::HasSubstr;

class TradeoffReportTest : public testing::Test {
 protected:
  TradeoffReportTest() {
    scene_.image_path = "images";
    scene_.input_path = "sparse";
    scene_.output_path = temp_dir_.Path().string();
    settings_ = {
        {{"quality=low", {}},
         {{20, 38, 500 << 20, 0.42, 22.5}, {22, 40, 510 << 20, 0.40, 22.3}}},
        {{"quality=<b>", {}}, {{60, 100, 600 << 20, 0.31, -1}}}};
  }

  TempDir temp_dir_;
  TradeoffScene scene_;
  std::vector<MeasuredSetting> settings_;
};

TEST_F(TradeoffReportTest, APointIsTheMeanOfItsSeeds) {
  const TradeoffPoint point = settings_[0].Point();
  EXPECT_EQ(point.name, "quality=low");
  EXPECT_NEAR(point.seconds, 21, 1e-9);
  EXPECT_NEAR(point.error, 0.41, 1e-9);
  EXPECT_NEAR(point.min_error, 0.40, 1e-9);
  EXPECT_NEAR(point.max_error, 0.42, 1e-9);
}

TEST_F(TradeoffReportTest, WritesPageNumbersAndPlot) {
  const std::string advice = WriteTradeoffReport(scene_, settings_);
  const auto object =
      nlohmann::json::parse(ReadText(temp_dir_ / "tradeoff.json"));
  EXPECT_EQ(object["advice"], advice);
  EXPECT_EQ(object["settings"][0]["runs"].size(), 2u);
  EXPECT_EQ(object["settings"][1]["runs"][0]["error"], 0.31);
  EXPECT_EQ(object["settings"][1]["is_on_front"], true);
  EXPECT_FALSE(cv::imread(temp_dir_ / "tradeoff.png").empty());
  const std::string page = ReadText(temp_dir_ / "tradeoff.html");
  EXPECT_THAT(page, HasSubstr("data:image/png;base64,"));
  EXPECT_THAT(page, HasSubstr("41.0 (40.0 to 42.0)"));
  EXPECT_THAT(page, HasSubstr("22.40"));  // of both seeds
  EXPECT_EQ(object["settings"][0]["runs"][0]["held_out_psnr"], 22.5);
  EXPECT_TRUE(object["settings"][1]["runs"][0]["held_out_psnr"].is_null());
  EXPECT_THAT(page, HasSubstr("quality=&lt;b&gt;"));
  EXPECT_THAT(page, HasSubstr("There was no ground truth, and no photograph"));

  scene_.test_every = 8;
  WriteTradeoffReport(scene_, settings_);
  EXPECT_THAT(ReadText(temp_dir_ / "tradeoff.html"),
              HasSubstr("Of 8 photographs one was kept out"));
}

TEST_F(TradeoffReportTest, SaysThatThereWasTruth) {
  scene_.truth.path = "depth";
  WriteTradeoffReport(scene_, settings_);
  EXPECT_THAT(ReadText(temp_dir_ / "tradeoff.html"),
              HasSubstr("measured against ground truth"));
}

TEST_F(TradeoffReportTest, AFolderThatIsNotThereIsNamed) {
  scene_.output_path = temp_dir_ / "missing";
  try {
    WriteTradeoffReport(scene_, settings_);
    ADD_FAILURE();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr(scene_.output_path));
  }
}

}  // namespace
}  // namespace structnerf
