#include "colmap_plugin/evaluation/evaluator.h"

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/evaluation/map_differences.h"
#include "colmap_plugin/evaluation/pixel_lookup.h"
#include "colmap_plugin/evaluation/workspace_maps.h"
#include "colmap_plugin/input_check.h"
#include "nerf/extract/confidence.h"
#include "nerf/util/median.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <stdexcept>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

// Of cameras of one model in two copies, relative to the distance between them.
constexpr double kMaxFrameDifference = 0.01;

// Runs one part after another and keeps the progress.
class Evaluator {
 public:
  Evaluator(const EvaluationOptions& options, RunProgress* progress)
      : workspace_(options.workspace_path),
        workspace_model_(ReadModel(workspace_.SparsePath())),
        progress_(progress) {
    evaluation_.options = options;
  }

  Evaluation Run() {
    LoadTruth();
    EvaluateImages();
    if (truth_ != nullptr) {
      for (const MapType type : {MapType::kPhotometric, MapType::kGeometric}) {
        if (IsWanted(type)) {
          EvaluateMaps(type);
        }
      }
      if (IsWanted(MapType::kPhotometric)) {
        EvaluateConfidence();
      }
      EvaluateFusedCloud();
      EvaluateHeldOutDepth();
    }
    if (evaluation_.maps.empty() && !evaluation_.cloud &&
        !evaluation_.held_out) {
      throw std::runtime_error("Nothing to evaluate in " + workspace_.Path() +
                               ": " + Reasons());
    }
    return std::move(evaluation_);
  }

 private:
  void Note(const std::string& sentence) {
    evaluation_.notes.push_back(sentence);
  }

  bool IsWanted(const MapType type) const {
    return evaluation_.options.map_type.value_or(type) == type;
  }

  std::string Reasons() const {
    std::string text;
    for (const std::string& note : evaluation_.notes) {
      text += (text.empty() ? "" : " ") + note;
    }
    return text;
  }

  // The scale is that of the original model's points.
  void RequireSameFrame() const {
    std::vector<double> distances;
    std::vector<double> differences;
    const auto image_ids = RegisteredImageIds(original_model_);
    for (const colmap::image_t image_id : image_ids) {
      const colmap::Image& image = original_model_.Image(image_id);
      const colmap::Image* const there =
          workspace_model_.FindImageWithName(image.Name());
      if (there != nullptr) {
        const colmap::Image& first = original_model_.Image(image_ids.front());
        const Eigen::Vector3d center = image.ProjectionCenter();
        distances.push_back((center - first.ProjectionCenter()).norm());
        differences.push_back((center - there->ProjectionCenter()).norm());
      }
    }
    if (!distances.empty() &&
        Median(&differences) > kMaxFrameDifference * Median(&distances)) {
      throw std::runtime_error(
          "The model " + evaluation_.options.input_path +
          " (--input_path) is not the one that the workspace " +
          evaluation_.options.workspace_path +
          " was made from: its cameras stand elsewhere. Give that one, or "
          "leave out --input_path and --image_path if the ground truth belongs "
          "to the undistorted images.");
    }
  }

  void LoadTruth() {
    const EvaluationOptions& options = evaluation_.options;
    if (options.truth.path.empty()) {
      Note(
          "Depth was not evaluated, because --ground_truth_path was not "
          "given.");
      return;
    }
    StageProgress stage("Reading ground truth", progress_);
    if (!options.input_path.empty()) {
      original_model_ = ReadModel(options.input_path);
      RequireSameFrame();
    }
    truth_ = std::make_unique<TruthViews>(
        options.input_path.empty() ? workspace_model_ : original_model_,
        options.input_path.empty() ? workspace_.ImagesPath()
                                   : options.image_path,
        options.truth);
    evaluation_.num_images_without_truth = truth_->NumWithoutTruth();
    if (truth_->NumWithoutTruth() > 0) {
      Note(std::to_string(truth_->NumWithoutTruth()) +
           " registered images have no ground truth and were left out.");
    }
    evaluation_.scale = truth_->EstimateScale();
    if (evaluation_.scale.num_observations == 0) {
      Note(
          "The scale of structure-from-motion is not known, because no "
          "observation of a sparse point has ground truth.");
    }
  }

  void EvaluateMaps(const MapType type) {
    const WorkspaceMaps maps(workspace_, workspace_model_, type);
    if (!maps.HasAny()) {
      Note("The workspace has no " + MapTypeName(type) + " depth maps.");
      return;
    }
    const auto source = [&](const std::string& name) {
      return maps.Find(name);
    };
    MeasureMaps("Evaluating " + MapTypeName(type) + " maps",
                truth_->Names(),
                source,
                kPixelCorner,
                workspace_.ImagesPath(),
                &evaluation_.maps[MapTypeName(type)]);
  }

  void MeasureMaps(const std::string& stage_name,
                   const std::vector<std::string>& names,
                   const DepthSource& source,
                   const double offset,
                   const std::string& image_path,
                   MapEvaluation* maps) {
    StageProgress stage(stage_name, progress_);
    maps->depth =
        EvaluateDepth(names, source, evaluation_.scale, truth_.get(), &stage);
    StageProgress plane_stage(stage_name + ", planes", progress_);
    maps->planes = EvaluatePlanes(
        maps->depth, source, offset, image_path, *truth_, &plane_stage);
  }

  // Metres per unit from structure-from-motion, or from the maps; 0 = unknown.
  double MetresPerUnit() const {
    if (evaluation_.scale.metres_per_unit > 0 || evaluation_.maps.empty()) {
      return evaluation_.scale.metres_per_unit;
    }
    return evaluation_.maps.begin()->second.depth.predictions_metres_per_unit;
  }

  void EvaluateConfidence() {
    const WorkspaceMaps maps(
        workspace_, workspace_model_, MapType::kPhotometric);
    StageProgress stage("Evaluating confidence", progress_);
    const double metres_per_unit = MetresPerUnit();
    Reliability reliability;
    size_t num_done = 0;
    for (const std::string& name : truth_->Names()) {
      if (fs::exists(workspace_.ConfidencePath(name))) {
        if (const auto predicted = maps.Find(name)) {
          AddReliability(name, *predicted, metres_per_unit, &reliability);
        }
      }
      stage.Report(++num_done, truth_->Names().size());
    }
    if (reliability.NumPixels() > 0) {
      evaluation_.confidence = reliability;
    }
  }

  void AddReliability(const std::string& name,
                      const PredictedDepth& predicted,
                      const double metres_per_unit,
                      Reliability* reliability) {
    FloatArray array = workspace_.ReadConfidence(name);
    if (array.width != predicted.depth.cols ||
        array.height != predicted.depth.rows) {
      throw std::runtime_error("The depth map and the confidence of " + name +
                               " have different sizes.");
    }
    const cv::Mat1f truth = truth_->Depth(name);
    const cv::Mat1f errors =
        AbsoluteErrors(predicted, metres_per_unit, truth, name, truth_.get());
    const cv::Mat1f confidence =
        LookUp(truth_->Rays(name, truth.size()),
               predicted.camera,
               cv::Mat1f(array.height, array.width, array.values.data()));
    for (int row = 0; row < truth.rows; ++row) {
      for (int col = 0; col < truth.cols; ++col) {
        if (errors(row, col) >= 0) {
          reliability->Add(
              confidence(row, col),
              errors(row, col) <= kConfidentError * truth(row, col));
        }
      }
    }
  }

  void EvaluateFusedCloud() {
    if (!fs::exists(workspace_.FusedPath())) {
      Note("The workspace has no fused.ply.");
      return;
    }
    const double metres_per_unit = MetresPerUnit();
    if (metres_per_unit == 0) {
      Note("The cloud was not evaluated, because its scale is not known.");
      return;
    }
    StageProgress stage("Evaluating the cloud", progress_);
    evaluation_.cloud = EvaluateCloud(workspace_.FusedPath(),
                                      metres_per_unit,
                                      evaluation_.options.cloud,
                                      truth_.get(),
                                      &stage);
  }

  void EvaluateImages() {
    const HeldOutOptions& options = evaluation_.options.held_out;
    if (!TrainedField::Exists(workspace_.Path())) {
      if (!options.test_workspace_path.empty()) {
        throw std::runtime_error("The workspace " + workspace_.Path() +
                                 " has no trained field to render the views of "
                                 "--test_workspace_path from.");
      }
      Note(
          "Images were not evaluated, because the workspace has no trained "
          "field.");
      return;
    }
    StageProgress stage("Rendering held-out views", progress_);
    const TrainedField field(workspace_.Path());
    HeldOutEvaluation held_out =
        EvaluateHeldOut(workspace_.Path(), field, options, &stage);
    if (held_out.images.empty()) {
      Note(
          "Images were not evaluated, because training held out no view; pass "
          "--StructNeRF.test_every to structnerf_dense, or "
          "--test_workspace_path here.");
      return;
    }
    if (options.lpips_path.empty()) {
      Note(
          "LPIPS was not measured, because --lpips_path was not given; its "
          "weights are not part of this program.");
    }
    evaluation_.held_out = std::move(held_out);
  }

  void EvaluateHeldOutDepth() {
    if (!evaluation_.held_out) {
      return;
    }
    std::vector<std::string> names;
    size_t num_skipped = 0;
    for (const HeldOutImage& image : evaluation_.held_out->images) {
      const auto& all = truth_->Names();
      if (std::binary_search(all.begin(), all.end(), image.name)) {
        names.push_back(image.name);
      } else {
        ++num_skipped;
      }
    }
    if (num_skipped > 0) {
      Note(std::to_string(num_skipped) +
           " held-out images have no ground truth, or are not in the model of "
           "--input_path that says how they were taken; their depth was left "
           "out.");
    }
    if (names.empty()) {
      return;
    }
    const auto source = [&](const std::string& name) {
      return std::optional<PredictedDepth>(
          evaluation_.held_out->depth.at(name));
    };
    MeasureMaps("Evaluating held-out depth",
                names,
                source,
                kPixelCenter,
                evaluation_.held_out->image_path,
                &evaluation_.held_out_depth.emplace());
  }

  const DenseWorkspace workspace_;
  const colmap::Reconstruction workspace_model_;
  RunProgress* progress_;
  colmap::Reconstruction original_model_;
  std::unique_ptr<TruthViews> truth_;
  Evaluation evaluation_;
};

}  // namespace

void EvaluationOptions::Check() const {
  if (workspace_path.empty()) {
    throw std::runtime_error("The option --workspace_path is missing.");
  }
  CheckWorkspaceFolder(workspace_path);
  CheckTruth(truth, input_path, image_path);
  cloud.Check();
  for (const auto& [name, path] :
       {std::pair("lpips_path", held_out.lpips_path),
        std::pair("test_workspace_path", held_out.test_workspace_path)}) {
    if (!path.empty() && !fs::exists(path)) {
      throw std::runtime_error(path + " of --" + name + " does not exist.");
    }
  }
}

Evaluation Evaluate(const EvaluationOptions& options, RunProgress* progress) {
  options.Check();
  return Evaluator(options, progress).Run();
}

}  // namespace structnerf
