#include "colmap_plugin/evaluation/evaluator.h"

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/dense_workspace.h"
#include "colmap_plugin/evaluation/evaluation_report.h"
#include "colmap_plugin/input_check.h"
#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/synthetic_room.h"
#include "tests/support/synthetic_room_writer.h"
#include "tests/support/temp_dir.h"

#include <filesystem>

#include <colmap/util/ply.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::Contains;
using testing::HasSubstr;

StereoMaps ConstantMaps(const int width, const int height, const float depth) {
  const size_t num_pixels = static_cast<size_t>(width) * height;
  return {width,
          height,
          std::vector<float>(num_pixels, depth),
          std::vector<float>(3 * num_pixels, 0.0f)};
}

// Three views of a wall in a depth of 4 units, which is 2 metres.
class EvaluatorTest : public testing::Test {
 protected:
  EvaluatorTest() : workspace_(temp_dir_ / "dense") {
    const TinyModel model = MakeTinyModel(3);
    model.WriteModel(workspace_.SparsePath());
    model.WriteImages(workspace_.ImagesPath());
    workspace_.CreateFolders({"0.png", "1.png", "2.png"});
    fs::create_directories(temp_dir_ / "depth");
    for (const char* name : {"0.png", "1.png", "2.png"}) {
      cv::imwrite(temp_dir_ / "depth/" + name,
                  cv::Mat(48, 64, CV_16UC1, cv::Scalar(2000)));
    }
    options_.workspace_path = workspace_.Path();
    options_.truth.path = temp_dir_ / "depth";
  }

  void WriteMaps(const std::string& name, const float depth) const {
    workspace_.WriteMaps(
        name, MapType::kPhotometric, ConstantMaps(64, 48, depth));
  }

  std::string Error() {
    try {
      Evaluate(options_, &progress_);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  TempDir temp_dir_;
  DenseWorkspace workspace_;
  EvaluationOptions options_;
  RunProgress progress_;
};

// Whose unit is another one.
TEST_F(EvaluatorTest, AnotherModelIsRefused) {
  WriteMaps("0.png", 4);
  TinyModel model = MakeTinyModel(3);
  model.WriteModel(temp_dir_ / "same");
  model.WriteImages(temp_dir_ / "images");
  options_.image_path = temp_dir_ / "images";
  options_.input_path = temp_dir_ / "same";
  EXPECT_EQ(Error(), "");
  for (TinyModel::Image& image : model.images) {
    image.x *= 10;
  }
  for (Eigen::Vector3d& point : model.points) {
    point *= 10;
  }
  model.WriteModel(temp_dir_ / "other");
  options_.input_path = temp_dir_ / "other";
  EXPECT_THAT(Error(), HasSubstr("is not the one that the workspace"));
  EXPECT_THAT(Error(), HasSubstr("--input_path"));
}

TEST_F(EvaluatorTest, TheTruthHasNoError) {
  for (const char* name : {"0.png", "1.png", "2.png"}) {
    WriteMaps(name, 4);
  }
  const Evaluation evaluation = Evaluate(options_, &progress_);
  EXPECT_NEAR(evaluation.scale.metres_per_unit, 0.5, 1e-9);
  const DepthEvaluation& depth = evaluation.maps.at("photometric").depth;
  for (const auto& metrics :
       {depth.in_sfm_scale, depth.in_predictions_scale, depth.in_image_scale}) {
    ASSERT_TRUE(metrics.has_value());
    EXPECT_EQ(metrics->all.num_pixels, 3 * 48 * 64);
    EXPECT_EQ(metrics->all.completeness, 1);
    EXPECT_LT(metrics->all.rmse, 1e-6);
    EXPECT_EQ(metrics->all.within[0], 1);
  }
  EXPECT_THAT(evaluation.notes, Contains(HasSubstr("no geometric depth maps")));
  EXPECT_THAT(evaluation.notes, Contains(HasSubstr("no trained field")));
}

TEST_F(EvaluatorTest, KnownOffsetsGiveKnownErrors) {
  WriteMaps("0.png", 4.1f);   // 5 cm too far
  WriteMaps("1.png", 3.84f);  // 8 cm too near
  const Evaluation evaluation = Evaluate(options_, &progress_);
  const DepthEvaluation& depth = evaluation.maps.at("photometric").depth;
  EXPECT_EQ(depth.num_images, 3);
  EXPECT_EQ(depth.num_images_without_map, 1);
  const DepthMetrics& metrics = depth.in_sfm_scale->all;
  EXPECT_NEAR(metrics.completeness, 2.0 / 3, 1e-9);
  EXPECT_NEAR(metrics.rmse, std::sqrt((0.05 * 0.05 + 0.08 * 0.08) / 2), 1e-6);
  EXPECT_EQ(metrics.within[0], 0);
  EXPECT_NEAR(metrics.within[1], 1.0 / 3, 1e-9);
  EXPECT_NEAR(metrics.within[2], 2.0 / 3, 1e-9);
  // A scale for each image hides all of it.
  EXPECT_LT(depth.in_image_scale->all.rmse, 1e-6);
  EXPECT_NEAR(depth.images[0].metrics.rmse, 0.05, 1e-6);
  EXPECT_NEAR(depth.images[0].metres_per_unit, 2 / 4.1, 1e-6);
  EXPECT_FALSE(depth.images[2].has_map);
  // The pictures are noise, which is texture.
  EXPECT_EQ(depth.textured_share, 1);
  EXPECT_EQ(depth.in_sfm_scale->untextured.num_pixels, 0);
}

TEST_F(EvaluatorTest, ImagesWithoutTruthAreCounted) {
  WriteMaps("0.png", 4);
  fs::remove(temp_dir_ / "depth/1.png");
  const Evaluation evaluation = Evaluate(options_, &progress_);
  EXPECT_EQ(evaluation.num_images_without_truth, 1);
  EXPECT_EQ(evaluation.maps.at("photometric").depth.num_images, 2);
  EXPECT_THAT(evaluation.notes, Contains(HasSubstr("1 registered image")));
}

TEST_F(EvaluatorTest, ConfidenceIsComparedWithTheError) {
  WriteMaps("0.png", 4.1f);  // 2.5 % too far, which counts as right
  WriteMaps("1.png", 4.3f);  // 7.5 %
  WriteMaps("2.png", 4);
  workspace_.WriteConfidence(
      "0.png", 64, 48, std::vector<float>(64 * 48, 0.85f));
  workspace_.WriteConfidence(
      "1.png", 64, 48, std::vector<float>(64 * 48, 0.35f));
  const Evaluation evaluation = Evaluate(options_, &progress_);
  ASSERT_TRUE(evaluation.confidence.has_value());
  EXPECT_EQ(evaluation.confidence->NumPixels(), 2 * 64 * 48);
  EXPECT_EQ(evaluation.confidence->ShareRight(8), 1);
  EXPECT_EQ(evaluation.confidence->ShareRight(3), 0);
  EXPECT_NEAR(evaluation.confidence->CalibrationError(), 0.25, 1e-6);
  EXPECT_THAT(EvaluationText(evaluation), HasSubstr("calibration error 0.250"));
  const auto json = nlohmann::json::parse(EvaluationJson(evaluation));
  EXPECT_EQ(json["confidence"]["bins"][8]["right"], 1);
  EXPECT_TRUE(json["confidence"]["bins"][0]["right"].is_null());

  workspace_.WriteConfidence("1.png", 2, 2, std::vector<float>(4, 0.35f));
  EXPECT_THAT(Error(), HasSubstr("1.png have different sizes"));
}

TEST_F(EvaluatorTest, CloudIsMeasuredInMetres) {
  std::vector<colmap::PlyPoint> points;
  for (int i = 0; i < 400; ++i) {
    colmap::PlyPoint point;
    point.x = 0.05f * (i % 20);
    point.y = 0.05f * (i / 20 - 10);
    point.z = 4.06f;  // 3 cm behind the wall
    points.push_back(point);
  }
  colmap::PlyPoint unobserved;
  unobserved.z = -4;
  points.push_back(unobserved);
  colmap::WriteBinaryPlyPoints(workspace_.FusedPath(), points);
  const Evaluation all = Evaluate(options_, &progress_);
  ASSERT_TRUE(all.cloud.has_value());
  EXPECT_EQ(all.cloud->num_fused_points, 401);
  EXPECT_NEAR(all.cloud->metrics.accuracy_median, 0.03, 0.003);
  EXPECT_NEAR(all.cloud->metrics.precision[1], 400 / 401.0, 1e-9);
  EXPECT_EQ(all.cloud->metrics.precision[0], 0);
  EXPECT_GT(all.cloud->metrics.recall[1], 0.05);
  EXPECT_LT(all.cloud->metrics.recall[1], 0.5);

  options_.cloud.mask_unobserved = true;
  const Evaluation observed = Evaluate(options_, &progress_);
  EXPECT_EQ(observed.cloud->num_unobserved_points, 1);
  EXPECT_EQ(observed.cloud->metrics.precision[1], 1);

  // Where the truth is masked, nothing is compared, whatever is said of what
  // nobody has measured.
  options_.cloud.mask_unobserved = false;
  options_.truth.mask_path = temp_dir_ / "truth_masks";
  fs::create_directories(options_.truth.mask_path);
  cv::Mat1b mask(48, 64, uchar{255});
  mask.rowRange(0, 24) = 0;
  for (const char* name : {"0.png", "1.png", "2.png"}) {
    cv::imwrite(options_.truth.mask_path + "/" + name, mask);
  }
  const Evaluation masked = Evaluate(options_, &progress_);
  EXPECT_GT(masked.cloud->num_unobserved_points, 100);
  EXPECT_EQ(masked.cloud->metrics.precision[1], 1);
}

TEST_F(EvaluatorTest, AnEmptyCloudIsNotPerfect) {
  colmap::WriteBinaryPlyPoints(workspace_.FusedPath(), {});
  const std::string text = EvaluationText(Evaluate(options_, &progress_));
  EXPECT_THAT(text, HasSubstr("accuracy - cm (median -), completeness - cm"));
}

TEST_F(EvaluatorTest, JsonSaysWhatIsNotKnown) {
  WriteMaps("0.png", 4);
  const auto json =
      nlohmann::json::parse(EvaluationJson(Evaluate(options_, &progress_)));
  const auto& maps = json["maps"]["photometric"];
  EXPECT_EQ(maps["images_without_map"], 2);
  EXPECT_NEAR(maps["sfm_scale"]["all"]["within_2cm"], 1.0 / 3, 1e-9);
  EXPECT_TRUE(maps["sfm_scale"]["untextured"]["rmse_m"].is_null());
  EXPECT_TRUE(maps["per_image"][1]["metres_per_unit"].is_null());
  EXPECT_FALSE(json.contains("held_out"));
  EXPECT_FALSE(json["maps"].contains("geometric"));
}

TEST_F(EvaluatorTest, OneErrorForBadInput) {
  EXPECT_THAT(Error(), HasSubstr("Nothing to evaluate"));
  WriteMaps("0.png", 4);
  options_.truth.scale = 1;
  EXPECT_THAT(Error(), HasSubstr("--depth_scale"));
  options_.truth.scale = 1000;
  options_.image_path = workspace_.ImagesPath();
  EXPECT_THAT(Error(), HasSubstr("--input_path and --image_path"));
  options_.image_path.clear();
  options_.held_out.test_workspace_path = workspace_.Path();
  EXPECT_THAT(Error(), HasSubstr("no trained field"));
  options_.held_out.test_workspace_path.clear();
  options_.truth.path = workspace_.ImagesPath() + "/..";
  EXPECT_THAT(Error(), HasSubstr("No image of the model has ground truth"));
  options_.workspace_path = temp_dir_ / "none";
  EXPECT_THAT(Error(), HasSubstr("does not exist"));
}

// The truth belongs to distorted photographs; the maps are what an undistorted
// camera sees of the same room.
TEST(EvaluatorRoomTest, TheTruthHasNoErrorThroughDistortion) {
  SyntheticRoomOptions room_options;
  room_options.num_views = 4;
  room_options.width = 160;
  room_options.height = 120;
  room_options.camera_models = {"OPENCV"};
  room_options.world_scale = 2.5;
  const SyntheticRoom room = MakeSyntheticRoom(room_options);
  const TempDir temp_dir;
  WriteSyntheticRoom(room, temp_dir / "room");
  const colmap::Reconstruction original = ReadModel(temp_dir / "room/sparse/0");
  const DenseWorkspace workspace(temp_dir / "dense");
  fs::create_directories(workspace.Path());
  CreateUndistortedWorkspace(
      original, temp_dir / "room/images", workspace.Path(), []() {
        return false;
      });
  const colmap::Reconstruction undistorted = ReadModel(workspace.SparsePath());
  for (size_t i = 0; i < room.images.size(); ++i) {
    const std::string& name = room.images[i].name;
    const colmap::Camera& camera =
        undistorted.Camera(undistorted.FindImageWithName(name)->CameraId());
    StereoMaps maps = ConstantMaps(
        static_cast<int>(camera.width), static_cast<int>(camera.height), 0);
    for (int row = 0; row < maps.height; ++row) {
      for (int col = 0; col < maps.width; ++col) {
        const Eigen::Vector3d ray(
            (col + 0.5 - camera.PrincipalPointX()) / camera.FocalLengthX(),
            (row + 0.5 - camera.PrincipalPointY()) / camera.FocalLengthY(),
            1);
        maps.depth[static_cast<size_t>(row) * maps.width + col] =
            static_cast<float>(
                CastIntoRoom(room, i, room.cameras[0].Project(ray)).depth);
      }
    }
    workspace.WriteMaps(name, MapType::kGeometric, maps);
  }

  EvaluationOptions options;
  options.workspace_path = workspace.Path();
  options.input_path = temp_dir / "room/sparse/0";
  options.image_path = temp_dir / "room/images";
  options.truth.path = temp_dir / "room/depth";
  RunProgress progress;
  const Evaluation evaluation = Evaluate(options, &progress);
  const MapEvaluation& maps = evaluation.maps.at("geometric");
  EXPECT_NEAR(evaluation.scale.metres_per_unit, 1 / 2.5, 0.004);
  const SplitDepthMetrics& metrics = *maps.depth.in_predictions_scale;
  // The undistorted images show a little less.
  EXPECT_GT(metrics.all.completeness, 0.9);
  // What remains is half a pixel on slanted surfaces and at edges.
  EXPECT_LT(metrics.all.median_error, 0.005);
  EXPECT_LT(metrics.all.abs_rel, 0.01);
  EXPECT_GT(metrics.textured.num_pixels, 0);
  EXPECT_GT(metrics.untextured.num_pixels, 0);
  EXPECT_NEAR(maps.planes.predicted.Mean(),
              maps.planes.truth.Mean(),
              0.1 * maps.planes.truth.Mean());

  // It does not fit to the undistorted images.
  options.input_path.clear();
  options.image_path.clear();
  try {
    Evaluate(options, &progress);
    ADD_FAILURE();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("pass their model as --input_path"));
  }
}

}  // namespace
}  // namespace structnerf
