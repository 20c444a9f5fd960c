#include "colmap_plugin/evaluation/cloud_evaluation.h"

#include "colmap_plugin/input_check.h"
#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>

#include <colmap/geometry/sim3.h>
#include <colmap/util/endian.h>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

// A wall in 4 units, which is 2 metres, of a model far from the origin, and a
// cloud in double precision that is 3 cm behind it.
TEST(CloudEvaluationTest, KeepsCentimetresFarFromTheOrigin) {
  const TempDir temp_dir;
  const TinyModel tiny = MakeTinyModel(3);
  tiny.WriteModel(temp_dir / "sparse");
  tiny.WriteImages(temp_dir / "images");
  std::filesystem::create_directories(temp_dir / "depth");
  for (const TinyModel::Image& image : tiny.images) {
    cv::imwrite(temp_dir / "depth/" + image.name,
                cv::Mat(48, 64, CV_16UC1, cv::Scalar(2000)));
  }
  colmap::Reconstruction model = ReadModel(temp_dir / "sparse");
  const Eigen::Vector3d offset(4.5e6, 5.6e6, 117);
  model.Transform(colmap::Sim3d(1, Eigen::Quaterniond::Identity(), offset));

  const std::string ply_path = temp_dir / "fused.ply";
  std::ofstream file(ply_path, std::ios::binary);
  file << "ply\nformat binary_little_endian 1.0\nelement vertex 400\n"
          "property double x\nproperty double y\nproperty double z\n"
          "end_header\n";
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d point =
        offset + Eigen::Vector3d(0.05 * (i % 20), 0.05 * (i / 20 - 10), 4.06);
    for (const double value : point) {
      colmap::WriteBinaryLittleEndian<double>(&file, value);
    }
  }
  file.close();

  DepthTruthOptions truth_options;
  truth_options.path = temp_dir / "depth";
  TruthViews truth(model, temp_dir / "images", truth_options);
  Progress progress;
  StageProgress stage("Evaluating the cloud", &progress);
  CloudEvaluationOptions options;
  options.mask_unobserved = true;
  const CloudEvaluation evaluation =
      EvaluateCloud(ply_path, 0.5, options, &truth, &stage);
  EXPECT_EQ(evaluation.num_fused_points, 400);
  EXPECT_EQ(evaluation.num_unobserved_points, 0);
  EXPECT_NEAR(evaluation.metrics.accuracy_median, 0.03, 0.003);
  EXPECT_EQ(evaluation.metrics.precision[1], 1);
  EXPECT_EQ(evaluation.metrics.precision[0], 0);
}

}  // namespace
}  // namespace structnerf
