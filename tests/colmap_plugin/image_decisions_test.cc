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
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

using testing::ElementsAre;

std::vector<std::string> Describe(const TinyModel& model,
                                  const StructNerfOptions& options) {
  const TempDir folder;
  model.WriteModel(folder / "model");
  std::vector<std::string> texts;
  for (const SceneDecision& decision :
       DescribeImages(options, ReadModel(folder / "model"), {50}, 50)) {
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

TEST(DescribeImages, SaysWhatTheirSizeIsChosenBy) {
  const TempDir folder;
  const TinyModel model = MakeTinyModel(3);
  model.WriteModel(folder / "model");
  const auto decisions = DescribeImages(
      StructNerfOptions(), ReadModel(folder / "model"), {50, 35, 4.2}, 50);
  EXPECT_EQ(decisions[1].Text(),
            "training images: at most 50 pixels (the photographs have up to "
            "64, at 35 pixels 4.2 of 255 grey levels are lost)");
}

TEST(ChooseImageSize, FollowsThePhotographsUnlessTold) {
  const TempDir folder;
  TinyModel model = MakeTinyModel(3);
  model.cameras[0] = {"PINHOLE", 640, 480, {600, 600, 320, 240}};
  model.WriteModel(folder / "model");
  const auto reconstruction = ReadModel(folder / "model");
  for (const TinyModel::Image& image : model.images) {
    cv::imwrite(folder / image.name,
                cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(120)));
  }
  StructNerfOptions options;
  options.image_path = folder.Path();
  options.reconstruction.training.max_image_size = 320;
  options.image_size_from_detail = false;
  EXPECT_EQ(ChooseImageSize(reconstruction, &options).image_size, 320);
  EXPECT_EQ(options.reconstruction.training.max_image_size, 320);
  options.image_size_from_detail = true;
  EXPECT_EQ(ChooseImageSize(reconstruction, &options).image_size, 80);
  EXPECT_EQ(options.reconstruction.training.max_image_size, 80);
}

}  // namespace
}  // namespace structnerf
