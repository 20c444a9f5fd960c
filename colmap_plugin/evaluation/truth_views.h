#pragma once

#include "colmap_plugin/evaluation/depth_truth.h"
#include "colmap_plugin/evaluation/scene_scale.h"

#include <map>
#include <string>
#include <vector>

#include <colmap/scene/reconstruction.h>

#include <opencv2/core.hpp>

namespace structnerf {

// The images that ground truth belongs to, with the cameras they were taken
// with. Dense maps are made for undistorted images; truth stays where it was
// measured, and is compared with what a map says along the same rays.
class TruthViews {
 public:
  // `model` and `image_path` are the original images' (or those of an
  // undistorted workspace, if the truth was undistorted, too). Throws
  // std::runtime_error if no image of the model has truth. `model` must outlive
  // this object.
  TruthViews(const colmap::Reconstruction& model,
             std::string image_path,
             const DepthTruthOptions& options);

  // Registered images that have truth, ascending.
  const std::vector<std::string>& Names() const { return names_; }

  // Registered images that have none.
  size_t NumWithoutTruth() const { return num_without_truth_; }

  const colmap::Image& Image(const std::string& name) const;
  const colmap::Camera& Camera(const std::string& name) const;

  // Whether some truth is not to be compared with.
  bool HasMasks() const { return truth_.HasMasks(); }

  // Metres, 0 = no value, or none that is to be compared with.
  cv::Mat1f Depth(const std::string& name) const;

  // Which pixels of the truth, which has `size`, see texture (255, else 0).
  // Throws std::runtime_error if the photograph cannot be read.
  cv::Mat1b Textured(const std::string& name, cv::Size size) const;

  // The ray of every pixel of the truth, which has `size`. Valid until the next
  // call.
  const cv::Mat2d& Rays(const std::string& name, cv::Size size);

  // Looks at the truth of all images.
  SceneScale EstimateScale() const;

 private:
  const colmap::Reconstruction& model_;
  const std::string image_path_;
  const DepthTruth truth_;
  std::map<std::string, colmap::image_t> image_ids_;
  std::vector<std::string> names_;
  size_t num_without_truth_ = 0;

  // Of the last call of Rays(); most models have one camera.
  colmap::camera_t rays_camera_id_ = colmap::kInvalidCameraId;
  cv::Mat2d rays_;
};

// Throws std::runtime_error, naming the option, if one is wrong. An empty
// `truth.path` is no truth, empty `input_path` and `image_path` mean that it
// belongs to undistorted images.
void CheckTruth(const DepthTruthOptions& truth,
                const std::string& input_path,
                const std::string& image_path);

}  // namespace structnerf
