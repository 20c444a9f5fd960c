#include "colmap_plugin/masks.h"

#include "colmap_plugin/input_check.h"
#include "nerf/progress.h"
#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/file_size_limit.h"
#include "tests/support/temp_dir.h"

#include <algorithm>
#include <filesystem>
#include <string>

#include <colmap/image/undistortion.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

// The right part from column `first_col` on is used.
void WriteMask(const std::string& path, int width, int height, int first_col) {
  cv::Mat mask(height, width, CV_8U, cv::Scalar(0));
  mask.colRange(first_col, width) = 3;
  std::filesystem::create_directories(
      std::filesystem::path(path).parent_path());
  ASSERT_TRUE(cv::imwrite(path, mask));
}

TEST(Masks, AnythingButBlackIsUsed) {
  const TempDir temp_dir;
  WriteMask(temp_dir / "sub/a.jpg.png", 8, 6, 5);
  const auto mask = ReadMask(temp_dir.Path(), "sub/a.jpg", 8, 6);
  ASSERT_EQ(mask.size(), 48);
  for (int i = 0; i < 48; ++i) {
    EXPECT_EQ(mask[i], i % 8 >= 5 ? 255 : 0);
  }
}

TEST(Masks, MissingMaskIsEmpty) {
  const TempDir temp_dir;
  EXPECT_THAT(ReadMask(temp_dir.Path(), "a.jpg", 8, 6), IsEmpty());
}

TEST(Masks, NamesMaskOfWrongSizeOrFormat) {
  const TempDir temp_dir;
  WriteMask(temp_dir / "a.jpg.png", 8, 7, 5);
  try {
    ReadMask(temp_dir.Path(), "a.jpg", 8, 6);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("a.jpg.png is 8x7"));
  }
  std::filesystem::resize_file(temp_dir / "a.jpg.png", 10);
  EXPECT_THROW(ReadMask(temp_dir.Path(), "a.jpg", 8, 6), std::runtime_error);
}

// From "masks" to "out".
void UndistortAll(const colmap::Reconstruction& reconstruction,
                  const TempDir& temp_dir) {
  UndistortMasks(reconstruction,
                 temp_dir / "masks",
                 temp_dir / "out",
                 /*num_threads=*/2,
                 /*stop=*/[]() { return false; });
}

TEST(Masks, AreUndistortedLikeTheirImages) {
  const TempDir temp_dir;
  TinyModel model = MakeTinyModel(3);
  model.cameras[0] = {"SIMPLE_RADIAL", 64, 48, {60, 32, 24, 0.3}};
  model.images[1].name = "sub/1.png";
  model.WriteModel(temp_dir / "sparse");
  const auto reconstruction = ReadModel(temp_dir / "sparse");
  const colmap::Camera& camera = reconstruction.Camera(1);
  const colmap::Camera undistorted =
      colmap::UndistortCamera(colmap::UndistortCameraOptions(), camera);
  ASSERT_NE(undistorted.width, camera.width);

  WriteMask(temp_dir / "masks/0.png.png", 64, 48, 45);
  WriteMask(temp_dir / "masks/sub/1.png.png", 64, 48, 0);
  UndistortAll(reconstruction, temp_dir);
  EXPECT_FALSE(std::filesystem::exists(temp_dir / "out/2.png.png"));
  EXPECT_TRUE(std::filesystem::exists(temp_dir / "out/sub/1.png.png"));

  const int width = static_cast<int>(undistorted.width);
  const int height = static_cast<int>(undistorted.height);
  const auto mask = ReadMask(temp_dir / "out", "0.png", width, height);
  ASSERT_EQ(mask.size(), width * height);
  for (int row = 0; row < height; ++row) {
    for (int col = 0; col < width; ++col) {
      // Where this pixel's centre is in the original image: SIMPLE_RADIAL
      // scales by 1 + k r^2.
      const double u = (col + 0.5 - undistorted.PrincipalPointX()) /
                       undistorted.FocalLength();
      const double v = (row + 0.5 - undistorted.PrincipalPointY()) /
                       undistorted.FocalLength();
      const double x = 60 * u * (1 + 0.3 * (u * u + v * v)) + 32;
      const double y = 60 * v * (1 + 0.3 * (u * u + v * v)) + 24;
      const bool is_inside = x > 1 && x < 63 && y > 1 && y < 47;
      if (is_inside && std::abs(x - 45) > 0.6) {
        EXPECT_EQ(mask[row * width + col], x > 45 ? 255 : 0)
            << col << " " << row;
      }
    }
  }
}

// Wherever the file that is being written ends.
TEST(Masks, FullDiskIsNotTakenForABrokenMask) {
  const TempDir temp_dir;
  TinyModel model = MakeTinyModel(2);
  model.cameras[0] = {"SIMPLE_RADIAL", 64, 48, {60, 32, 24, 0.3}};
  model.WriteModel(temp_dir / "sparse");
  const auto reconstruction = ReadModel(temp_dir / "sparse");
  WriteMask(temp_dir / "masks/0.png.png", 64, 48, 45);
  UndistortAll(reconstruction, temp_dir);
  const auto num_bytes = [&](const std::string& name) {
    return std::filesystem::file_size(temp_dir / name);
  };
  // What is written besides, between the two, is larger: its border is blurred.
  const size_t max_bytes =
      std::max(num_bytes("masks/0.png.png"), num_bytes("out/0.png.png"));
  for (size_t limit = 0; limit <= max_bytes; limit += 10) {
    const ScopedFileSizeLimit full_disk(limit);
    try {
      UndistortAll(reconstruction, temp_dir);
      ADD_FAILURE() << limit << " bytes";
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("out/0.png.png could not be"));
    }
  }
}

TEST(Masks, StopInBetween) {
  const TempDir temp_dir;
  const TinyModel model = MakeTinyModel(3);
  model.WriteModel(temp_dir / "sparse");
  for (const TinyModel::Image& image : model.images) {
    WriteMask(temp_dir / ("masks/" + image.name + ".png"), 64, 48, 20);
  }
  int num_asked = 0;
  EXPECT_THROW(UndistortMasks(ReadModel(temp_dir / "sparse"),
                              temp_dir / "masks",
                              temp_dir / "out",
                              /*num_threads=*/1,
                              [&]() { return ++num_asked == 3; }),
               Aborted);
  EXPECT_TRUE(std::filesystem::exists(temp_dir / "out/1.png.png"));
  EXPECT_FALSE(std::filesystem::exists(temp_dir / "out/2.png.png"));
}

TEST(Masks, OfUndistortedCamerasAreCopied) {
  const TempDir temp_dir;
  const TinyModel model = MakeTinyModel(2);
  model.WriteModel(temp_dir / "sparse");
  WriteMask(temp_dir / "masks/0.png.png", 64, 48, 20);
  UndistortAll(ReadModel(temp_dir / "sparse"), temp_dir);
  EXPECT_EQ(ReadMask(temp_dir / "out", "0.png", 64, 48),
            ReadMask(temp_dir / "masks", "0.png", 64, 48));
}

}  // namespace
}  // namespace structnerf
