#include "colmap_plugin/masks.h"

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/image_file.h"
#include "colmap_plugin/png_file.h"
#include "colmap_plugin/text_output.h"
#include "nerf/progress.h"
#include "nerf/util/thread_pool.h"

#include <filesystem>
#include <stdexcept>

#include <colmap/image/undistortion.h>
#include <colmap/sensor/bitmap.h>

#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

// Sets pixels above `threshold` to 255 and the others to 0.
cv::Mat Binarize(const cv::Mat& mask, const double threshold) {
  cv::Mat binary;
  cv::threshold(mask, binary, threshold, 255, cv::THRESH_BINARY);
  return binary;
}

cv::Mat ReadCheckedMask(const std::string& path,
                        const int width,
                        const int height) {
  const cv::Mat mask = ReadGreyImage(path);
  if (mask.empty()) {
    throw std::runtime_error("The mask " + path +
                             " cannot be read; it must be a PNG image.");
  }
  if (mask.cols != width || mask.rows != height) {
    throw std::runtime_error(
        "The mask " + path + " is " + SizeText(mask.cols, mask.rows) +
        ", but its image is " + SizeText(width, height) +
        "; a mask must have the size of its image (with --workspace_path, of "
        "the undistorted one).");
  }
  return Binarize(mask, 0);
}

// Through a file, because COLMAP's bitmaps differ between versions.
void UndistortMask(const colmap::Camera& camera,
                   const std::string& input,
                   const std::string& output) {
  fs::create_directories(fs::path(output).parent_path());
  WritePng(output, ReadCheckedMask(input, camera.width, camera.height));
  if (camera.IsUndistorted()) {
    return;
  }
  colmap::Bitmap bitmap;
  colmap::Bitmap undistorted_bitmap;
  colmap::Camera undistorted_camera;
  if (!bitmap.Read(output, /*as_rgb=*/false)) {
    throw std::runtime_error("The mask " + output + " cannot be read.");
  }
  colmap::UndistortImage(colmap::UndistortCameraOptions(),
                         bitmap,
                         camera,
                         &undistorted_bitmap,
                         &undistorted_camera);
  // COLMAP does not always notice a full disk, but then nothing is read back.
  const bool is_written = undistorted_bitmap.Write(output);
  const cv::Mat undistorted = ReadGreyImage(output);
  if (!is_written || undistorted.empty()) {
    throw std::runtime_error("The file " + output +
                             " could not be written; is the disk full?");
  }
  // Interpolation has blurred the border: half and more counts as "use".
  WritePng(output, Binarize(undistorted, 127));
}

}  // namespace

std::string MaskPath(const std::string& mask_path,
                     const std::string& image_name) {
  return (fs::path(mask_path) / image_name).string() + ".png";
}

std::vector<uint8_t> ReadMask(const std::string& mask_path,
                              const std::string& image_name,
                              const int width,
                              const int height) {
  const std::string path = MaskPath(mask_path, image_name);
  if (!fs::exists(path)) {
    return {};
  }
  const cv::Mat mask = ReadCheckedMask(path, width, height);
  return {mask.begin<uint8_t>(), mask.end<uint8_t>()};
}

void UndistortMasks(const colmap::Reconstruction& reconstruction,
                    const std::string& mask_path,
                    const std::string& output_path,
                    const int num_threads,
                    const std::function<bool()>& stop) {
  std::vector<colmap::image_t> image_ids;
  for (const colmap::image_t image_id : RegisteredImageIds(reconstruction)) {
    if (fs::exists(
            MaskPath(mask_path, reconstruction.Image(image_id).Name()))) {
      image_ids.push_back(image_id);
    }
  }
  ThreadPool(num_threads)
      .ParallelFor(image_ids.size(), [&](const size_t i, const int thread) {
        if (thread == 0 && stop()) {  // who called us
          throw Aborted();
        }
        const colmap::Image& image = reconstruction.Image(image_ids[i]);
        UndistortMask(reconstruction.Camera(image.CameraId()),
                      MaskPath(mask_path, image.Name()),
                      MaskPath(output_path, image.Name()));
      });
}

}  // namespace structnerf
