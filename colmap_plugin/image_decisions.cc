#include "colmap_plugin/image_decisions.h"

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/masks.h"

#include <algorithm>
#include <filesystem>
#include <string>

namespace structnerf {
namespace {

std::string CountText(const size_t part, const size_t whole) {
  return std::to_string(part) + " of " + std::to_string(whole);
}

}  // namespace

std::vector<SceneDecision> DescribeImages(
    const StructNerfOptions& options,
    const colmap::Reconstruction& reconstruction,
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
           "the photographs have up to " + std::to_string(longest_side)},
          {"masks",
           num_masked > 0 ? "on" : "off",
           CountText(num_masked, image_ids.size()) + " images have one"}};
}

}  // namespace structnerf
