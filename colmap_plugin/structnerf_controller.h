#pragma once

#include "colmap_plugin/dense_workspace.h"
#include "colmap_plugin/file_journal.h"
#include "colmap_plugin/run_plan.h"
#include "colmap_plugin/run_progress.h"
#include "colmap_plugin/run_report.h"
#include "colmap_plugin/stage_progress.h"
#include "colmap_plugin/staged_folder.h"
#include "colmap_plugin/structnerf_options.h"
#include "colmap_plugin/time_budget.h"
#include "nerf/checkpoint_options.h"
#include "nerf/reconstructor.h"

#include <memory>
#include <string>
#include <vector>

#include <colmap/scene/reconstruction.h>
#include <colmap/util/base_controller.h>

namespace structnerf {

// The dense stage: from a sparse model to depth and normal maps and a fused
// cloud in COLMAP's dense workspace. Results appear in the workspace all at
// once at the end; a run that fails leaves the disk as it was, but for a hidden
// folder with its checkpoints once there are any. The next run goes on from
// there, to the same result.
class StructNerfController : public colmap::BaseController {
 public:
  enum class Status { kNotRun, kSuccess, kFailed, kAborted };

  // `reconstruction` is the distorted model that belongs to
  // `options.image_path`; null when `options.workspace_path` is set, whose
  // model is used. `progress` must outlive this object.
  StructNerfController(
      const StructNerfOptions& options,
      std::shared_ptr<const colmap::Reconstruction> reconstruction,
      RunProgress* progress);
  ~StructNerfController() override;

  // Does not throw, whatever the progress throws. Training ends early, and the
  // later stages still run, when CheckIfStopped() or the progress says so.
  void Run() override;

  Status GetStatus() const { return status_; }

  // One sentence for people; empty unless failed.
  const std::string& Error() const { return error_; }

  // The folder with all that was done, from which the same run goes on; empty
  // if nothing was kept or this is another run.
  const std::string& KeptPath() const { return kept_path_; }

  // Complete after success.
  const RunReport& Report() const { return report_; }

 private:
  class ControllerProgress;

  void RunStages();

  // After a run that did not succeed, unless the user gave it up.
  // `is_refused`: the checkpoints are another run's.
  void KeepCheckpoints(bool is_refused);

  // Throws before anything is written if the input cannot work.
  void CheckInput();

  // Looks for the checkpoint of a run that was killed.
  void CheckLinks() const;
  void PrepareToResume();

  void UndistortImages();
  void LoadScene();
  void Train();
  void MakeMaps();
  void FusePoints();
  void AverageMaps();
  void WriteResults();

  // Seconds that training may take; 0 = no limit. Renders one view to see how
  // fast this machine is.
  double TrainingSeconds();

  // Before training, where to stop is to abort.
  void EndIfToldTo();

  StageProgress BeginStage(const std::string& name);
  void Warn(const std::string& sentence);
  bool HasNewWorkspace() const { return options_.workspace_path.empty(); }

  StructNerfOptions options_;
  std::shared_ptr<const colmap::Reconstruction> reconstruction_;
  std::unique_ptr<ControllerProgress> progress_;

  const TimeBudget time_budget_;
  MemoryPlan memory_plan_;
  std::unique_ptr<StagedFolder> staged_folder_;
  std::unique_ptr<DenseWorkspace> workspace_;  // in the staged folder
  std::string mask_path_;                      // of the undistorted images
  std::unique_ptr<FileJournal> journal_;       // of the staged folder
  CheckpointOptions checkpoint_options_;
  CheckpointInfo checkpoint_;  // that was found
  std::string kept_path_;
  std::vector<std::string> image_names_;

  // Cameras and poses only; the reconstructor has pixels and points.
  Scene scene_;
  std::vector<std::vector<int>> averaging_views_;
  std::unique_ptr<Reconstructor> reconstructor_;

  StageTimer timer_;
  RunReport report_;
  Status status_ = Status::kNotRun;
  std::string error_;
};

}  // namespace structnerf
