#include "colmap_plugin/structnerf_controller.h"

#include "colmap_plugin/centred_workspace.h"
#include "colmap_plugin/cloud_fusion.h"
#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/depth_priors.h"
#include "colmap_plugin/error_text.h"
#include "colmap_plugin/exposure_fit.h"
#include "colmap_plugin/image_decisions.h"
#include "colmap_plugin/input_check.h"
#include "colmap_plugin/map_averaging.h"
#include "colmap_plugin/map_maker.h"
#include "colmap_plugin/masks.h"
#include "colmap_plugin/memory_budget.h"
#include "colmap_plugin/quality_choice.h"
#include "colmap_plugin/run_identity.h"
#include "colmap_plugin/scene_converter.h"
#include "colmap_plugin/undistorted_images.h"
#include "nerf/analysis/scene_analysis.h"
#include "nerf/engine/devices.h"
#include "nerf/extract/consistency.h"
#include "nerf/scene_file.h"

#include <algorithm>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <utility>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

std::string ResumeErrorText(const CheckpointMismatch& error) {
  return std::string("A run that was ended before its time cannot go on: ") +
         error.what() +
         ". Give the same options and data as then, or --StructNeRF.resume 0 "
         "to remove what it has done.";
}

std::string DamagedCheckpointText(const CheckpointInfo& checkpoint) {
  return checkpoint.warning + "; " +
         (checkpoint.num_steps >= 0 ? "the one before it is used"
                                    : "training begins anew") +
         ".";
}

size_t TotalFileSize(const colmap::Reconstruction& reconstruction,
                     const std::string& image_path) {
  size_t num_bytes = 0;
  for (const std::string& name : ImageNames(reconstruction)) {
    num_bytes += fs::file_size(fs::path(image_path) / name);
  }
  return num_bytes;
}

}  // namespace

// Passes everything on, and lets COLMAP's way of stopping a controller stop
// the training too.
class StructNerfController::ControllerProgress : public RunProgress {
 public:
  ControllerProgress(StructNerfController* controller, RunProgress* progress)
      : controller_(controller), progress_(progress) {}

  void Report(const ProgressUpdate& update) override {
    progress_->Report(update);
  }
  bool ShouldStop() override {
    return progress_->ShouldStop() || controller_->CheckIfStopped();
  }
  bool ShouldAbort() override { return progress_->ShouldAbort(); }
  bool ShouldSave() override { return progress_->ShouldSave(); }
  void BlockWhilePaused() override { progress_->BlockWhilePaused(); }
  int PreviewViewIdx() override {
    const std::string name = progress_->PreviewImage();
    const std::vector<std::string>& names = controller_->image_names_;
    const auto found = std::find(names.begin(), names.end(), name);
    return found != names.end() ? static_cast<int>(found - names.begin()) : -1;
  }
  void ShowPreview(const Preview& preview) override {
    progress_->ShowPreview(preview);
  }
  void Note(const std::string& sentence) override { progress_->Note(sentence); }
  void Warn(const std::string& sentence) override { progress_->Warn(sentence); }

 private:
  StructNerfController* controller_;
  RunProgress* progress_;
};

StructNerfController::StructNerfController(
    const StructNerfOptions& options,
    std::shared_ptr<const colmap::Reconstruction> reconstruction,
    RunProgress* progress)
    : options_(options),
      reconstruction_(std::move(reconstruction)),
      progress_(std::make_unique<ControllerProgress>(this, progress)),
      time_budget_(options.max_minutes) {}

StructNerfController::~StructNerfController() = default;

void StructNerfController::Run() {
  bool is_refused = false;
  try {
    RunStages();
    status_ = Status::kSuccess;
  } catch (const Aborted&) {
    status_ = Status::kAborted;
  } catch (const CheckpointMismatch& error) {
    status_ = Status::kFailed;
    error_ = ResumeErrorText(error);
    is_refused = true;
  } catch (const std::bad_alloc&) {
    status_ = Status::kFailed;
    error_ =
        "The memory did not suffice; lower --StructNeRF.max_memory_gb or "
        "--StructNeRF.max_image_size.";
  } catch (...) {
    status_ = Status::kFailed;
    error_ = CurrentErrorText();
  }
  try {
    if (status_ != Status::kSuccess) {
      KeepCheckpoints(is_refused);
    }
  } catch (...) {
    // What the run itself failed with says more.
    if (status_ != Status::kFailed) {
      status_ = Status::kFailed;
      error_ = CurrentErrorText();
    }
  }
  reconstructor_.reset();
  journal_.reset();
  staged_folder_.reset();
}

void StructNerfController::KeepCheckpoints(const bool is_refused) {
  const bool is_given_up = status_ == Status::kAborted &&
                           progress_->ShouldAbort() && !progress_->ShouldSave();
  if (!is_given_up && staged_folder_ != nullptr &&
      HasCheckpoint(staged_folder_->NotesPath())) {
    staged_folder_->Keep();
    kept_path_ = is_refused ? "" : staged_folder_->Path();
  }
}

void StructNerfController::RunStages() {
  StagedFolder::UndoCommit(options_.ResultPath());
  CheckInput();
  staged_folder_ =
      std::make_unique<StagedFolder>(options_.ResultPath(), options_.resume);
  workspace_ = std::make_unique<DenseWorkspace>(staged_folder_->Path());
  CheckLinks();
  PrepareToResume();
  UndistortImages();
  LoadScene();
  EndIfToldTo();
  Train();
  MakeMaps();
  FusePoints();
  AverageMaps();
  WriteResults();
}

void StructNerfController::CheckInput() {
  if (!HasNewWorkspace()) {
    const DenseWorkspace workspace(options_.workspace_path);
    reconstruction_ = std::make_shared<colmap::Reconstruction>(
        ReadModel(workspace.SparsePath()));
    options_.image_path = workspace.ImagesPath();
  }
  CheckModel(*reconstruction_);
  CheckImages(*reconstruction_, options_.image_path);
  CheckMasks(*reconstruction_, options_.mask_path);
  const std::vector<std::string> image_names = ImageNames(*reconstruction_);
  if (!HasNewWorkspace()) {
    CheckFusionConfig(options_.workspace_path, image_names);
  }
  CheckOutput(options_, image_names);
  CheckExport(options_.export_path);
  // From here on, reports and checkpoints know which device it is.
  options_.device =
      ResolveDevice(options_.device, options_.reconstruction.field.type);

  const auto cameras = UndistortedCameras(*reconstruction_);
  CheckDiskSpace(options_.ResultPath(),
                 cameras,
                 HasNewWorkspace()
                     ? TotalFileSize(*reconstruction_, options_.image_path)
                     : 0,
                 StagedFolder::NumBytesLeft(options_.ResultPath()));
  StructNerfOptions analyzed = options_;
  analyzed.reconstruction =
      AnalyzeScene(OutlineScene(*reconstruction_), options_.reconstruction)
          .options;
  memory_plan_ = PlanMemory(analyzed, cameras);
  options_.reconstruction.training.max_image_size = memory_plan_.max_image_size;
  report_.decisions =
      DescribeImages(options_, *reconstruction_, memory_plan_.max_image_size);
  report_.memory_limit = memory_plan_.limit;
  report_.expected_memory = memory_plan_.expected;
  if (!memory_plan_.note.empty()) {
    progress_->Note(memory_plan_.note);
  }
}

void StructNerfController::CheckLinks() const {
  const bool is_far = CentredWorkspace::IsNeeded(*reconstruction_);
  if ((!HasNewWorkspace() || is_far) && !staged_folder_->CanLink()) {
    throw std::runtime_error("The disk of " + options_.ResultPath() +
                             " knows no symbolic links, which are needed " +
                             (is_far ? "for a model far from its origin"
                                     : "to work in an existing workspace") +
                             "; choose a folder on another one.");
  }
}

void StructNerfController::PrepareToResume() {
  const std::string& notes_path = staged_folder_->NotesPath();
  checkpoint_options_.folder = notes_path;
  checkpoint_options_.interval_seconds = 60 * options_.checkpoint_minutes;
  checkpoint_options_.run = DescribeRun(options_);
  checkpoint_ = FindCheckpoint(checkpoint_options_);
  if (!checkpoint_.warning.empty()) {
    Warn(DamagedCheckpointText(checkpoint_));
  }
  if (checkpoint_.num_steps >= 0) {
    progress_->Note(
        "Going on with the run that was ended before its time, at step " +
        std::to_string(checkpoint_.num_steps) +
        " of the training (--StructNeRF.resume 0 starts anew).");
  }
  const std::string journal_path = (fs::path(notes_path) / "journal").string();
  const std::string fingerprint = InputFingerprint(
      *reconstruction_, options_.image_path, options_.mask_path);
  if (checkpoint_.num_steps < 0 &&
      !FileJournal::Exists(journal_path, fingerprint)) {
    staged_folder_->Clear();  // of another scene, and nothing to be lost
  }
  journal_ = std::make_unique<FileJournal>(
      journal_path, staged_folder_->Path(), fingerprint);
  if (time_budget_.IsLimited()) {
    RememberQuality(
        notes_path,
        {options_.quality, options_.reconstruction.stereo.num_iterations});
  }
}

void StructNerfController::UndistortImages() {
  StageProgress stage = BeginStage("Undistorting images");
  mask_path_ = options_.mask_path;
  if (!HasNewWorkspace()) {
    // Fusion finds images and model beside the maps that are being made.
    fs::remove_all(workspace_->ImagesPath());
    fs::remove_all(workspace_->SparsePath());
    fs::create_directory_symlink(fs::canonical(options_.image_path),
                                 workspace_->ImagesPath());
    fs::create_directory_symlink(
        fs::canonical(DenseWorkspace(options_.workspace_path).SparsePath()),
        workspace_->SparsePath());
  } else {
    if (!options_.mask_path.empty()) {
      mask_path_ = (fs::path(workspace_->ReportFolder()) / "masks").string();
    }
    // The order of the images in this one is what the results refer to.
    reconstruction_ =
        std::make_shared<colmap::Reconstruction>(UndistortIntoWorkspace(
            *reconstruction_,
            options_.image_path,
            options_.mask_path,
            mask_path_,
            *workspace_,
            memory_plan_.num_decoded_images,
            [&](const size_t num_done) {
              stage.Report(num_done, reconstruction_->NumRegImages());
              return progress_->ShouldStop();
            },
            journal_.get()));
  }
  image_names_ = ImageNames(*reconstruction_);
  workspace_->CreateFolders(image_names_);
}

void StructNerfController::LoadScene() {
  BeginStage("Loading images");
  SceneConverterOptions converter_options;
  converter_options.image_path = workspace_->ImagesPath();
  converter_options.mask_path = mask_path_;
  converter_options.max_image_size =
      options_.reconstruction.training.max_image_size;
  converter_options.num_threads = memory_plan_.num_decoded_images;
  const ReconstructionOptions& method = options_.reconstruction;
  const bool needs_segments =
      method.loss.planar_weight > 0 || method.CompletesPlanes();
  converter_options.planar_min_area =
      needs_segments ? method.loss.planar_min_area : 0;
  Scene scene =
      ConvertScene(*reconstruction_, converter_options, progress_.get());
  if (!options_.prior_path.empty()) {
    for (const std::string& sentence : LoadPriors(options_.prior_path,
                                                  options_.prior_type,
                                                  progress_.get(),
                                                  &scene)) {
      Warn(sentence);
    }
  }
  report_.decisions.push_back(ChooseExposures(method.loss.exposure, &scene));
  if (!options_.export_path.empty()) {
    WriteScene(scene, options_.export_path);
  }
  report_.num_points3D = static_cast<int>(scene.points.size());
  report_.training_image_size = converter_options.max_image_size;
  for (const View& view : scene.views) {
    scene_.views.push_back(PoseOf(view));
  }
  EndIfToldTo();  // what comes now takes long and does not ask
  reconstructor_ = std::make_unique<Reconstructor>(
      std::move(scene),
      options_.reconstruction,
      EnginesOfDevice(options_.device,
                      [this](const std::string& sentence) { Warn(sentence); }));
  for (const std::string& warning : reconstructor_->Warnings()) {
    Warn(warning);
  }
  const std::vector<SceneDecision>& decisions = reconstructor_->Decisions();
  report_.decisions.insert(
      report_.decisions.end(), decisions.begin(), decisions.end());
  for (const SceneDecision& decision : report_.decisions) {
    progress_->Note(decision.Text());
  }
}

void StructNerfController::Train() {
  BeginStage("Training");
  reconstructor_->Train(
      progress_.get(), checkpoint_options_, TrainingSeconds());
  report_.training = reconstructor_->Summary();
  options_.reconstruction = reconstructor_->Options();
}

double StructNerfController::TrainingSeconds() {
  if (!time_budget_.IsLimited() || checkpoint_.is_complete) {
    return 0;
  }
  // An untrained field takes as long to render as any.
  const size_t view_idx = scene_.views.size() / 2;
  StageTimer timer;
  timer.Begin("");
  SilentProgress view_progress(progress_.get());
  reconstructor_->RenderView(view_idx, &view_progress);
  timer.End();
  const double expected =
      EstimateTime(options_, {scene_.views[view_idx].camera}).rendering;
  const double slowness = timer.Stages()[0].seconds / expected;
  std::string note;
  const double seconds = time_budget_.TrainingSeconds(
      EstimateTime(options_, UndistortedCameras(*reconstruction_)),
      slowness,
      &note);
  if (!note.empty()) {
    Warn(note);
  }
  return seconds;
}

void StructNerfController::MakeMaps() {
  MapMakerOptions maker_options;
  maker_options.image_names = image_names_;
  maker_options.mask_path = mask_path_;
  maker_options.matches_views = options_.reconstruction.MatchesViews();
  maker_options.averages_depth = options_.reconstruction.AveragesDepth();
  maker_options.reuses_maps = checkpoint_.is_complete;
  maker_options.max_bytes = memory_plan_.depth_map_bytes;
  maker_options.extraction = options_.reconstruction.extraction;
  maker_options.num_threads = options_.reconstruction.training.num_threads;
  MapMaker maker(maker_options, &scene_, workspace_.get(), journal_.get());

  StageProgress rendering = BeginStage("Rendering depth maps");
  maker.RenderMaps(reconstructor_.get(), &rendering);
  reconstructor_->SaveField(workspace_->FieldPath());

  // Where depth was not matched, no planes are looked for.
  StageProgress completion = BeginStage(
      options_.reconstruction.CompletesPlanes() ? "Completing planes"
                                                : "Writing depth maps");
  report_.num_completed_pixels =
      maker.CompletePlanes(reconstructor_.get(), &completion);
  const std::vector<std::vector<int>> source_views =
      reconstructor_->SourceViews();
  averaging_views_ = reconstructor_->AveragingViews();
  reconstructor_.reset();  // its memory is the maps' from now on

  StageProgress check = BeginStage("Checking consistency");
  maker.CheckConsistency(source_views, &check);
  report_.views = maker.Views();
}

void StructNerfController::FusePoints() {
  BeginStage("Fusing points");
  colmap::mvs::StereoFusionOptions fusion_options = options_.fusion;
  if (fusion_options.num_threads == -1) {
    fusion_options.num_threads = options_.reconstruction.training.num_threads;
  }
  fusion_options.min_num_pixels =
      MinNumPixels(fusion_options, image_names_.size());
  report_.fusion_min_num_pixels = fusion_options.min_num_pixels;
  // As of now: COLMAP's threads end the process where memory fails them.
  const size_t limit =
      std::min(memory_plan_.limit, MemoryLimit(options_.max_memory_gb));
  const std::string note =
      FitFusionIntoMemory(UndistortedCameras(*reconstruction_),
                          limit - std::min(limit, CurrentMemory()),
                          &fusion_options);
  if (!note.empty()) {
    progress_->Note(note);
  }
  if (!HasNewWorkspace()) {
    workspace_->CopyConfigsOf(DenseWorkspace(options_.ResultPath()));
  }
  const MapType map_type = options_.input_type == "geometric"
                               ? MapType::kGeometric
                               : MapType::kPhotometric;
  report_.num_fused_points = FuseMaps(*workspace_,
                                      map_type,
                                      fusion_options,
                                      image_names_.size(),
                                      progress_.get());
  if (report_.num_fused_points == 0) {
    const bool has_geometric = std::any_of(
        report_.views.begin(), report_.views.end(), [](const ViewReport& view) {
          return view.num_geometric > 0;
        });
    Warn(
        EmptyCloudText(map_type, has_geometric, fusion_options.min_num_pixels));
  }
}

void StructNerfController::AverageMaps() {
  if (!options_.reconstruction.AveragesDepth()) {
    return;
  }
  MapAveragingOptions averaging_options;
  averaging_options.image_names = image_names_;
  averaging_options.max_bytes = memory_plan_.depth_map_bytes;
  averaging_options.extraction = options_.reconstruction.extraction;
  averaging_options.num_threads = options_.reconstruction.training.num_threads;
  StageProgress stage = BeginStage("Averaging depth maps");
  const std::vector<size_t> num_geometric = structnerf::AverageMaps(
      averaging_options, scene_, averaging_views_, *workspace_, &stage);
  for (size_t i = 0; i < num_geometric.size(); ++i) {
    report_.views[i].num_geometric = num_geometric[i];
  }
}

void StructNerfController::WriteResults() {
  timer_.End();
  report_.stages = timer_.Stages();
  report_.peak_memory = PeakMemory();
  report_.workspace_path = options_.ResultPath();
  // As the scene has completed them.
  for (const OptionEntry& entry : MakeOptionTable(&options_)) {
    report_.options.emplace(entry.name, entry.Value());
  }
  WriteReport(report_, workspace_->ReportFolder());
  staged_folder_->Commit();
  // Only now: a run that is killed while results are moved still needs them.
  DenseWorkspace(options_.ResultPath()).RemoveInterimMaps();
}

void StructNerfController::EndIfToldTo() {
  PauseOrAbort(progress_.get());
  if (progress_->ShouldStop()) {
    throw Aborted();  // nothing has been learned that could be written
  }
}

StageProgress StructNerfController::BeginStage(const std::string& name) {
  timer_.Begin(name);
  return StageProgress(name, progress_.get());
}

void StructNerfController::Warn(const std::string& sentence) {
  report_.warnings.push_back(sentence);
  progress_->Warn(sentence);
}

}  // namespace structnerf
