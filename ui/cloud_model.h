#pragma once

#include <memory>
#include <string>

#include <colmap/scene/reconstruction.h>

namespace structnerf {

// The cameras of a model with the points of a PLY file in place of its own, for
// COLMAP's viewer. Throws std::runtime_error if the file cannot be read.
std::shared_ptr<colmap::Reconstruction> MakeCloudModel(
    const colmap::Reconstruction& sparse, const std::string& ply_path);

}  // namespace structnerf
