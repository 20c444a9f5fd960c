#include "colmap_plugin/png_file.h"

#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/file_size_limit.h"
#include "tests/support/temp_dir.h"

#include <filesystem>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

using testing::HasSubstr;

TEST(WritePng, LosesNothing) {
  const TempDir temp_dir;
  const cv::Mat image = RandomImage(20, 10, 1);
  WritePng(temp_dir / "a.png", image);
  const cv::Mat read = cv::imread(temp_dir / "a.png", cv::IMREAD_UNCHANGED);
  ASSERT_EQ(read.size(), image.size());
  EXPECT_EQ(cv::norm(read, image, cv::NORM_INF), 0);
}

// Not a byte may be missing, and the old file is not touched.
TEST(WritePng, FullDiskLeavesNoHalfFile) {
  const TempDir temp_dir;
  const std::string path = temp_dir / "a.png";
  WritePng(path, RandomImage(20, 10, 1));
  const cv::Mat old = cv::imread(path);
  WritePng(temp_dir / "b.png", RandomImage(40, 30, 2));
  const size_t num_bytes = std::filesystem::file_size(temp_dir / "b.png");
  {
    const ScopedFileSizeLimit limit(num_bytes - 1);
    try {
      WritePng(path, RandomImage(40, 30, 2));
      ADD_FAILURE();
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("a.png could not be written"));
    }
  }
  EXPECT_EQ(cv::norm(cv::imread(path), old, cv::NORM_INF), 0);
}

}  // namespace
}  // namespace structnerf
