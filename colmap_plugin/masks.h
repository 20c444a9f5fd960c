#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <colmap/scene/reconstruction.h>

namespace structnerf {

// Image masks in COLMAP's naming: the mask of image `name` is the file
// `<mask_path>/<name>.png`; black pixels are ignored. An image without a mask
// file is used entirely.

std::string MaskPath(const std::string& mask_path,
                     const std::string& image_name);

// One byte per pixel, row-major: 0 = ignore, 255 = use. Empty if the image has
// no mask. Throws std::runtime_error if the file cannot be read or does not
// have the given size.
std::vector<uint8_t> ReadMask(const std::string& mask_path,
                              const std::string& image_name,
                              int width,
                              int height);

// Undistorts the masks of all registered images, which belong to the original
// images, as COLMAP undistorts the images themselves, as many at a time as
// there are threads. `output_path` is created. Throws Aborted once `stop`
// returns true, which is asked in between, by the calling thread.
void UndistortMasks(const colmap::Reconstruction& reconstruction,
                    const std::string& mask_path,
                    const std::string& output_path,
                    int num_threads,
                    const std::function<bool()>& stop);

}  // namespace structnerf
