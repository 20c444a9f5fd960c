// The modules are made here, by the LibTorch that loads them.

#include "nerf/prior_module.h"

#include "tests/nerf/train/objective_scene.h"
#include "tests/support/temp_dir.h"

#include <fstream>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <torch/script.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

constexpr int kWidth = 24;

class PriorModuleTest : public testing::Test {
 protected:
  // A module with this body of "forward(self, image, sparse_depth)".
  std::string SaveModule(const std::string& body) {
    torch::jit::Module module("prior");
    module.define("def forward(self, image, sparse_depth):\n  " + body + "\n");
    const std::string path = temp_dir_ / "prior.pt";
    module.save(path);
    return path;
  }

  std::string ErrorOf(const std::string& path) {
    try {
      Progress progress;
      PredictPriors(path, &progress, &scene_);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  TempDir temp_dir_;
  Scene scene_ = ObjectiveScene().scene;
};

// Depth 1 plus red, deviation 1 plus the sparse depth.
TEST_F(PriorModuleTest, SeesImageAndSparsePoints) {
  EXPECT_EQ(
      ErrorOf(SaveModule("return (1.0 + image[:, 0:1], 1.0 + sparse_depth)")),
      "");
  const SparsePoint& point = scene_.points[0];
  const Observation& observation = point.track[2];
  const View& view = scene_.views[observation.view_idx];
  const int col = static_cast<int>(0.5 * observation.xy.x());
  const int row = static_cast<int>(0.5 * observation.xy.y());
  const size_t pixel = static_cast<size_t>(row) * kWidth + col;
  EXPECT_NEAR(
      view.prior_depth[pixel], 1 + view.image.data[3 * pixel] / 255.0, 1e-6);
  const double depth = DepthInView(view, point.xyz);
  EXPECT_NEAR(view.prior_deviation[pixel], 1 + depth, 1e-4);
  int num_without_point = 0;
  for (const float deviation : view.prior_deviation) {
    num_without_point += deviation == 1;
  }
  EXPECT_GT(num_without_point, static_cast<int>(scene_.points.size()));
  EXPECT_NO_THROW(scene_.Check());
}

TEST_F(PriorModuleTest, DoesNotSeePointsThatTrainingRemoves) {
  const std::string path =
      SaveModule("return (1.0 + image[:, 0:1], 1.0 + sparse_depth)");
  EXPECT_EQ(ErrorOf(path), "");
  const std::vector<float> expected = scene_.views[0].prior_deviation;
  SparsePoint wrong = scene_.points[0];
  for (Observation& observation : wrong.track) {
    observation.xy.x() += 20;
  }
  scene_.points.push_back(wrong);
  const size_t num_points = scene_.points.size();
  EXPECT_EQ(ErrorOf(path), "");
  EXPECT_EQ(scene_.views[0].prior_deviation, expected);
  EXPECT_EQ(scene_.points.size(), num_points);
}

// Aborts once it has been paused this often.
class PausedProgress : public Progress {
 public:
  void BlockWhilePaused() override { ++num_pauses; }
  bool ShouldAbort() override { return num_pauses == 2; }
  int num_pauses = 0;
};

TEST_F(PriorModuleTest, PausesAndAbortsBetweenViews) {
  const std::string path = SaveModule("return (image[:, 0:1], sparse_depth)");
  PausedProgress progress;
  EXPECT_THROW(PredictPriors(path, &progress, &scene_), Aborted);
  EXPECT_EQ(progress.num_pauses, 2);
}

TEST_F(PriorModuleTest, NonsenseIsNoPrior) {
  EXPECT_EQ(ErrorOf(SaveModule("return (image[:, 0:1] - 2.0, sparse_depth)")),
            "");
  for (const View& view : scene_.views) {
    EXPECT_THAT(view.prior_depth, testing::Each(0.0f));
  }
  // A deviation that is none: the depth itself.
  EXPECT_EQ(
      ErrorOf(SaveModule("return (image[:, 0:1] + 2.0, 0.0 * sparse_depth)")),
      "");
  EXPECT_EQ(scene_.views[1].prior_deviation, scene_.views[1].prior_depth);
}

TEST_F(PriorModuleTest, WrongModulesAreNamed) {
  EXPECT_THAT(ErrorOf(temp_dir_ / "missing.pt"), HasSubstr("missing.pt"));
  const std::string text_path = temp_dir_ / "text.pt";
  std::ofstream(text_path) << "no module";
  EXPECT_THAT(ErrorOf(text_path), HasSubstr("text.pt is not a TorchScript"));
  std::string error = ErrorOf(SaveModule("return image"));
  EXPECT_THAT(error, HasSubstr("prior.pt"));
  EXPECT_THAT(error, HasSubstr("tuple of depth and deviation"));
  EXPECT_THAT(ErrorOf(SaveModule("return (image, sparse_depth)")),
              HasSubstr("another size than the image"));
  error = ErrorOf(SaveModule("return (image + torch.zeros([7]), image)"));
  EXPECT_THAT(error, HasSubstr("image view"));
  EXPECT_THAT(error, testing::Not(HasSubstr("\n")));
}

}  // namespace
}  // namespace structnerf
