#include "colmap_plugin/run_report.h"

#include "tests/support/temp_dir.h"
#include "tests/support/text_file.h"

#include <chrono>
#include <ctime>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace structnerf {
namespace {

using nlohmann::json;
using testing::HasSubstr;

RunReport MakeReport() {
  RunReport report;
  report.options = {{"StructNeRF.num_steps", 7},
                    {"StructNeRF.quality", std::string("low")},
                    {"StructNeRF.patch_weight", 0.5},
                    {"StructNeRF.flag", true}};
  report.num_points3D = 90;
  report.training_image_size = 320;
  report.decisions = {{"table", "2^15 entries", "12000 are in use"}};
  report.stages = {{"Training", 2, 3.5}, {"Fusing points", 1, 1}};
  report.memory_limit = size_t{4} << 30;
  report.expected_memory = size_t{2} << 30;
  report.peak_memory = size_t{1} << 30;
  report.training.num_steps = 7;
  report.training.seconds = 2;
  report.training.num_samples = 3000000;
  report.training.guard_counts = {
      {"dead_fields", 0}, {"restored_snapshots", 1}, {"skipped_steps", 2}};
  report.views = {{"a.png", 10, 20, 100, 60, {}}, {"b.png", 10, 20, 50, 0, {}}};
  report.fusion_min_num_pixels = 2;
  report.num_fused_points = 123;
  report.warnings = {"View b.png has no sparse points."};
  report.workspace_path = "DENSE";
  return report;
}

TEST(RunReport, JsonHoldsTypedValues) {
  const json object = json::parse(ReportJson(MakeReport()));
  EXPECT_EQ(object["schema_version"], 1);
  EXPECT_TRUE(object["options"]["StructNeRF.num_steps"].is_number_integer());
  EXPECT_EQ(object["options"]["StructNeRF.quality"], "low");
  EXPECT_EQ(object["options"]["StructNeRF.flag"], true);
  EXPECT_EQ(object["stages"][0]["name"], "Training");
  EXPECT_EQ(object["seconds"], 3);
  EXPECT_EQ(object["cpu_seconds"], 4.5);
  EXPECT_EQ(object["training"]["samples_per_second"], 1500000);
  EXPECT_EQ(object["training"]["guards"]["skipped_steps"], 2);
  EXPECT_EQ(object["maps"]["pixels"], 400);
  EXPECT_EQ(object["maps"]["photometric_pixels"], 150);
  EXPECT_EQ(object["views"][1]["name"], "b.png");
  EXPECT_EQ(object["scene"]["decisions"][0]["choice"], "2^15 entries");
  EXPECT_EQ(object["fusion"]["points"], 123);
  EXPECT_EQ(object["warnings"].size(), 1);
  EXPECT_FALSE(object["versions"]["structnerf"].empty());
  EXPECT_GT(object["hardware"]["cores"], 0);
  EXPECT_GT(object["hardware"]["memory_bytes"], 1 << 20);
}

TEST(RunReport, JsonSurvivesNamesThatAreNotUtf8) {
  RunReport report = MakeReport();
  report.views[0].name = "\xff\xfe.png";
  EXPECT_NO_THROW(json::parse(ReportJson(report)));
}

TEST(RunReport, TextIsAboutWhatPeopleAsk) {
  const std::string text = ReportText(MakeReport());
  EXPECT_THAT(text, HasSubstr("150 of 400 (37.5 %), 60 (15.0 %)"));
  EXPECT_THAT(text, HasSubstr("123 (min_num_pixels 2)"));
  EXPECT_THAT(text, HasSubstr("3.0 s: Training 2.0 s; Fusing points 1.0 s"));
  EXPECT_THAT(text, HasSubstr("1.00 GB (expected 2.00 GB, limit 4.00 GB)"));
  EXPECT_THAT(text, HasSubstr("View b.png has no sparse points."));
  EXPECT_THAT(text, HasSubstr("DENSE"));
}

TEST(RunReport, TextNamesGuardsThatActed) {
  RunReport report = MakeReport();
  EXPECT_THAT(
      ReportText(report),
      HasSubstr("\nGuards that acted restored_snapshots 1, skipped_steps 2\n"));
  report.training.guard_counts = {{"dead_fields", 0}};
  EXPECT_THAT(ReportText(report), Not(HasSubstr("Guards")));
}

TEST(RunReport, TextOfAnEmptyRunHasNoNonsense) {
  const std::string text = ReportText(RunReport());
  EXPECT_THAT(text, HasSubstr("0 of 0 (0.0 %)"));
  EXPECT_THAT(text, Not(HasSubstr("nan")));
}

TEST(RunReport, WritesBothFiles) {
  const TempDir temp_dir;
  const RunReport report = MakeReport();
  WriteReport(report, temp_dir.Path());
  const std::string text = ReadText(temp_dir / "report.txt");
  EXPECT_THAT(text, testing::StartsWith(ReportText(report)));
  EXPECT_THAT(text, HasSubstr("table: 2^15 entries (12000 are in use)"));
  EXPECT_EQ(json::parse(ReadText(temp_dir / "report.json"))["schema_version"],
            1);
  EXPECT_THROW(WriteReport(report, temp_dir / "none"), std::runtime_error);
}

TEST(StageTimer, TimesEachStageOnItsOwn) {
  StageTimer timer;
  timer.Begin("Sleep");
  std::this_thread::sleep_for(std::chrono::milliseconds(120));
  timer.Begin("Work");
  const std::clock_t end = std::clock() + CLOCKS_PER_SEC / 10;
  while (std::clock() < end) {
  }
  timer.End();
  timer.End();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  ASSERT_EQ(timer.Stages().size(), 2);
  EXPECT_EQ(timer.Stages()[0].name, "Sleep");
  EXPECT_GE(timer.Stages()[0].seconds, 0.12);
  EXPECT_EQ(timer.Stages()[1].name, "Work");
  EXPECT_NEAR(timer.Stages()[1].cpu_seconds, 0.1, 0.02);
}

}  // namespace
}  // namespace structnerf
