#include "colmap_plugin/evaluation/truth_views.h"

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/evaluation/pixel_lookup.h"
#include "colmap_plugin/evaluation/texture_mask.h"
#include "colmap_plugin/image_file.h"

#include <filesystem>
#include <stdexcept>
#include <utility>

#include <opencv2/imgproc.hpp>

namespace structnerf {

void CheckTruth(const DepthTruthOptions& truth,
                const std::string& input_path,
                const std::string& image_path) {
  if (input_path.empty() != image_path.empty()) {
    throw std::runtime_error(
        "The options --input_path and --image_path, the original model and "
        "images that ground truth belongs to, go together.");
  }
  if (!truth.path.empty()) {
    truth.Check();
  }
}

TruthViews::TruthViews(const colmap::Reconstruction& model,
                       std::string image_path,
                       const DepthTruthOptions& options)
    : model_(model), image_path_(std::move(image_path)), truth_(options) {
  for (const colmap::image_t image_id : RegisteredImageIds(model)) {
    const std::string& name = model.Image(image_id).Name();
    if (truth_.Has(name)) {
      image_ids_.emplace(name, image_id);
    } else {
      ++num_without_truth_;
    }
  }
  if (image_ids_.empty()) {
    throw std::runtime_error(
        "No image of the model has ground truth in the folder " + options.path +
        " of --ground_truth_path; the depth of a/b.jpg is looked for in "
        "a/b.png and a/b.jpg.png.");
  }
  for (const auto& entry : image_ids_) {
    names_.push_back(entry.first);
  }
}

const colmap::Image& TruthViews::Image(const std::string& name) const {
  return model_.Image(image_ids_.at(name));
}

const colmap::Camera& TruthViews::Camera(const std::string& name) const {
  return model_.Camera(Image(name).CameraId());
}

cv::Mat1f TruthViews::Depth(const std::string& name) const {
  return truth_.ReadMasked(name, Camera(name));
}

cv::Mat1b TruthViews::Textured(const std::string& name,
                               const cv::Size size) const {
  const std::string path = (std::filesystem::path(image_path_) / name).string();
  const cv::Mat1b image = ReadGreyImage(path);
  if (image.empty()) {
    throw std::runtime_error("The image " + path +
                             ", which belongs to ground truth, cannot be "
                             "read; is --image_path right?");
  }
  cv::Mat1b textured = TextureMask(image);
  if (textured.size() != size) {
    cv::resize(textured, textured, size, 0, 0, cv::INTER_NEAREST);
  }
  return textured;
}

const cv::Mat2d& TruthViews::Rays(const std::string& name,
                                  const cv::Size size) {
  const colmap::Camera& camera = Camera(name);
  if (camera.camera_id != rays_camera_id_ || rays_.size() != size) {
    rays_ = GridRays(camera, size, kPixelCenter);
    rays_camera_id_ = camera.camera_id;
  }
  return rays_;
}

SceneScale TruthViews::EstimateScale() const {
  SceneScaleEstimator estimator;
  for (const std::string& name : names_) {
    estimator.AddImage(model_, Image(name), truth_.Read(name, Camera(name)));
  }
  return estimator.Estimate();
}

}  // namespace structnerf
