#pragma once

#include "nerf/analysis/scene_decision.h"
#include "nerf/checkpoint_options.h"
#include "nerf/dense_maps.h"
#include "nerf/engine/engine_factory.h"
#include "nerf/options.h"
#include "nerf/progress.h"
#include "nerf/scene.h"

#include <cstddef>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace structnerf {

// What training did, for the report.
struct TrainingSummary {
  int num_steps = 0;           // done
  int num_resumed_steps = 0;   // of these, done before it was interrupted
  bool stopped_early = false;  // asked to by Progress

  // Steps until the held-out pixels had settled; -1 = they had not, or nobody
  // asked (TrainingOptions::stop_when_converged).
  int num_steps_to_converge = -1;

  // Share of the pixels whose depth, matched in the midst of the training,
  // other views confirmed; -1 = none was matched (LossOptions::match_weight).
  double confirmed_share = -1;

  // Of the last steps; NaN = none was done.
  double final_loss = std::numeric_limits<double>::quiet_NaN();
  double held_out_psnr = -1;  // dB; -1 = no pixel was held out
  double seconds = 0;         // wall time, without that of matching
  size_t num_rays = 0;
  size_t num_samples = 0;  // evaluations of the field with gradient
  size_t num_parameters = 0;

  // How often each guard of the numerics acted, by name.
  std::map<std::string, int> guard_counts;
};

// Facade of the method: trains a radiance field on a scene and renders dense
// maps from it. Errors are thrown as std::exception with one clear sentence.
class Reconstructor {
 public:
  // Bytes that a run with these options, of which none is kFromScene, will need
  // at its peak, without having loaded anything: `num_views` views of `camera`,
  // the largest.
  static size_t EstimateMemory(const ReconstructionOptions& options,
                               size_t num_views,
                               const PinholeCamera& camera);

  // Throws std::invalid_argument if the scene or the options are wrong.
  Reconstructor(Scene scene,
                const ReconstructionOptions& options,
                const EngineFactory& make_engine);

  // With MakeGridEngine.
  Reconstructor(Scene scene, const ReconstructionOptions& options);
  ~Reconstructor();

  // Sentences about the scene that the user should know, e.g. views without
  // sparse points. Known after construction.
  const std::vector<std::string>& Warnings() const;

  // What the scene has decided (nerf/analysis), and the options that it comes
  // to.
  const std::vector<SceneDecision>& Decisions() const;
  const ReconstructionOptions& Options() const;

  // Trains until the options' steps are done or `progress` asks to stop. Throws
  // Aborted if told to abort. Goes on from a checkpoint if there is one, to the
  // same result, and writes new ones. Throws CheckpointMismatch if it is one of
  // another run or scene. If `max_seconds` is positive, the schedule is fitted
  // into as much wall time from now on; the result then depends on how fast the
  // machine is.
  void Train(Progress* progress,
             const CheckpointOptions& checkpoints = {},
             double max_seconds = 0);

  // Depth and normals of one view from what has been learned so far, refined by
  // matching if the options say so. `field` receives them before matching;
  // null = not needed.
  DenseMaps RenderView(size_t view_idx,
                       Progress* progress,
                       DenseMaps* field = nullptr) const;

  // Puts blank surfaces onto planes that several views agree on, if the options
  // say so: AddMaps for all views as RenderView returned them, then FindPlanes,
  // then CompletePlanes for the maps of each. The latter returns how many
  // pixels it changed.
  void AddMaps(size_t view_idx, const DenseMaps& maps);
  void FindPlanes(Progress* progress);
  size_t CompletePlanes(size_t view_idx, DenseMaps* maps) const;

  // Source views chosen for each view, best first (indices into the views).
  const std::vector<std::vector<int>>& SourceViews() const;

  // The views that each view's depth is averaged over, as
  // ReconstructionOptions::AveragesDepth says; empty without.
  const std::vector<std::vector<int>>& AveragingViews() const;

  const TrainingSummary& Summary() const;

  // The trained field in one checksummed file, written beside and renamed.
  // LoadField throws std::runtime_error if the file is damaged or belongs to
  // other field options or another scene box.
  void SaveField(const std::string& path) const;
  void LoadField(const std::string& path);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace structnerf
