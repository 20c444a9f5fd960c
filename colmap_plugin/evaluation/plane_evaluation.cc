#include "colmap_plugin/evaluation/plane_evaluation.h"

#include "colmap_plugin/evaluation/pixel_lookup.h"
#include "colmap_plugin/image_file.h"
#include "colmap_plugin/scene_converter.h"

#include <filesystem>
#include <stdexcept>

#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

// The photograph at the size of the depth map.
cv::Mat3b ReadPhotograph(const std::string& path, const cv::Size size) {
  cv::Mat3b image = ReadColorImage(path);
  if (image.empty()) {
    throw std::runtime_error("The undistorted image " + path +
                             " cannot be read.");
  }
  if (image.size() != size) {
    cv::resize(image, image, size, 0, 0, cv::INTER_AREA);
  }
  return image;
}

}  // namespace

PlaneEvaluation EvaluatePlanes(const DepthEvaluation& depth,
                               const DepthSource& source,
                               const double offset,
                               const std::string& image_path,
                               const TruthViews& truth,
                               StageProgress* progress) {
  PlaneEvaluation evaluation;
  size_t num_done = 0;
  for (const ImageDepthMetrics& image : depth.images) {
    progress->Report(num_done++, depth.images.size());
    if (image.metres_per_unit <= 0) {
      continue;
    }
    const std::optional<PredictedDepth> predicted = source(image.name);
    const cv::Size size = predicted->depth.size();
    const auto regions = FindPlanarRegions(ReadPhotograph(
        (std::filesystem::path(image_path) / image.name).string(), size));
    const PinholeCamera camera =
        ToPinholeCamera(predicted->camera).Resized(size.width, size.height);
    evaluation.predicted.AddView(
        camera, offset, regions, predicted->depth * image.metres_per_unit);
    // The truth along the rays of the map.
    evaluation.truth.AddView(camera,
                             offset,
                             regions,
                             LookUp(GridRays(predicted->camera, size, offset),
                                    truth.Camera(image.name),
                                    truth.Depth(image.name)));
  }
  return evaluation;
}

}  // namespace structnerf
