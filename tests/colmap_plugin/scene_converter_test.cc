#include "colmap_plugin/scene_converter.h"

#include "colmap_plugin/input_check.h"
#include "tests/colmap_plugin/tiny_model.h"
#include "tests/nerf/aborting_progress.h"
#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class SceneConverterTest : public testing::Test {
 protected:
  Scene Convert(const TinyModel& model) {
    model.WriteModel(temp_dir_ / "sparse");
    options_.image_path = temp_dir_ / "images";
    Progress progress;
    return ConvertScene(ReadModel(temp_dir_ / "sparse"), options_, &progress);
  }

  std::string ErrorOf(const TinyModel& model) {
    try {
      Convert(model);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  void WriteImage(const std::string& name, const cv::Mat& image) {
    const std::filesystem::path path = temp_dir_ / ("images/" + name);
    std::filesystem::create_directories(path.parent_path());
    ASSERT_TRUE(cv::imwrite(path.string(), image));
  }

  TempDir temp_dir_;
  SceneConverterOptions options_;
};

TEST_F(SceneConverterTest, CopiesCamerasPosesAndPoints) {
  TinyModel model = MakeTinyModel(2);
  model.cameras.push_back({"SIMPLE_PINHOLE", 40, 30, {50, 21, 14}});
  model.images.push_back({"sub/folder/2.png", 1, -1});
  model.WriteImages(temp_dir_ / "images");
  const Scene scene = Convert(model);

  ASSERT_EQ(scene.views.size(), 3);
  EXPECT_NO_THROW(scene.Check());
  const View& view = scene.views[2];
  EXPECT_EQ(view.name, "sub/folder/2.png");
  EXPECT_EQ(view.camera.width, 40);
  EXPECT_EQ(view.camera.height, 30);
  EXPECT_EQ(view.camera.fx, 50);
  EXPECT_EQ(view.camera.fy, 50);
  EXPECT_EQ(view.camera.cx, 21);
  EXPECT_EQ(view.camera.cy, 14);
  EXPECT_LT((view.ProjectionCenter() - Eigen::Vector3d(-1, 0, 0)).norm(), 1e-9);

  ASSERT_EQ(scene.points.size(), 9);
  EXPECT_EQ(scene.points[4].xyz, model.points[4]);
  EXPECT_EQ(scene.points[4].error, 0.5);
  ASSERT_EQ(scene.points[4].track.size(), 3);
  // In the image coordinates of the full-size camera, whatever the image size.
  for (const Observation& observation : scene.points[4].track) {
    const View& seen_by = scene.views[observation.view_idx];
    const Eigen::Vector3d x = seen_by.CamFromWorld(scene.points[4].xyz);
    EXPECT_NEAR(observation.xy.x(),
                seen_by.camera.fx * x.x() / x.z() + seen_by.camera.cx,
                1e-3);
    EXPECT_NEAR(observation.xy.y(),
                seen_by.camera.fy * x.y() / x.z() + seen_by.camera.cy,
                1e-3);
  }
}

TEST_F(SceneConverterTest, UnknownPointErrorStaysUnknown) {
  TinyModel model = MakeTinyModel(2);
  model.point_error = -1;
  model.WriteImages(temp_dir_ / "images");
  EXPECT_EQ(Convert(model).points[0].error, -1);
}

TEST_F(SceneConverterTest, ReducedPixelsCoverTheSameField) {
  // Every reduced pixel is the mean of the 2x2 pixels below it: the corner of
  // the image, not the centre of the first pixel, is the fixed point.
  const TinyModel model = MakeTinyModel(2);
  model.WriteImages(temp_dir_ / "images");
  const cv::Mat full = RandomImage(64, 48, 0);
  options_.max_image_size = 32;
  const Scene scene = Convert(model);
  const RgbImage& image = scene.views[0].image;
  ASSERT_EQ(image.width, 32);
  ASSERT_EQ(image.height, 24);
  for (int row = 0; row < 24; ++row) {
    for (int col = 0; col < 32; ++col) {
      for (int channel = 0; channel < 3; ++channel) {
        int sum = 0;
        for (int i = 0; i < 4; ++i) {
          // OpenCV has blue first.
          sum +=
              full.at<cv::Vec3b>(2 * row + i / 2, 2 * col + i % 2)[2 - channel];
        }
        EXPECT_NEAR(image.data[(row * 32 + col) * 3 + channel], sum / 4.0, 1);
      }
    }
  }
}

TEST_F(SceneConverterTest, NeverEnlargesImages) {
  const TinyModel model = MakeTinyModel(2);
  model.WriteImages(temp_dir_ / "images");
  options_.max_image_size = 1000;
  const Scene scene = Convert(model);
  EXPECT_EQ(scene.views[0].image.width, 64);
  EXPECT_EQ(scene.views[0].image.height, 48);
}

TEST_F(SceneConverterTest, ReadsGreyAnd16BitImages) {
  const TinyModel model = MakeTinyModel(2);
  WriteImage("0.png", cv::Mat(48, 64, CV_8U, cv::Scalar(77)));
  WriteImage("1.png", cv::Mat(48, 64, CV_16UC3, cv::Scalar::all(200 * 256)));
  const Scene scene = Convert(model);
  EXPECT_THAT(scene.views[0].image.data, Each(77));
  EXPECT_THAT(scene.views[1].image.data, Each(200));
}

TEST_F(SceneConverterTest, DoesNotTurnImagesAsExifSays) {
  TinyModel model = MakeTinyModel(2);
  model.images[0].name = "0.jpg";
  model.WriteImages(temp_dir_ / "images");
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", cv::Mat(48, 64, CV_8UC3), jpeg);
  // An EXIF segment that holds nothing but the orientation "turned by 90
  // degrees", put behind the start of the image.
  const std::vector<uint8_t> exif = {
      0xff, 0xe1, 0, 34, 'E', 'x', 'i', 'f', 0,    0,    'I', 'I',
      42,   0,    8, 0,  0,   0,   1,   0,   0x12, 0x01, 3,   0,
      1,    0,    0, 0,  6,   0,   0,   0,   0,    0,    0,   0};
  jpeg.insert(jpeg.begin() + 2, exif.begin(), exif.end());
  const std::string path = temp_dir_ / "images/0.jpg";
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(jpeg.data()), jpeg.size());
  ASSERT_EQ(cv::imread(path).cols, 48) << "the orientation is not understood";

  const Scene scene = Convert(model);
  EXPECT_EQ(scene.views[0].image.width, 64);
  EXPECT_EQ(scene.views[0].image.height, 48);
}

TEST_F(SceneConverterTest, NamesImageThatDiffersFromItsCamera) {
  const TinyModel model = MakeTinyModel(3);
  model.WriteImages(temp_dir_ / "images");
  WriteImage("1.png", RandomImage(64, 47, 0));
  const std::string error = ErrorOf(model);
  EXPECT_THAT(error, HasSubstr("1.png"));
  EXPECT_THAT(error, HasSubstr("64x47"));
  EXPECT_THAT(error, HasSubstr("64x48"));
}

TEST_F(SceneConverterTest, NamesImageThatCannotBeRead) {
  const TinyModel model = MakeTinyModel(3);
  model.WriteImages(temp_dir_ / "images");
  std::ofstream(temp_dir_ / "images/2.png") << "no image";
  EXPECT_THAT(ErrorOf(model), HasSubstr("2.png"));
}

TEST_F(SceneConverterTest, RefusesDistortedCamera) {
  TinyModel model = MakeTinyModel(2);
  model.cameras[0] = {"SIMPLE_RADIAL", 64, 48, {60, 32, 24, 0.1}};
  model.WriteImages(temp_dir_ / "images");
  EXPECT_THAT(ErrorOf(model), HasSubstr("not undistorted"));
}

TEST_F(SceneConverterTest, AcceptsDistortionModelWithoutDistortion) {
  TinyModel model = MakeTinyModel(2);
  model.cameras[0] = {"OPENCV", 64, 48, {60, 61, 32, 24, 0, 0, 0, 0}};
  model.WriteImages(temp_dir_ / "images");
  const Scene scene = Convert(model);
  EXPECT_EQ(scene.views[0].camera.fx, 60);
  EXPECT_EQ(scene.views[0].camera.fy, 61);
}

TEST_F(SceneConverterTest, MaskedPixelsAreIgnored) {
  const TinyModel model = MakeTinyModel(2);
  model.WriteImages(temp_dir_ / "images");
  // The left half and one more column are black, the rest has grey level 1.
  cv::Mat mask(48, 64, CV_8U, cv::Scalar(1));
  mask.colRange(0, 33) = 0;
  std::filesystem::create_directories(temp_dir_ / "masks");
  cv::imwrite(temp_dir_ / "masks/0.png.png", mask);
  options_.mask_path = temp_dir_ / "masks";
  options_.max_image_size = 32;
  const Scene scene = Convert(model);
  EXPECT_THAT(scene.views[1].mask, IsEmpty());
  ASSERT_EQ(scene.views[0].mask.size(), 32 * 24);
  for (int col = 0; col < 32; ++col) {
    // Column 16 covers a masked and an unmasked one.
    EXPECT_EQ(scene.views[0].mask[5 * 32 + col] != 0, col >= 17) << col;
  }
}

TEST_F(SceneConverterTest, SegmentsLargeAreasOfTheReducedImage) {
  const TinyModel model = MakeTinyModel(2);
  model.WriteImages(temp_dir_ / "images");
  cv::Mat halves(48, 64, CV_8UC3, cv::Scalar::all(20));
  halves.colRange(32, 64) = cv::Scalar::all(220);
  WriteImage("0.png", halves);
  options_.max_image_size = 32;

  options_.planar_min_area = 1500;  // of 32 * 48 in the full image
  Scene scene = Convert(model);
  const std::vector<int32_t>& segments = scene.views[0].segments;
  ASSERT_EQ(segments.size(), 32 * 24);
  EXPECT_THAT((std::vector<int32_t>{segments[10 * 32 + 4],
                                    segments[20 * 32 + 12],
                                    segments[10 * 32 + 20],
                                    segments[20 * 32 + 28]}),
              ElementsAre(0, 0, 1, 1));

  options_.planar_min_area = 1600;
  scene = Convert(model);
  EXPECT_THAT(scene.views[0].segments, Each(-1));

  options_.planar_min_area = 0;
  EXPECT_THAT(Convert(model).views[0].segments, IsEmpty());
}

TEST_F(SceneConverterTest, AbortsWhenTold) {
  const TinyModel model = MakeTinyModel(2);
  model.WriteModel(temp_dir_ / "sparse");
  model.WriteImages(temp_dir_ / "images");
  options_.image_path = temp_dir_ / "images";
  AbortingProgress progress;
  EXPECT_THROW(
      ConvertScene(ReadModel(temp_dir_ / "sparse"), options_, &progress),
      Aborted);
}

}  // namespace
}  // namespace structnerf
