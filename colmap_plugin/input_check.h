#pragma once

#include "colmap_plugin/structnerf_options.h"

#include <string>
#include <vector>

#include <colmap/scene/reconstruction.h>

namespace structnerf {

// Checks of everything that can be known to be wrong before a run touches the
// disk. Each throws std::runtime_error with one sentence that names the file
// or option and the way out.

// Reads a COLMAP model, text or binary.
colmap::Reconstruction ReadModel(const std::string& path);

// At least two registered images, sparse points that were seen in them, cameras
// that can be undistorted, and image names that stay inside the workspace.
void CheckModel(const colmap::Reconstruction& reconstruction);

// Throws std::runtime_error if there is no such folder of a dense workspace.
void CheckWorkspaceFolder(const std::string& path);

// The list of images to fuse of an existing workspace, if there is one, names
// images of its model only.
void CheckFusionConfig(const std::string& workspace_path,
                       const std::vector<std::string>& image_names);

// Every registered image exists below `image_path`, is whole, can be read and
// has the size of its camera.
void CheckImages(const colmap::Reconstruction& reconstruction,
                 const std::string& image_path);

// The folder exists and holds the mask of at least one image. Empty = none.
void CheckMasks(const colmap::Reconstruction& reconstruction,
                const std::string& mask_path);

// The output folder holds neither results, unless they may be overwritten, nor
// the original images.
void CheckOutput(const StructNerfOptions& options,
                 const std::vector<std::string>& image_names);

// The file that results shall be written to is in a folder that exists, and is
// no folder itself. `option`: that names it.
void CheckOutputFile(const std::string& option, const std::string& path);

// The file that the scene shall be written to is in a folder that exists, and
// is a scene if it exists itself. Empty = none is written.
void CheckExport(const std::string& export_path);

// `written`, read back after COLMAP has undistorted `original` and written it,
// is complete. COLMAP does not notice a full disk.
void CheckWrittenModel(const colmap::Reconstruction& original,
                       const colmap::Reconstruction& written);

// Reads back what COLMAP has made of `original`, and checks it like that.
colmap::Reconstruction ReadWrittenModel(const colmap::Reconstruction& original,
                                        const std::string& path);

// Names of the registered images in the model's order.
std::vector<std::string> ImageNames(
    const colmap::Reconstruction& reconstruction);

}  // namespace structnerf
