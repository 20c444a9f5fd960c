// Real photographs against depth sensors. The data lies beside the checkout and
// is not part of it; the tests say that they were skipped when it is not there.

#include "tests/end_to_end/json_files.h"
#include "tests/end_to_end/run_program.h"
#include "tests/support/temp_dir.h"

#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

struct RealScene {
  const char* name;

  // Share of all pixels with ground truth whose depth, in SfM scale, must be
  // within 5 cm: more than a short training has that neither matches nor
  // completes planes.
  double min_share_within_5cm;
};

class RealSceneTest : public testing::TestWithParam<RealScene> {};

TEST_P(RealSceneTest, DepthIsGoodAtDefaultQuality) {
  const fs::path shared(STRUCTNERF_SHARED_DATA);
  const fs::path scene = shared / "data" / GetParam().name;
  const fs::path scorer = shared / "tools/eval_depth.py";
  if (!fs::exists(scene) || !fs::exists(scorer)) {
    GTEST_SKIP() << scene << " is not there";
  }
  // The system's Python, which the scorer's packages are installed for.
  const std::string python = "/usr/bin/python3";
  if (std::system((python + " -c 'import cv2, numpy' 2> /dev/null").c_str()) !=
      0) {
    GTEST_SKIP() << "the scorer needs the packages python3-opencv and "
                    "python3-numpy";
  }

  const TempDir temp_dir;
  const ProgramResult result = RunProgram({"structnerf_dense",
                                           "--image_path",
                                           scene / "images",
                                           "--input_path",
                                           scene / "sparse/0",
                                           "--output_path",
                                           temp_dir / "dense"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  std::cout << result.out;

  const std::string scores_path = temp_dir / "scores.json";
  const std::string command =
      python + " '" + scorer.string() + "' '" + scene.string() +
      "' --workspace '" + temp_dir / "dense" + "' --type photometric --json '" +
      scores_path + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const double share =
      ReadJson(scores_path)["maps"]["sfm_scale"]["all"]["within_5cm"];
  RecordProperty("within_5cm", std::to_string(share));
  EXPECT_GE(share, GetParam().min_share_within_5cm);

  // The cloud shows the room: it has points on what most views see.
  EXPECT_GT(ReadReport(temp_dir / "dense")["fusion"]["points"], 50000);
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         RealSceneTest,
                         testing::Values(RealScene{"redkitchen", 0.62},
                                         RealScene{"hololens_dining", 0.40}),
                         [](const auto& info) {
                           return std::string(info.param.name);
                         });

}  // namespace
}  // namespace structnerf
