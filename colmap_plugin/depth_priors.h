#pragma once

#include "nerf/progress.h"
#include "nerf/scene.h"

#include <string>
#include <vector>

namespace structnerf {

// Gives the views of a scene the depth maps of a folder, in COLMAP's format and
// naming, <folder>/<image name>.<type>.bin, for instance those of
// patch_match_stereo in stereo/depth_maps, as priors: View::prior_depth. Each
// pixel of a training image takes the nearest one of the map. A map may be of
// another size than its camera as long as it has its aspect ratio.
//
//   type: "geometric" or "photometric".
//
// Returns the names of views that have no map. Throws std::runtime_error,
// naming the file, if one is damaged or has another shape than its camera, and
// naming the folder, if it has a map of no view.
std::vector<std::string> LoadDepthPriors(const std::string& folder,
                                         const std::string& type,
                                         Scene* scene);

// The priors that --StructNeRF.prior_path gives: maps of a folder, or the file
// of a TorchScript module (nerf/prior_module.h). Returns sentences about views
// that have none. Throws std::runtime_error as those do, or if there is no such
// path; Aborted if told to.
std::vector<std::string> LoadPriors(const std::string& path,
                                    const std::string& type,
                                    Progress* progress,
                                    Scene* scene);

}  // namespace structnerf
