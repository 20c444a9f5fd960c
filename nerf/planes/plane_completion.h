#pragma once

#include "nerf/dense_maps.h"
#include "nerf/planes/plane_hypotheses.h"
#include "nerf/planes/plane_view.h"
#include "nerf/planes/plane_votes.h"
#include "nerf/progress.h"
#include "nerf/scene.h"
#include "nerf/scene_frame.h"
#include "nerf/stereo/patch_match.h"
#include "nerf/train/training_views.h"
#include "nerf/util/thread_pool.h"

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// Puts superpixels that no view can match onto planes that several views agree
// on. A blank surface looks the same at any depth between what stands in front
// of it and behind it, so neither colour nor matching places it, and the field
// puts it near. Its border, the upright and level planes of a room, and the
// other views do: each view names the planes that its segments may lie on, and
// a pixel takes the one that most other views name as well.
//
// Use: AddView for all views, then FindPlanes, then Complete for each. Views
// that were not added are not completed.
class PlaneCompletion {
 public:
  // All arguments must outlive this object. `voter_idxs`: the views that have a
  // say in the planes of others, ascending. `sources`: source views of each,
  // which are among these.
  PlaneCompletion(const Scene& scene,
                  const SceneFrame& frame,
                  const TrainingViews& views,
                  const std::vector<int>& voter_idxs,
                  const std::vector<std::vector<int>>& sources,
                  int window_radius);

  // Takes the maps of a view after matching: depth, normals, distinctness.
  void AddView(int view_idx, const DenseMaps& maps, ThreadPool* pool);

  // Chooses the planes of all views. Throws Aborted if told to.
  void FindPlanes(ThreadPool* pool, Progress* progress);

  // Replaces depth and normals of pixels on a plane that was found; others, and
  // those that are masked or without a depth, stay as they are. Returns how
  // many.
  size_t Complete(int view_idx, ThreadPool* pool, DenseMaps* maps) const;

 private:
  // Keeps normals of some of the distinct pixels.
  void SampleNormals(int view_idx,
                     const PlaneMaps& planes,
                     const std::vector<uint32_t>& distinct);
  ViewWarp MakeWarp(int view_idx, int source_idx) const;
  std::vector<ViewWarp> MakeWarps(int view_idx) const;  // to its sources

  // What too few sources confirm is reliable no more.
  void ConfirmReliablePixels(ThreadPool* pool, Progress* progress);

  // `hypotheses`: by view and segment; those of a view are empty if it has
  // none.
  std::vector<ChosenPlane> ChoosePlanes(
      int view_idx,
      const std::vector<std::vector<std::vector<PlaneHypothesis>>>& hypotheses)
      const;

  const Scene& scene_;
  const SceneFrame& frame_;
  const TrainingViews& views_;
  const std::vector<int>& voter_idxs_;
  const std::vector<std::vector<int>>& sources_;
  const int border_;
  std::vector<PlaneView> plane_views_;

  // Of some distinct pixels of the views that have a say.
  struct NormalSample {
    int view_idx = -1;
    uint32_t pixel = 0;
    Eigen::Vector3f normal;  // world
  };
  std::vector<NormalSample> normal_samples_;

  // By view and cell of its PlaneLattice; empty before FindPlanes, and where
  // there are none.
  std::vector<std::vector<ChosenPlane>> chosen_;
};

}  // namespace structnerf
