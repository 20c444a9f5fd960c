// Distorted cameras of several models and sizes in one sparse model, images in
// sub-folders, masks, and a world that is large and far from its origin.

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/input_check.h"
#include "nerf/util/median.h"
#include "tests/end_to_end/run_program.h"
#include "tests/support/synthetic_room.h"
#include "tests/support/synthetic_room_writer.h"
#include "tests/support/temp_dir.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <colmap/mvs/depth_map.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

SyntheticRoomOptions MakeOptions() {
  SyntheticRoomOptions options;
  options.num_views = 12;
  options.width = 200;
  options.height = 150;
  options.camera_models = {"OPENCV", "SIMPLE_RADIAL", "OPENCV_FISHEYE"};
  options.sub_folders = true;
  options.world_scale = 7;
  options.world_rotation =
      Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, 2, 3).normalized());
  options.world_translation = {50000, -30000, 2000};
  return options;
}

int FindImage(const SyntheticRoom& room, const std::string& name) {
  const auto it = std::find_if(
      room.images.begin(), room.images.end(), [&](const SyntheticImage& image) {
        return image.name == name;
      });
  return static_cast<int>(it - room.images.begin());
}

TEST(VariedCameras, DepthIsThatOfTheModel) {
  const TempDir temp_dir;
  const SyntheticRoom room = MakeSyntheticRoom(MakeOptions());
  WriteSyntheticRoom(room, temp_dir / "room");
  // The lower third of one original image is masked.
  const SyntheticImage& masked_image = room.images[4];
  cv::Mat mask(masked_image.pixels.height,
               masked_image.pixels.width,
               CV_8U,
               cv::Scalar(255));
  const int first_masked_row = mask.rows * 2 / 3;
  mask.rowRange(first_masked_row, mask.rows) = 0;
  const fs::path mask_path =
      temp_dir.Path() / "masks" / (masked_image.name + ".png");
  fs::create_directories(mask_path.parent_path());
  cv::imwrite(mask_path.string(), mask);

  const ProgramResult result = RunProgram({"structnerf_dense",
                                           "--image_path",
                                           temp_dir / "room/images",
                                           "--input_path",
                                           temp_dir / "room/sparse/0",
                                           "--output_path",
                                           temp_dir / "dense",
                                           "--mask_path",
                                           temp_dir / "masks",
                                           "--StructNeRF.quality=low",
                                           "--StructNeRF.num_steps=300"});
  ASSERT_EQ(result.exit_code, 0) << result.error;

  const auto model = ReadModel(temp_dir / "dense/sparse");
  ASSERT_EQ(model.NumRegImages(), room.images.size());
  std::vector<double> ratios;
  for (const colmap::image_t image_id : RegisteredImageIds(model)) {
    const colmap::Image& image = model.Image(image_id);
    const colmap::Camera& camera = model.Camera(image.CameraId());
    EXPECT_TRUE(camera.IsUndistorted());
    colmap::mvs::DepthMap depth_map;
    depth_map.Read(temp_dir / "dense/stereo/depth_maps/" + image.Name() +
                   ".photometric.bin");
    ASSERT_EQ(depth_map.GetWidth(), camera.width);
    ASSERT_EQ(depth_map.GetHeight(), camera.height);

    const int image_idx = FindImage(room, image.Name());
    ASSERT_LT(image_idx, static_cast<int>(room.images.size()));
    const SyntheticCamera& distorted_camera =
        room.cameras[room.images[image_idx].camera_idx];
    for (size_t row = 2; row < camera.height - 2; row += 7) {
      for (size_t col = 2; col < camera.width - 2; col += 7) {
        const float depth = depth_map.Get(row, col);
        const Eigen::Vector2d point = distorted_camera.Project(
            {(col - camera.PrincipalPointX()) / camera.FocalLengthX(),
             (row - camera.PrincipalPointY()) / camera.FocalLengthY(),
             1});
        if (image.Name() == masked_image.name &&
            point.y() > first_masked_row + 1.5) {
          EXPECT_EQ(depth, 0) << "masked pixel " << col << ", " << row;
        } else if (depth > 0) {
          ratios.push_back(depth / CastIntoRoom(room, image_idx, point).depth);
        }
      }
    }
  }
  // Depth in model units through undistortion, against our own camera models.
  ASSERT_GT(ratios.size(), 2000);
  EXPECT_NEAR(Median(&ratios), 1, 0.03);
  const auto num_close =
      std::count_if(ratios.begin(), ratios.end(), [](const double ratio) {
        return std::abs(ratio - 1) < 0.1;
      });
  EXPECT_GT(num_close, 0.5 * ratios.size());
}

}  // namespace
}  // namespace structnerf
