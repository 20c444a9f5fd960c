#include "colmap_plugin/image_file.h"

#include "tests/support/temp_dir.h"

#include <fstream>

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

}  // namespace
}  // namespace structnerf
