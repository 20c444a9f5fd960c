#include "nerf/view_mapper.h"

#include "nerf/extract/consistency.h"
#include "nerf/extract/depth_renderer.h"
#include "nerf/extract/normal_estimation.h"
#include "nerf/planes/plane_completion.h"
#include "nerf/stereo/depth_refinement.h"

#include <cstdint>
#include <utility>

namespace structnerf {
namespace {

// Views as large as their training images, without the colours of these.
Scene AtTrainingSize(const Scene& scene) {
  Scene result;
  for (const View& view : scene.views) {
    View& reduced = result.views.emplace_back(PoseOf(view));
    reduced.camera = view.ImageCamera();
    reduced.image.width = view.image.width;
    reduced.image.height = view.image.height;
    reduced.segments = view.segments;
    reduced.mask = view.mask;
    reduced.near_depth = view.near_depth;
    reduced.far_depth = view.far_depth;
  }
  return result;
}

void KeepOnlyDepth(DenseMaps* maps) {
  maps->normal = std::vector<float>();
  maps->relative_std = std::vector<float>();
  maps->distinctness = std::vector<float>();
}

}  // namespace

int NumBriefSweeps(const StereoOptions& options) {
  return (options.num_iterations + 1) / 2;
}

ViewMapper::ViewMapper(const Scene& scene,
                       const SceneFrame& frame,
                       const TrainingViews& views,
                       const std::vector<std::vector<int>>& sources,
                       const ReconstructionOptions& options,
                       RenderEngine* engine,
                       ThreadPool* pool)
    : scene_(scene),
      frame_(frame),
      views_(views),
      sources_(sources),
      options_(options),
      patch_match_(scene, frame, views, sources, options.stereo),
      engine_(engine),
      pool_(pool) {}

DenseMaps ViewMapper::MakeMaps(const int view_idx,
                               Progress* progress,
                               DenseMaps* field) const {
  const View& view = scene_.views.at(view_idx);
  DenseMaps maps = RenderField(view, progress);
  if (field != nullptr) {
    *field = maps;
  }
  if (options_.MatchesViews()) {
    Refine(view, view_idx, patch_match_, progress, &maps);
  }
  return maps;
}

DenseMaps ViewMapper::RenderField(const View& view, Progress* progress) const {
  DenseMaps maps = RenderDepth(view, frame_, engine_, progress);
  EstimateNormals(view.camera, pool_, progress, &maps);
  const float max_std =
      static_cast<float>(options_.extraction.max_relative_std);
  KeepOnly([&](const size_t i) { return maps.relative_std[i] <= max_std; },
           &maps);
  return maps;
}

void ViewMapper::Refine(const View& view,
                        const int view_idx,
                        const PatchMatch& patch_match,
                        Progress* progress,
                        DenseMaps* maps) const {
  RefineDepth(view,
              view_idx,
              frame_,
              views_.image(view_idx),
              patch_match,
              pool_,
              progress,
              maps);
}

std::shared_ptr<const MatchedDepth> ViewMapper::Match(
    const std::vector<int>& view_idxs, Progress* progress) const {
  StereoOptions brief_options = options_.stereo;
  brief_options.num_iterations = NumBriefSweeps(options_.stereo);
  const PatchMatch brief_patch_match(
      scene_, frame_, views_, sources_, brief_options);
  const Scene scene = AtTrainingSize(scene_);
  std::vector<DenseMaps> maps(scene.views.size());
  std::unique_ptr<PlaneCompletion> planes;
  if (options_.CompletesPlanes()) {
    planes = std::make_unique<PlaneCompletion>(scene,
                                               frame_,
                                               views_,
                                               view_idxs,
                                               sources_,
                                               options_.stereo.window_radius);
  }
  ProgressUpdate update;
  update.stage = "Matching views";
  progress->Report(update);
  SilentProgress silent(progress);
  for (size_t i = 0; i < view_idxs.size(); ++i) {
    if (progress->ShouldStop()) {
      return nullptr;
    }
    const int view_idx = view_idxs[i];
    const View& view = scene.views[view_idx];
    maps[view_idx] = RenderField(view, &silent);
    Refine(view, view_idx, brief_patch_match, &silent, &maps[view_idx]);
    if (planes != nullptr) {
      planes->AddView(view_idx, maps[view_idx], pool_);
    }
    KeepOnlyDepth(&maps[view_idx]);
    update.fraction =
        static_cast<double>(i + 1) / static_cast<double>(view_idxs.size());
    progress->Report(update);
  }
  if (planes != nullptr) {
    planes->FindPlanes(pool_, &silent);
    for (const int view_idx : view_idxs) {
      if (progress->ShouldStop()) {
        return nullptr;
      }
      maps[view_idx].normal.resize(3 * maps[view_idx].depth.size());
      planes->Complete(view_idx, pool_, &maps[view_idx]);
      KeepOnlyDepth(&maps[view_idx]);
    }
  }
  return ConfirmedDepth(scene, view_idxs, maps, progress);
}

std::shared_ptr<const MatchedDepth> ViewMapper::ConfirmedDepth(
    const Scene& scene,
    const std::vector<int>& view_idxs,
    const std::vector<DenseMaps>& maps,
    Progress* progress) const {
  const auto confirmed = std::make_shared<MatchedDepth>(maps.size());
  for (const int view_idx : view_idxs) {
    const std::vector<uint8_t> is_confirmed =
        CheckConsistency(scene,
                         maps,
                         view_idx,
                         sources_[view_idx],
                         options_.extraction,
                         pool_,
                         progress)
            .is_confirmed;
    for (size_t i = 0; i < is_confirmed.size(); ++i) {
      // Half a pixel beside where it was matched. Moved there, it teaches the
      // field nothing better (nerf/EXPERIMENTS.md).
      const float depth = maps[view_idx].depth[i];
      (*confirmed)[view_idx].push_back(
          is_confirmed[i] != 0 ? depth * static_cast<float>(frame_.scale)
                               : 0.0f);
    }
  }
  return confirmed;
}

}  // namespace structnerf
