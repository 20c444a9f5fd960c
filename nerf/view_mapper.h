#pragma once

#include "nerf/dense_maps.h"
#include "nerf/engine/render_engine.h"
#include "nerf/options.h"
#include "nerf/progress.h"
#include "nerf/scene.h"
#include "nerf/scene_frame.h"
#include "nerf/stereo/patch_match.h"
#include "nerf/train/matched_depth.h"
#include "nerf/train/training_views.h"
#include "nerf/util/thread_pool.h"

#include <memory>
#include <vector>

namespace structnerf {

// Sweeps for what the field learns from, half of those for what is written: the
// former need not be as good.
int NumBriefSweeps(const StereoOptions& options);

// Makes depth and normal maps of the views of a scene from what an engine has
// learned so far. What the constructor is given must outlive this object.
class ViewMapper {
 public:
  // `sources`: of each view. `options`: none is kFromScene.
  ViewMapper(const Scene& scene,
             const SceneFrame& frame,
             const TrainingViews& views,
             const std::vector<std::vector<int>>& sources,
             const ReconstructionOptions& options,
             RenderEngine* engine,
             ThreadPool* pool);

  // Depth and normals of a view, refined by matching if the options say so.
  // `field` receives them before matching; null = not needed.
  DenseMaps MakeMaps(int view_idx,
                     Progress* progress,
                     DenseMaps* field = nullptr) const;

  // Matches these views, with NumBriefSweeps and at the size of their training
  // images, puts blank surfaces onto planes if the options say so, and keeps
  // what others of these views confirm as ExtractionOptions say. As a
  // MatchFunction.
  std::shared_ptr<const MatchedDepth> Match(const std::vector<int>& view_idxs,
                                            Progress* progress) const;

 private:
  // `view`: one of the scene, or the same with its camera at another size.
  DenseMaps RenderField(const View& view, Progress* progress) const;
  void Refine(const View& view,
              int view_idx,
              const PatchMatch& patch_match,
              Progress* progress,
              DenseMaps* maps) const;

  // `scene`: views at the size of the maps, in world units.
  std::shared_ptr<const MatchedDepth> ConfirmedDepth(
      const Scene& scene,
      const std::vector<int>& view_idxs,
      const std::vector<DenseMaps>& maps,
      Progress* progress) const;

  const Scene& scene_;
  const SceneFrame& frame_;
  const TrainingViews& views_;
  const std::vector<std::vector<int>>& sources_;
  const ReconstructionOptions& options_;
  const PatchMatch patch_match_;
  RenderEngine* const engine_;
  ThreadPool* const pool_;
};

}  // namespace structnerf
