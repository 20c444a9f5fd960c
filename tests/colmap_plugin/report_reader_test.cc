#include "colmap_plugin/report_reader.h"

#include "colmap_plugin/run_report.h"
#include "tests/support/temp_dir.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

class ReportReaderTest : public testing::Test {
 protected:
  std::string Error() const {
    try {
      ReadReport(temp_dir_ / "report.json");
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  TempDir temp_dir_;
};

TEST_F(ReportReaderTest, GivesBackWhatWasWritten) {
  StructNerfOptions options;
  options.quality = "high";
  options.reconstruction = QualityPreset("high");
  options.reconstruction.field.hidden_width = 48;
  options.reconstruction.training.test_every = 7;
  options.reconstruction.loss.patch_weight = 0.125;
  RunReport report;
  for (const OptionEntry& entry : MakeOptionTable(&options)) {
    report.options.emplace(entry.name, entry.Value());
  }
  report.stages = {{"a", 1.5, 2.5}, {"b", 2, 3}};
  report.views.resize(2);
  report.views[1].exposure = {{1.5f, 2, 3}, {0.25f, -0.5f, 0}};
  WriteReport(report, temp_dir_.Path());

  FinishedRun run = ReadReport(temp_dir_ / "report.json");
  const auto expected = MakeOptionTable(&options);
  const auto read = MakeOptionTable(&run.options);
  ASSERT_EQ(read.size(), expected.size());
  for (size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(OptionText(read[i]), OptionText(expected[i]));
  }
  EXPECT_DOUBLE_EQ(run.seconds, 3.5);
  EXPECT_DOUBLE_EQ(run.cpu_seconds, 5.5);
  ASSERT_EQ(run.exposures.size(), 2u);
  EXPECT_EQ(run.exposures[0].gain, Eigen::Vector3f::Ones());
  EXPECT_EQ(run.exposures[1].gain, Eigen::Vector3f(1.5f, 2, 3));
  EXPECT_EQ(run.exposures[1].offset, Eigen::Vector3f(0.25f, -0.5f, 0));
}

TEST_F(ReportReaderTest, OptionsThatAreNotInItKeepTheirDefaults) {
  std::ofstream(temp_dir_ / "report.json")
      << R"({"seconds": 1, "cpu_seconds": 2, "options":
             {"StructNeRF.quality": "low", "StructNeRF.of_the_future": 3}})";
  const FinishedRun run = ReadReport(temp_dir_ / "report.json");
  EXPECT_EQ(run.options.reconstruction.training.num_steps,
            QualityPreset("low").training.num_steps);
  EXPECT_TRUE(run.exposures.empty());
}

TEST_F(ReportReaderTest, NamesTheFileThatIsWrong) {
  EXPECT_THAT(Error(), HasSubstr("report.json cannot be read"));
  std::ofstream(temp_dir_ / "report.json") << "{";
  EXPECT_THAT(Error(), HasSubstr("report.json is no report"));
  std::ofstream(temp_dir_ / "report.json")
      << R"({"seconds": 1, "cpu_seconds": 2, "options":
             {"StructNeRF.num_steps": "many"}})";
  EXPECT_THAT(Error(), HasSubstr("report.json is no report"));
}

}  // namespace
}  // namespace structnerf
