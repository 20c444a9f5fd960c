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
      depth_maps_(
          [workspace, names = options.image_names](const size_t view_idx) {
            return workspace->ReadInterimMaps(names[view_idx],
                                              InterimStage::kCompleted);
          },
          options.image_names.size(),
          options.max_bytes) {}

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
  const std::string path =
      workspace_->InterimMapsPath(name, InterimStage::kMatched);
  if (options_.reuses_maps && journal_->IsIntact(path) &&
      (!options_.matches_views ||
       journal_->IsIntact(
           workspace_->InterimMapsPath(name, InterimStage::kRendered)))) {
    return workspace_->ReadInterimMaps(name, InterimStage::kMatched);
  }
  DenseMaps rendered;
  const DenseMaps maps = reconstructor.RenderView(
      view_idx, progress, options_.matches_views ? &rendered : nullptr);
  if (options_.matches_views) {
    WriteRendered(name, InterimStage::kRendered, rendered);
  }
  WriteRendered(name, InterimStage::kMatched, maps);
  return maps;
}

void MapMaker::WriteRendered(const std::string& image_name,
                             const InterimStage stage,
                             const DenseMaps& maps) {
  workspace_->WriteInterimMaps(image_name, stage, maps);
  journal_->Add(workspace_->InterimMapsPath(image_name, stage));
}

size_t MapMaker::CompletePlanes(Reconstructor* reconstructor,
                                StageProgress* stage) {
  reconstructor->FindPlanes(stage->Inner());
  const size_t num_views = options_.image_names.size();
  size_t num_completed_pixels = 0;
  for (size_t i = 0; i < num_views; ++i) {
    const std::string& name = options_.image_names[i];
    DenseMaps maps = workspace_->ReadInterimMaps(name, InterimStage::kMatched);
    num_completed_pixels += reconstructor->CompletePlanes(i, &maps);
    if (!options_.mask_path.empty()) {
      const auto mask =
          ReadMask(options_.mask_path, name, maps.width, maps.height);
      if (!mask.empty()) {
        KeepOnly([&](const size_t pixel) { return mask[pixel] != 0; }, &maps);
      }
    }
    workspace_->WriteInterimMaps(name, InterimStage::kCompleted, maps);
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
    ViewConsistency consistency =
        structnerf::CheckConsistency(*scene_,
                                     all_maps,
                                     i,
                                     source_views[i],
                                     options_.extraction,
                                     &pool,
                                     stage->Inner());
    DenseMaps maps = all_maps[i];
    const std::vector<uint8_t>& is_confirmed = consistency.is_confirmed;
    StereoMaps geometric{maps.width, maps.height, maps.depth, maps.normal};
    geometric.KeepOnly(is_confirmed);
    workspace_->WriteMaps(name, MapType::kGeometric, geometric);

    if (options_.matches_views) {
      ReplaceUnconfirmed(
          is_confirmed,
          workspace_->ReadInterimMaps(name, InterimStage::kRendered),
          &maps);
      for (size_t pixel = 0; pixel < is_confirmed.size(); ++pixel) {
        consistency.angles[pixel] *= is_confirmed[pixel];
      }
    }
    if (!options_.averages_depth) {
      workspace_->WriteConsistencyGraph(
          name, maps.width, maps.height, consistency.graph);
      workspace_->WriteConfidence(name,
                                  maps.width,
                                  maps.height,
                                  EstimateConfidence(scene_->views[i].camera,
                                                     maps.depth,
                                                     consistency.angles,
                                                     options_.matches_views,
                                                     &pool,
                                                     stage->Inner()));
    }
    const StereoMaps photometric{
        maps.width, maps.height, std::move(maps.depth), std::move(maps.normal)};
    workspace_->WriteMaps(name, MapType::kPhotometric, photometric);
    views_.push_back({name,
                      photometric.width,
                      photometric.height,
                      photometric.NumDepths(),
                      geometric.NumDepths(),
                      scene_->views[i].exposure});
    stage->Report(i + 1, num_views);
  }
  workspace_->WriteConfigs(options_.image_names, source_views);
}

}  // namespace structnerf
