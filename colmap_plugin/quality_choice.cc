#include "colmap_plugin/quality_choice.h"

#include "colmap_plugin/staged_folder.h"
#include "colmap_plugin/text_output.h"
#include "nerf/checkpoint_options.h"
#include "nerf/engine/machine_speed.h"

#include <filesystem>
#include <fstream>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

constexpr char kFileName[] = "quality";

}  // namespace

QualityChoice ChooseQuality(const StructNerfOptions& options,
                            const std::vector<PinholeCamera>& cameras) {
  const std::string notes_path =
      StagedFolder::NotesPathOf(options.ResultPath());
  if (options.resume && !options.ResultPath().empty() &&
      HasCheckpoint(notes_path)) {
    std::ifstream file(fs::path(notes_path) / kFileName);
    QualityChoice choice;
    if (file >> choice.quality >> choice.num_sweeps) {
      return choice;
    }
  }
  static const double slowness =
      MeasureSlowness(options.reconstruction.training.num_threads);
  return QualityForTime(options, cameras, slowness);
}

void RememberQuality(const std::string& notes_path,
                     const QualityChoice& choice) {
  WriteTextFile(
      (fs::path(notes_path) / kFileName).string(),
      choice.quality + " " + std::to_string(choice.num_sweeps) + "\n");
}

}  // namespace structnerf
