#include "colmap_plugin/image_decisions.h"

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/input_check.h"
#include "colmap_plugin/masks.h"
#include "colmap_plugin/text_output.h"

#include <algorithm>
#include <filesystem>
#include <string>

namespace structnerf {
namespace {

std::string CountText(const size_t part, const size_t whole) {
  return std::to_string(part) + " of " + std::to_string(whole);
}

std::string DetailText(const ImageDetail& detail) {
  return detail.tried_size > 0
             ? ", at " + std::to_string(detail.tried_size) +
                   FormatNumber(" pixels %.1f of 255 grey levels are lost",
                                detail.lost_grey_levels)
             : "";
}

}  // namespace

std::vector<SceneDecision> DescribeImages(
    const StructNerfOptions& options,
    const colmap::Reconstruction& reconstruction,
    const ImageDetail& detail,
    const int max_image_size) {
  const auto image_ids = RegisteredImageIds(reconstruction);
  size_t num_distorted = 0;
  size_t num_masked = 0;
  size_t longest_side = 0;
  for (const colmap::image_t image_id : image_ids) {
    const colmap::Image& image = reconstruction.Image(image_id);
    const colmap::Camera& camera = reconstruction.Camera(image.CameraId());
    num_distorted += !camera.IsUndistorted();
    longest_side = std::max({longest_side,
                             static_cast<size_t>(camera.width),
                             static_cast<size_t>(camera.height)});
    num_masked +=
        !options.mask_path.empty() &&
        std::filesystem::exists(MaskPath(options.mask_path, image.Name()));
  }
  return {{"undistortion",
           num_distorted > 0 ? "on" : "off",
           CountText(num_distorted, image_ids.size()) +
               " images were taken with a lens that distorts"},
          {"training images",
           "at most " + std::to_string(max_image_size) + " pixels",
           "the photographs have up to " + std::to_string(longest_side) +
               DetailText(detail)},
          {"masks",
           num_masked > 0 ? "on" : "off",
           CountText(num_masked, image_ids.size()) + " images have one"}};
}

ImageDetail ChooseImageSize(const colmap::Reconstruction& reconstruction,
                            StructNerfOptions* options) {
  int& image_size = options->reconstruction.training.max_image_size;
  ImageDetail detail{image_size};
  if (options->image_size_from_detail) {
    detail = MeasureImageDetail(
        options->image_path, ImageNames(reconstruction), image_size);
    image_size = detail.image_size;
  }
  return detail;
}

}  // namespace structnerf
