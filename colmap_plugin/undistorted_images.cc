#include "colmap_plugin/undistorted_images.h"

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/image_file.h"
#include "colmap_plugin/input_check.h"
#include "colmap_plugin/masks.h"
#include "nerf/progress.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <vector>

namespace structnerf {

namespace fs = std::filesystem;

colmap::Reconstruction UndistortIntoWorkspace(
    const colmap::Reconstruction& reconstruction,
    const std::string& image_path,
    const std::string& mask_path,
    const std::string& undistorted_mask_path,
    const DenseWorkspace& workspace,
    const int num_threads,
    const std::function<bool(size_t)>& report,
    FileJournal* journal) {
  std::vector<std::string> files;
  for (const std::string& name : ImageNames(reconstruction)) {
    files.push_back(workspace.ImagePath(name));
    if (!mask_path.empty() && fs::exists(MaskPath(mask_path, name))) {
      files.push_back(MaskPath(undistorted_mask_path, name));
    }
  }
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    files.push_back((fs::path(workspace.SparsePath()) / name).string());
  }
  const bool is_complete =
      std::all_of(files.begin(), files.end(), [&](const std::string& file) {
        return journal->IsIntact(file);
      });
  if (is_complete) {
    return ReadWrittenModel(reconstruction, workspace.SparsePath());
  }
  fs::remove_all(workspace.ImagesPath());
  fs::remove_all(workspace.SparsePath());
  fs::remove_all(undistorted_mask_path);
  size_t num_done = 0;
  bool stopped = false;
  CreateUndistortedWorkspace(
      reconstruction, image_path, workspace.Path(), [&]() {
        stopped = stopped || report(num_done++);
        return stopped;
      });
  if (stopped || report(num_done)) {
    throw Aborted();
  }
  if (!mask_path.empty()) {
    UndistortMasks(
        reconstruction, mask_path, undistorted_mask_path, num_threads, [&]() {
          return report(num_done);
        });
  }
  colmap::Reconstruction undistorted =
      ReadWrittenModel(reconstruction, workspace.SparsePath());
  for (const std::string& file : files) {
    if (IsCutOff(file)) {
      throw std::runtime_error("The image " + file +
                               " could not be written; is the disk full?");
    }
    journal->Add(file);
  }
  return undistorted;
}

}  // namespace structnerf
