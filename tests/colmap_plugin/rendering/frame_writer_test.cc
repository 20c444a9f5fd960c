#include "colmap_plugin/rendering/frame_writer.h"

#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

using testing::HasSubstr;

// Red, nowhere, and a third pixel that is far away; all face the camera.
RenderedView ThreePixels() {
  RenderedView view;
  view.width = 3;
  view.height = 1;
  view.color = {1, 0, 0, 0, 0, 0, 0, 0.5f, 1};
  view.depth = {1.25f, 0, 100};
  view.normal = {0, 0, 0, 0, 0, 0, -1, 0, -1};
  return view;
}

TEST(FrameWriterTest, WritesWhatItDocuments) {
  const TempDir temp_dir;
  FrameOptions options;
  options.farthest_depth = 2;
  EXPECT_DOUBLE_EQ(LargestDepth(options), 65.535);
  EXPECT_EQ(WriteFrame(ThreePixels(), "a/b", options, temp_dir / "frames"), 1);

  const cv::Mat3b color = cv::imread(temp_dir / "frames/color/a/b.png");
  EXPECT_EQ(color(0, 0), cv::Vec3b(0, 0, 255));  // OpenCV reads BGR
  EXPECT_EQ(color(0, 2), cv::Vec3b(255, 128, 0));
  const cv::Mat depth =
      cv::imread(temp_dir / "frames/depth/a/b.png", cv::IMREAD_UNCHANGED);
  ASSERT_EQ(depth.type(), CV_16UC1);
  EXPECT_EQ(depth.at<uint16_t>(0, 0), 1250);
  EXPECT_EQ(depth.at<uint16_t>(0, 1), 0);
  EXPECT_EQ(depth.at<uint16_t>(0, 2), 0);  // does not fit
  const cv::Mat3b shown = cv::imread(temp_dir / "frames/depth_color/a/b.png");
  EXPECT_NE(shown(0, 0), shown(0, 2));
  EXPECT_EQ(shown(0, 1), cv::Vec3b(128, 128, 128));
  const cv::Mat3b normal = cv::imread(temp_dir / "frames/normal/a/b.png");
  EXPECT_EQ(normal(0, 0), cv::Vec3b(255, 128, 128));
  EXPECT_EQ(normal(0, 1), cv::Vec3b(128, 128, 128));
}

TEST(FrameWriterTest, HoldsMoreWithALowerScale) {
  const TempDir temp_dir;
  FrameOptions options;
  options.depth_scale = 100;
  EXPECT_EQ(WriteFrame(ThreePixels(), "a", options, temp_dir / "frames"), 0);
  const cv::Mat depth =
      cv::imread(temp_dir / "frames/depth/a.png", cv::IMREAD_UNCHANGED);
  EXPECT_EQ(depth.at<uint16_t>(0, 0), 125);
  EXPECT_EQ(depth.at<uint16_t>(0, 2), 10000);
}

TEST(FrameWriterTest, NamesTheFileThatCannotBeWritten) {
  const TempDir temp_dir;
  std::ofstream(temp_dir / "file") << "not a folder";
  try {
    WriteFrame(ThreePixels(), "a", FrameOptions(), temp_dir / "file");
    ADD_FAILURE();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("file/color/a.png"));
  }
}

}  // namespace
}  // namespace structnerf
