#include "colmap_plugin/map_averaging.h"

#include "colmap_plugin/depth_map_cache.h"
#include "nerf/extract/confidence.h"
#include "nerf/extract/depth_averaging.h"
#include "nerf/util/thread_pool.h"

#include <utility>

namespace structnerf {
namespace {

// Of a depth map without normals.
DenseMaps ReadConfirmedDepth(const DenseWorkspace& workspace,
                             const std::string& image_name) {
  StereoMaps maps =
      ReadDepthMap(workspace.DepthMapPath(image_name, MapType::kGeometric));
  DenseMaps confirmed;
  confirmed.width = maps.width;
  confirmed.height = maps.height;
  confirmed.depth = std::move(maps.depth);
  return confirmed;
}

}  // namespace

std::vector<size_t> AverageMaps(
    const MapAveragingOptions& options,
    const Scene& scene,
    const std::vector<std::vector<int>>& averaging_views,
    const DenseWorkspace& workspace,
    StageProgress* stage) {
  const std::vector<std::string>& names = options.image_names;
  const size_t num_items = 2 * names.size();
  DepthMapCache confirmed(
      [&](const size_t view_idx) {
        return ReadConfirmedDepth(workspace, names[view_idx]);
      },
      names.size(),
      options.max_bytes);
  ThreadPool pool(options.num_threads);
  // Geometric maps stay until the last view has used them.
  std::vector<std::vector<bool>> is_confirmed;
  for (size_t i = 0; i < names.size(); ++i) {
    std::vector<int> required = averaging_views[i];
    required.push_back(static_cast<int>(i));
    StereoMaps photometric =
        workspace.ReadMaps(names[i], MapType::kPhotometric);
    const DepthAgreement agreement = AverageDepth(scene,
                                                  confirmed.Require(required),
                                                  i,
                                                  averaging_views[i],
                                                  options.extraction,
                                                  &pool,
                                                  stage->Inner(),
                                                  &photometric.depth);
    const int width = photometric.width;
    const int height = photometric.height;
    workspace.WriteMaps(names[i], MapType::kPhotometric, photometric);
    workspace.WriteConsistencyGraph(names[i], width, height, agreement.graph);
    workspace.WriteConfidence(names[i],
                              width,
                              height,
                              EstimateConfidence(scene.views[i].camera,
                                                 photometric.depth,
                                                 agreement,
                                                 &pool,
                                                 stage->Inner()));
    is_confirmed.emplace_back(agreement.is_confirmed.begin(),
                              agreement.is_confirmed.end());
    stage->Report(i + 1, num_items);
  }
  std::vector<size_t> num_geometric;
  for (size_t i = 0; i < names.size(); ++i) {
    StereoMaps geometric = workspace.ReadMaps(names[i], MapType::kPhotometric);
    geometric.KeepOnly({is_confirmed[i].begin(), is_confirmed[i].end()});
    workspace.WriteMaps(names[i], MapType::kGeometric, geometric);
    num_geometric.push_back(geometric.NumDepths());
    stage->Report(names.size() + i + 1, num_items);
  }
  return num_geometric;
}

}  // namespace structnerf
