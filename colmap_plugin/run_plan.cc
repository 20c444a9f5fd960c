#include "colmap_plugin/run_plan.h"

#include "colmap_plugin/cloud_fusion.h"
#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/memory_budget.h"
#include "colmap_plugin/scene_converter.h"
#include "colmap_plugin/text_output.h"
#include "nerf/dense_maps.h"
#include "nerf/reconstructor.h"
#include "nerf/train/training_views.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include <colmap/image/undistortion.h>
#include <colmap/util/threading.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

// Depth and three planes of normals.
constexpr size_t kStereoBytesPerPixel = 4 * sizeof(float);

// The above with deviation, distinctness and colour, while a view is rendered,
// and once more without the latter two, as the field has them.
constexpr size_t kDenseBytesPerPixel =
    6 * sizeof(float) + 3 + 5 * sizeof(float);

// A decoded photograph and its conversion or undistortion.
constexpr size_t kDecodingBytesPerPixel = 2 * 3;

// While a view is checked: its geometric and photometric maps and those of the
// field, angle, confidence and whether it is confirmed; of a confirmed pixel
// the part of the graph, once in its row and once in the whole. While it is
// averaged, no more but for the graph.
constexpr size_t kCheckBytesPerPixel =
    3 * kStereoBytesPerPixel + 2 * sizeof(float) + 1 + 2 * 3 * sizeof(int);
constexpr size_t kCheckBytesPerPixelAndView = 2 * sizeof(int);

// Both kinds of maps, three interim ones, one of them with distinctness,
// confidence, and consistency graphs, whose pixels are of five views on
// average.
constexpr size_t kDiskBytesPerPixel =
    5 * kStereoBytesPerPixel + (1 + 1) * sizeof(float) + (3 + 5) * sizeof(int);

// Copies of the sparse model, stacks of threads, what the allocator keeps.
constexpr size_t kOverheadBytes = size_t{64} << 20;

constexpr int kMinTrainingImageSize = 64;

// What does not depend on the size of the images that are trained on.
struct FixedBytes {
  size_t base = 0;          // held already
  size_t undistortion = 0;  // while it lasts, 0 if there is none
  size_t image = 0;         // one, while it is decoded
  size_t min_maps = 0;      // fewest that must be held at once
  size_t all_maps = 0;
  size_t check = 0;  // of one view against others
};

PinholeCamera LargestCamera(const std::vector<PinholeCamera>& cameras) {
  PinholeCamera largest;
  for (const PinholeCamera& camera : cameras) {
    largest.width = std::max(largest.width, camera.width);
    largest.height = std::max(largest.height, camera.height);
  }
  return largest;
}

size_t TotalPixels(const std::vector<PinholeCamera>& cameras,
                   const int max_image_size) {
  size_t num_pixels = 0;
  for (const PinholeCamera& camera : cameras) {
    num_pixels += camera.Reduced(max_image_size).NumPixels();
  }
  return num_pixels;
}

// With these threads.
size_t ImagesAtOnce(const std::vector<PinholeCamera>& cameras,
                    const int num_threads) {
  return std::max<size_t>(
      1,
      std::min<size_t>(colmap::GetEffectiveNumThreads(num_threads),
                       cameras.size()));
}

FixedBytes FixedBytesOf(const StructNerfOptions& options,
                        const std::vector<PinholeCamera>& cameras,
                        const PinholeCamera& largest) {
  const size_t num_pixels = largest.NumPixels();
  const size_t num_sources = options.reconstruction.loss.num_sources;
  FixedBytes bytes;
  bytes.base = CurrentMemory();
  bytes.image = std::max<size_t>(1, num_pixels * kDecodingBytesPerPixel);
  // COLMAP does so on all cores.
  bytes.undistortion = options.workspace_path.empty()
                           ? ImagesAtOnce(cameras, -1) * bytes.image
                           : 0;
  // Averaging takes depth alone, of a view and of more others.
  const size_t num_averaged =
      options.reconstruction.NumAveragedViews(cameras.size());
  bytes.min_maps =
      num_pixels *
      (kDenseBytesPerPixel + std::max((num_sources + 1) * kStereoBytesPerPixel,
                                      (num_averaged + 1) * sizeof(float)));
  bytes.all_maps = cameras.size() * num_pixels * kStereoBytesPerPixel;
  bytes.check =
      num_pixels * (kCheckBytesPerPixel + std::max(num_sources, num_averaged) *
                                              kCheckBytesPerPixelAndView);
  return bytes;
}

}  // namespace

std::vector<PinholeCamera> UndistortedCameras(
    const colmap::Reconstruction& reconstruction) {
  const colmap::UndistortCameraOptions options;
  std::vector<PinholeCamera> cameras;
  for (const colmap::image_t image_id : RegisteredImageIds(reconstruction)) {
    const colmap::Camera& distorted_camera =
        reconstruction.Camera(reconstruction.Image(image_id).CameraId());
    const colmap::Camera camera =
        distorted_camera.IsUndistorted()
            ? distorted_camera
            : colmap::UndistortCamera(options, distorted_camera);
    cameras.push_back(ToPinholeCamera(camera));
  }
  return cameras;
}

MemoryPlan PlanMemory(const StructNerfOptions& options,
                      const std::vector<PinholeCamera>& cameras) {
  const PinholeCamera largest = LargestCamera(cameras);
  const FixedBytes fixed = FixedBytesOf(options, cameras, largest);
  ReconstructionOptions reduced = options.reconstruction;
  int& image_size = reduced.training.max_image_size;
  image_size = std::min(image_size, std::max(largest.width, largest.height));
  const int wanted_image_size = image_size;
  while (TotalPixels(cameras, image_size) > kMaxTrainingPixels) {
    image_size = image_size * 3 / 4;
  }
  const int allowed_image_size = image_size;

  MemoryPlan plan;
  plan.limit = MemoryLimit(options.max_memory_gb);
  while (true) {
    const size_t training_bytes =
        Reconstructor::EstimateMemory(reduced, cameras.size(), largest);
    // Views are checked when the training's memory is free again.
    const size_t largest_bytes = std::max(training_bytes, fixed.check);
    const size_t present_bytes = fixed.base + kOverheadBytes;
    const size_t needed_bytes =
        present_bytes +
        std::max(fixed.undistortion, largest_bytes + fixed.min_maps);
    if (needed_bytes <= plan.limit) {
      plan.depth_map_bytes =
          plan.limit - std::min(plan.limit, present_bytes + largest_bytes);
      const size_t num_decoded = std::clamp<size_t>(
          plan.depth_map_bytes / fixed.image,
          1,
          ImagesAtOnce(cameras, reduced.training.num_threads));
      plan.num_decoded_images = static_cast<int>(num_decoded);
      plan.expected = std::min(
          plan.limit,
          fixed.base +
              std::max({fixed.undistortion,
                        training_bytes + num_decoded * fixed.image,
                        largest_bytes +
                            std::min(fixed.all_maps, plan.depth_map_bytes),
                        EstimateFusionMemory(options.fusion, cameras)}));
      break;
    }
    if (image_size <= kMinTrainingImageSize) {
      throw std::runtime_error(
          "The run needs about " + BytesText(needed_bytes) +
          " of memory even with the smallest images, but is limited to " +
          BytesText(plan.limit) +
          "; raise --StructNeRF.max_memory_gb, or `ulimit -v` if it is set.");
    }
    image_size = std::max(kMinTrainingImageSize, image_size * 3 / 4);
  }
  plan.max_image_size = image_size;
  if (image_size != wanted_image_size) {
    plan.note = "Images are reduced to " + std::to_string(image_size) +
                " instead of " + std::to_string(wanted_image_size) +
                " pixels " +
                (image_size == allowed_image_size
                     ? "because all together may have no more than 2^30."
                     : "to stay within " + BytesText(plan.limit) +
                           " of memory (--StructNeRF.max_memory_gb).");
  }
  return plan;
}

void CheckDiskSpace(const std::string& output_path,
                    const std::vector<PinholeCamera>& cameras,
                    const size_t num_image_bytes,
                    const size_t num_present_bytes) {
  fs::path existing = fs::absolute(output_path);
  while (!fs::exists(existing) && existing.has_relative_path()) {
    existing = existing.parent_path();
  }
  size_t needed = num_image_bytes;
  for (const PinholeCamera& camera : cameras) {
    needed += camera.NumPixels() * kDiskBytesPerPixel;
  }
  needed -= std::min(needed, num_present_bytes);
  std::error_code error;
  const fs::space_info space = fs::space(existing, error);
  if (!error && space.available < needed) {
    throw std::runtime_error("The results need about " + BytesText(needed) +
                             ", but the disk of " + output_path + " has only " +
                             BytesText(space.available) +
                             " left; free some or choose another folder.");
  }
}

}  // namespace structnerf
