#include "colmap_plugin/map_averaging.h"

#include "colmap_plugin/depth_map_cache.h"
#include "nerf/extract/depth_averaging.h"
#include "nerf/util/thread_pool.h"

#include <cstdint>
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

std::vector<uint8_t> HasDepth(const StereoMaps& maps) {
  std::vector<uint8_t> has_depth;
  has_depth.reserve(maps.depth.size());
  for (const float depth : maps.depth) {
    has_depth.push_back(depth > 0);
  }
  return has_depth;
}

}  // namespace

void AverageMaps(const MapAveragingOptions& options,
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
  for (size_t i = 0; i < names.size(); ++i) {
    std::vector<int> required = averaging_views[i];
    required.push_back(static_cast<int>(i));
    StereoMaps photometric =
        workspace.ReadMaps(names[i], MapType::kPhotometric);
    AverageDepth(scene,
                 confirmed.Require(required),
                 i,
                 averaging_views[i],
                 options.extraction,
                 &pool,
                 stage->Inner(),
                 &photometric.depth);
    workspace.WriteMaps(names[i], MapType::kPhotometric, photometric);
    stage->Report(i + 1, num_items);
  }
  for (size_t i = 0; i < names.size(); ++i) {
    const std::vector<uint8_t> is_confirmed = HasDepth(
        ReadDepthMap(workspace.DepthMapPath(names[i], MapType::kGeometric)));
    StereoMaps geometric = workspace.ReadMaps(names[i], MapType::kPhotometric);
    geometric.KeepOnly(is_confirmed);
    workspace.WriteMaps(names[i], MapType::kGeometric, geometric);
    stage->Report(names.size() + i + 1, num_items);
  }
}

}  // namespace structnerf
