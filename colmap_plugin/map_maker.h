#pragma once

#include "colmap_plugin/dense_workspace.h"
#include "colmap_plugin/depth_map_cache.h"
#include "colmap_plugin/file_journal.h"
#include "colmap_plugin/run_report.h"
#include "colmap_plugin/stage_progress.h"
#include "nerf/options.h"
#include "nerf/reconstructor.h"
#include "nerf/scene.h"

#include <cstddef>
#include <string>
#include <vector>

namespace structnerf {

struct MapMakerOptions {
  // Of all views.
  std::vector<std::string> image_names;

  // Folder with the masks of the undistorted images; empty = none.
  std::string mask_path;

  // Whether maps that the journal knows to be whole are of the field as it is
  // now. Those of a field that was trained again from an older checkpoint are
  // not: training may have been stopped at another step.
  bool reuses_maps = false;

  // ReconstructionOptions::MatchesViews and AveragesDepth. In the latter case
  // it is AverageMaps that says what is confirmed in the end, and how
  // confidently.
  bool matches_views = false;
  bool averages_depth = false;

  // For maps that are held at once.
  size_t max_bytes = 0;

  ExtractionOptions extraction;  // fitted to the scene
  int num_threads = -1;          // -1 = all cores
};

// Makes the maps of all views from a trained field and writes them into a
// workspace: the functions in the order in which they stand here, each a stage
// of the run. They throw Aborted if told to, std::runtime_error if a file
// cannot be written.
class MapMaker {
 public:
  // `scene`: cameras and poses will do. What the pointers point to must outlive
  // this object.
  MapMaker(const MapMakerOptions& options,
           const Scene* scene,
           const DenseWorkspace* workspace,
           FileJournal* journal);

  // Depth and normals as the field and matching have them.
  void RenderMaps(Reconstructor* reconstructor, StageProgress* stage);

  // Puts blank surfaces onto planes, if the options of the method say so.
  // Returns the number of pixels on planes.
  size_t CompletePlanes(Reconstructor* reconstructor, StageProgress* stage);

  // Writes the geometric maps, and the photometric ones, in which pixels that
  // no view confirms have the depth of the field. Unless depth is averaged
  // afterwards, also what confirms the former, and the confidence of the
  // latter.
  // `source_views`: Reconstructor::SourceViews.
  void CheckConsistency(const std::vector<std::vector<int>>& source_views,
                        StageProgress* stage);

  // Complete after the last of the above.
  const std::vector<ViewReport>& Views() const { return views_; }

 private:
  // Written, or as an earlier run has written them.
  DenseMaps RenderView(size_t view_idx,
                       const Reconstructor& reconstructor,
                       Progress* progress);
  void WriteRendered(const std::string& image_name,
                     InterimStage stage,
                     const DenseMaps& maps);

  const MapMakerOptions options_;
  const Scene* scene_;
  const DenseWorkspace* workspace_;
  FileJournal* journal_;
  DepthMapCache depth_maps_;
  std::vector<ViewReport> views_;
};

}  // namespace structnerf
