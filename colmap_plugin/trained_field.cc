#include "colmap_plugin/trained_field.h"

#include "colmap_plugin/dense_workspace.h"
#include "colmap_plugin/input_check.h"
#include "colmap_plugin/scene_converter.h"
#include "nerf/engine/torch_factory.h"
#include "nerf/view_selection.h"

#include <filesystem>
#include <stdexcept>

namespace structnerf {

namespace fs = std::filesystem;

bool TrainedField::Exists(const std::string& workspace_path) {
  return fs::exists(DenseWorkspace(workspace_path).FieldPath());
}

TrainedField::TrainedField(const std::string& workspace_path) {
  const DenseWorkspace workspace(workspace_path);
  if (!Exists(workspace_path)) {
    throw std::runtime_error("The workspace " + workspace_path +
                             " has no trained field (" + workspace.FieldPath() +
                             "); run structnerf_dense first.");
  }
  run_ =
      ReadReport((fs::path(workspace.ReportFolder()) / "report.json").string());
  scene_ = ConvertGeometry(ReadModel(workspace.SparsePath()));
  if (run_.exposures.size() == scene_.views.size()) {
    for (size_t v = 0; v < scene_.views.size(); ++v) {
      scene_.views[v].exposure = run_.exposures[v];
    }
  }
  viewer_ = std::make_unique<FieldViewer>(scene_,
                                          run_.options.reconstruction,
                                          workspace.FieldPath(),
                                          MakeAnyEngine);
}

std::vector<int> TrainedField::HeldOutViewIdxs() const {
  return structnerf::HeldOutViewIdxs(
      scene_.views.size(), run_.options.reconstruction.training.test_every);
}

}  // namespace structnerf
