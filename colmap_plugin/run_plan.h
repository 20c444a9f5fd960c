#pragma once

#include "colmap_plugin/structnerf_options.h"
#include "nerf/scene.h"

#include <cstddef>
#include <string>
#include <vector>

#include <colmap/scene/reconstruction.h>

namespace structnerf {

// Cameras of the registered images after undistortion, in the model's order.
std::vector<PinholeCamera> UndistortedCameras(
    const colmap::Reconstruction& reconstruction);

// What a run may use of the machine.
struct MemoryPlan {
  size_t limit = 0;            // bytes
  size_t expected = 0;         // bytes at the peak
  size_t depth_map_bytes = 0;  // for maps that are held at once
  int max_image_size = 0;      // of the images that are trained on
  int num_decoded_images = 1;  // read at once to be trained on

  // A sentence about what had to be reduced, empty if nothing.
  std::string note;
};

// Reduces the size of the training images, and how many of them are read at
// once, until the run stays within the memory limit and kMaxTrainingPixels.
// Nothing in the options may
// be kFromScene (AnalyzeScene). Throws std::runtime_error if even the smallest
// does not.
MemoryPlan PlanMemory(const StructNerfOptions& options,
                      const std::vector<PinholeCamera>& cameras);

// Throws std::runtime_error if the disk of `output_path`, which need not exist
// yet, has clearly not enough room. `num_image_bytes` is what the images need,
// `num_present_bytes` what is there already.
void CheckDiskSpace(const std::string& output_path,
                    const std::vector<PinholeCamera>& cameras,
                    size_t num_image_bytes,
                    size_t num_present_bytes);

}  // namespace structnerf
