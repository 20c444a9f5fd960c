#include "colmap_plugin/map_maker.h"

#include "colmap_plugin/masks.h"
#include "nerf/extract/confidence.h"
#include "nerf/extract/consistency.h"
#include "nerf/util/thread_pool.h"

#include <utility>

namespace structnerf {

MapMaker::MapMaker(const MapMakerOptions& options,
                   const Scene* scene,
                   const DenseWorkspace* workspace,
                   FileJournal* journal)
    : options_(options),
      scene_(scene),
      workspace_(workspace),
      journal_(journal),
      depth_maps_(workspace, options.image_names, options.max_bytes) {}

void MapMaker::RenderMaps(Reconstructor* reconstructor, StageProgress* stage) {
  const size_t num_views = options_.image_names.size();
  for (size_t i = 0; i < num_views; ++i) {
    reconstructor->AddMaps(i, RenderView(i, *reconstructor, stage->Inner()));
    stage->Report(i + 1, num_views);
  }
}

DenseMaps MapMaker::RenderView(const size_t view_idx,
                               const Reconstructor& reconstructor,
                               Progress* progress) {
  const std::string& name = options_.image_names[view_idx];
  const std::string path = workspace_->MatchedMapsPath(name);
  if (options_.reuses_maps && journal_->IsIntact(path)) {
    return workspace_->ReadMatchedMaps(name);
  }
  const DenseMaps maps = reconstructor.RenderView(view_idx, progress);
  workspace_->WriteMatchedMaps(name, maps);
  journal_->Add(path);
  return maps;
}

size_t MapMaker::CompletePlanes(Reconstructor* reconstructor,
                                StageProgress* stage) {
  reconstructor->FindPlanes(stage->Inner());
  const size_t num_views = options_.image_names.size();
  size_t num_completed_pixels = 0;
  for (size_t i = 0; i < num_views; ++i) {
    const std::string& name = options_.image_names[i];
    DenseMaps completed = workspace_->ReadMatchedMaps(name);
    num_completed_pixels += reconstructor->CompletePlanes(i, &completed);
    StereoMaps maps{completed.width,
                    completed.height,
                    std::move(completed.depth),
                    std::move(completed.normal)};
    if (!options_.mask_path.empty()) {
      const auto mask =
          ReadMask(options_.mask_path, name, maps.width, maps.height);
      if (!mask.empty()) {
        maps.KeepOnly(mask);
      }
    }
    workspace_->WriteMaps(name, MapType::kPhotometric, maps);
    views_.push_back({name,
                      maps.width,
                      maps.height,
                      maps.NumDepths(),
                      /*num_geometric=*/0,
                      scene_->views[i].exposure});
    depth_maps_.Insert(i, std::move(maps));
    stage->Report(i + 1, num_views);
  }
  return num_completed_pixels;
}

void MapMaker::CheckConsistency(
    const std::vector<std::vector<int>>& source_views, StageProgress* stage) {
  ThreadPool pool(options_.num_threads);
  const size_t num_views = options_.image_names.size();
  for (size_t i = 0; i < num_views; ++i) {
    const std::string& name = options_.image_names[i];
    std::vector<int> required = source_views[i];
    required.push_back(static_cast<int>(i));
    const std::vector<DenseMaps>& all_maps = depth_maps_.Require(required);
    const ViewConsistency consistency =
        structnerf::CheckConsistency(*scene_,
                                     all_maps,
                                     i,
                                     source_views[i],
                                     options_.extraction,
                                     &pool,
                                     stage->Inner());

    const DenseMaps& photometric = all_maps[i];
    workspace_->WriteConfidence(
        name,
        photometric.width,
        photometric.height,
        EstimateConfidence(
            scene_->views[i].camera, photometric, consistency.angles));
    StereoMaps maps{photometric.width,
                    photometric.height,
                    photometric.depth,
                    photometric.normal};
    maps.KeepOnly(ConfirmedPixels(consistency, maps.width));
    workspace_->WriteMaps(name, MapType::kGeometric, maps);
    workspace_->WriteConsistencyGraph(
        name, maps.width, maps.height, consistency.records);
    views_[i].num_geometric = maps.NumDepths();
    stage->Report(i + 1, num_views);
  }
  workspace_->WriteConfigs(options_.image_names, source_views);
}

}  // namespace structnerf
