// Runs the program as a user does.

#include "tests/support/temp_dir.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;
using testing::Not;

class ResultsTableTest : public testing::Test {
 protected:
  void WriteRun(const std::string& path,
                const std::string& eval,
                const std::string& report = "{}") const {
    const std::filesystem::path folder = dir_ / ("runs/" + path);
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "eval.json") << eval;
    std::ofstream(folder / "report.json") << report;
  }

  // What was printed.
  std::string Run(const bool should_succeed) {
    const std::string log = dir_ / "log";
    const std::string command = "'" RESULTS_TABLE_PROGRAM "' '" +
                                dir_ / "runs" + "' nerf full >'" + log +
                                "' 2>&1";
    EXPECT_EQ(std::system(command.c_str()) == 0, should_succeed);
    std::ifstream file(log);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  TempDir dir_;
};

TEST_F(ResultsTableTest, ShowsThePartOfInterest) {
  WriteRun("room/full/0", R"({"held_out": {"psnr": 20}})");
  std::ofstream(dir_ / "runs/room/full/0/part.json")
      << R"({"maps": {"photometric": {"sfm_scale":
             {"all": {"within_5cm": 0.125}}}}})";
  const std::string table = Run(true);
  EXPECT_THAT(table, HasSubstr("| part < 5 cm % |"));
  EXPECT_THAT(table, HasSubstr("12.5"));
}

TEST_F(ResultsTableTest, ShowsMeanSpreadAndTheBest) {
  for (const auto& [seed, psnr] :
       {std::pair("0", "20"), std::pair("1", "21"), std::pair("2", "22.5")}) {
    WriteRun(std::string("room/full/") + seed,
             std::string(R"({"held_out": {"lpips": null, "psnr": )") + psnr +
                 R"(, "depth": {"image_scale": {"all": {"rmse_m": 0.25}}}}})",
             R"({"cpu_seconds": 30})");
  }
  WriteRun("room/nerf/0",
           R"({"held_out": {"psnr": 19,
               "depth": {"image_scale": {"all": {"rmse_m": 0.125}}}}})",
           R"({"cpu_seconds": 20})");
  WriteRun("room/other/0", R"({"held_out": {"psnr": 99}})");
  const std::string table = Run(true);
  EXPECT_THAT(table,
              HasSubstr("| scene | method | runs | PSNR dB | held-out depth "
                        "RMSE m | CPU s |"));
  EXPECT_THAT(
      table,
      HasSubstr(
          "| room | full | 3 | **21.17** ± 1.25 | 0.250 ± 0.000 | 30 ± 0 |"));
  EXPECT_THAT(table,
              HasSubstr("| room | nerf | 1 | 19.00 | **0.125** | **20** |\n"
                        "| room | full"));
  // Nobody measured it, or asked for it.
  EXPECT_THAT(table, Not(HasSubstr("other")));
  EXPECT_THAT(table, Not(HasSubstr("LPIPS")));
}

TEST_F(ResultsTableTest, DoesNotAverageOverSomeOfTheRuns) {
  WriteRun("room/full/0", R"({"held_out": {"psnr": 20, "ssim": 0.5}})");
  WriteRun("room/full/1", R"({"held_out": {"psnr": 20}})");
  EXPECT_THAT(Run(true), HasSubstr("| **20.00** ± 0.00 | - |"));
}

TEST_F(ResultsTableTest, NamesWhatIsWrong) {
  EXPECT_THAT(Run(false), HasSubstr("does not exist"));
  WriteRun("room/full/0", "{");
  EXPECT_THAT(Run(false), HasSubstr("room/full/0/eval.json"));
  std::filesystem::remove_all(dir_ / "runs/room/full");
  EXPECT_THAT(Run(false), HasSubstr("has no runs"));
}

}  // namespace
}  // namespace structnerf
