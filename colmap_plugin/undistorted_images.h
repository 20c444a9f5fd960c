#pragma once

#include "colmap_plugin/dense_workspace.h"
#include "colmap_plugin/file_journal.h"

#include <cstddef>
#include <functional>
#include <string>

#include <colmap/scene/reconstruction.h>

namespace structnerf {

// Fills a workspace with undistorted images, their sparse model and, in
// `undistorted_mask_path`, their masks, unless `mask_path` is empty. Returns
// the model as it was written. What the journal knows to be complete is not
// made again. `report` is told the number of images done and returns true to
// stop, which throws Aborted. Other errors are std::runtime_error.
// `num_threads` is that of the masks; COLMAP undistorts images on all cores.
colmap::Reconstruction UndistortIntoWorkspace(
    const colmap::Reconstruction& reconstruction,
    const std::string& image_path,
    const std::string& mask_path,
    const std::string& undistorted_mask_path,
    const DenseWorkspace& workspace,
    int num_threads,
    const std::function<bool(size_t)>& report,
    FileJournal* journal);

}  // namespace structnerf
