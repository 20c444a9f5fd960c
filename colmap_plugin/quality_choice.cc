#include "colmap_plugin/quality_choice.h"

#include "colmap_plugin/staged_folder.h"
#include "colmap_plugin/time_estimate.h"
#include "nerf/checkpoint_options.h"
#include "nerf/engine/machine_speed.h"

#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

constexpr char kFileName[] = "quality";

}  // namespace

std::string ChooseQuality(const StructNerfOptions& options,
                          const std::vector<PinholeCamera>& cameras) {
  const std::string notes_path =
      StagedFolder::NotesPathOf(options.ResultPath());
  if (options.resume && HasCheckpoint(notes_path)) {
    std::ifstream file(fs::path(notes_path) / kFileName);
    std::string quality;
    if (file >> quality) {
      return quality;
    }
  }
  static const double slowness =
      MeasureSlowness(options.reconstruction.training.num_threads);
  return QualityForTime(options, cameras, slowness);
}

void RememberQuality(const std::string& notes_path,
                     const std::string& quality) {
  const fs::path path = fs::path(notes_path) / kFileName;
  std::ofstream file(path);
  file << quality << std::endl;
  if (!file) {
    throw std::runtime_error("The file " + path.string() +
                             " cannot be written; is the disk full?");
  }
}

}  // namespace structnerf
