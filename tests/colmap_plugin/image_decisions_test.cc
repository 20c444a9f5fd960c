#include "colmap_plugin/image_decisions.h"

#include "colmap_plugin/input_check.h"
#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::ElementsAre;

std::vector<std::string> Describe(const TinyModel& model,
                                  const StructNerfOptions& options) {
  const TempDir folder;
  model.WriteModel(folder / "model");
  std::vector<std::string> texts;
  for (const SceneDecision& decision :
       DescribeImages(options, ReadModel(folder / "model"), 50)) {
    texts.push_back(decision.Text());
  }
  return texts;
}

TEST(DescribeImages, OfPinholesWithoutMasks) {
  EXPECT_THAT(
      Describe(MakeTinyModel(3), StructNerfOptions()),
      ElementsAre(
          "undistortion: off (0 of 3 images were taken with a lens that "
          "distorts)",
          "training images: at most 50 pixels (the photographs have up to 64)",
          "masks: off (0 of 3 images have one)"));
}

TEST(DescribeImages, CountsWhatHasToBeDone) {
  TinyModel model = MakeTinyModel(3);
  model.cameras.push_back({"SIMPLE_RADIAL", 40, 90, {50, 20, 45, 0.1}});
  model.images.push_back({"3.png", 1, -1});
  const TempDir masks;
  std::ofstream(masks / "1.png.png") << "a mask";
  std::ofstream(masks / "other.png.png") << "another";
  StructNerfOptions options;
  options.mask_path = masks.Path();
  EXPECT_THAT(
      Describe(model, options),
      ElementsAre(
          "undistortion: on (1 of 4 images were taken with a lens that "
          "distorts)",
          "training images: at most 50 pixels (the photographs have up to 90)",
          "masks: on (1 of 4 images have one)"));
}

}  // namespace
}  // namespace structnerf
