#pragma once

#include "colmap_plugin/report_reader.h"
#include "nerf/field_viewer.h"
#include "nerf/scene.h"

#include <memory>
#include <string>
#include <vector>

namespace structnerf {

// The field that a run of the dense stage has left in its workspace, with all
// that is needed to look at it.
class TrainedField {
 public:
  // Whether the workspace has a field at all; PatchMatch's have none.
  static bool Exists(const std::string& workspace_path);

  // Throws std::runtime_error, naming the file, if field, report or model are
  // missing, damaged or do not belong together.
  explicit TrainedField(const std::string& workspace_path);

  // The workspace's poses, cameras, exposures and points, without pixels.
  const Scene& Geometry() const { return scene_; }

  const FieldViewer& Viewer() const { return *viewer_; }

  // Views that were kept out of training, ascending.
  std::vector<int> HeldOutViewIdxs() const;

 private:
  FinishedRun run_;
  Scene scene_;
  std::unique_ptr<FieldViewer> viewer_;
};

}  // namespace structnerf
