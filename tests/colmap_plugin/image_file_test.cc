#include "colmap_plugin/image_file.h"

#include "tests/support/temp_dir.h"
#include "tests/support/text_file.h"

#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

TEST(ImageFile, ColourAndGreyOfTheSameFile) {
  const TempDir temp_dir;
  const std::string path = temp_dir / "a.png";
  cv::imwrite(path, cv::Mat3b(2, 3, cv::Vec3b(10, 20, 30)));
  const cv::Mat3b color = ReadColorImage(path);
  ASSERT_EQ(color.size(), cv::Size(3, 2));
  EXPECT_EQ(color(1, 2), cv::Vec3b(10, 20, 30));
  const cv::Mat1b grey = ReadGreyImage(path);
  ASSERT_EQ(grey.size(), cv::Size(3, 2));
  EXPECT_NEAR(grey(1, 2), 22, 1);
}

TEST(ImageFile, WhatIsNoImageIsEmpty) {
  const TempDir temp_dir;
  std::ofstream(temp_dir / "a.png") << "no image";
  for (const char* name : {"a.png", "missing.png"}) {
    EXPECT_TRUE(ReadColorImage(temp_dir / name).empty()) << name;
    EXPECT_TRUE(ReadGreyImage(temp_dir / name).empty()) << name;
  }
}

TEST(ImageFile, CutOffImagesAreNoticed) {
  const TempDir temp_dir;
  cv::Mat3b image(64, 64);
  cv::randu(image, 0, 255);
  for (const std::string name : {"a.jpg", "a.png"}) {
    SCOPED_TRACE(name);
    const std::string path = temp_dir / name;
    cv::imwrite(path, image);
    EXPECT_FALSE(IsCutOff(path));
    const std::string whole = ReadText(path);
    for (const size_t size :
         {whole.size() - 1, whole.size() / 2, size_t{200}, size_t{8}}) {
      std::ofstream(path, std::ios::binary) << whole.substr(0, size);
      EXPECT_TRUE(IsCutOff(path)) << size;
    }
    std::ofstream(path, std::ios::binary) << whole << "what a camera appends";
    EXPECT_FALSE(IsCutOff(path));
  }
}

// A thumbnail in the head has an end of its own.
TEST(ImageFile, TheEndOfAThumbnailIsNotThatOfThePhotograph) {
  const TempDir temp_dir;
  const std::string path = temp_dir / "a.jpg";
  cv::Mat3b image(64, 64);
  cv::randu(image, 0, 255);
  cv::imwrite(path, image);
  const std::string whole = ReadText(path);
  const std::string head = {
      '\xff', '\xe1', '\0', '\x06', '\0', '\xff', '\xd9', '\0'};
  const std::string with_thumbnail =
      whole.substr(0, 2) + head + whole.substr(2);
  std::ofstream(path, std::ios::binary) << with_thumbnail;
  EXPECT_FALSE(IsCutOff(path));
  std::ofstream(path, std::ios::binary)
      << with_thumbnail.substr(0, whole.size() - 100);
  EXPECT_TRUE(IsCutOff(path));
}

TEST(ImageFile, OtherFilesAreNotCutOff) {
  const TempDir temp_dir;
  std::ofstream(temp_dir / "a.jpg") << "no image";
  std::ofstream(temp_dir / "b.jpg");
  EXPECT_FALSE(IsCutOff(temp_dir / "a.jpg"));
  EXPECT_FALSE(IsCutOff(temp_dir / "b.jpg"));
  EXPECT_FALSE(IsCutOff(temp_dir / "missing.jpg"));
}

}  // namespace
}  // namespace structnerf
