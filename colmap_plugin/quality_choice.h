#pragma once

#include "colmap_plugin/structnerf_options.h"
#include "colmap_plugin/time_estimate.h"
#include "nerf/scene.h"

#include <string>
#include <vector>

namespace structnerf {

// The quality of a run that is given `options.max_minutes` and no quality: the
// one that was remembered by the run it goes on with, if there is one, or the
// best that fits on this machine as fast as it was when it was first asked for.
// Without a folder for results, nothing is gone on with. `cameras`: of the
// undistorted images.
QualityChoice ChooseQuality(const StructNerfOptions& options,
                            const std::vector<PinholeCamera>& cameras);

// Remembers it in a folder for notes (StagedFolder::NotesPath): speeds that are
// measured differ, and a run can only go on with the options that it began
// with. Throws std::runtime_error if it cannot be written.
void RememberQuality(const std::string& notes_path,
                     const QualityChoice& choice);

}  // namespace structnerf
