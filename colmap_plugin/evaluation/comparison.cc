#include "colmap_plugin/evaluation/comparison.h"

#include "colmap_plugin/evaluation/compared_maps.h"
#include "colmap_plugin/evaluation/comparison_pictures.h"
#include "colmap_plugin/evaluation/map_differences.h"
#include "colmap_plugin/evaluation/model_alignment.h"
#include "colmap_plugin/evaluation/ply_positions.h"
#include "colmap_plugin/input_check.h"
#include "colmap_plugin/report_reader.h"
#include "colmap_plugin/stage_progress.h"
#include "colmap_plugin/text_output.h"
#include "nerf/util/quantile.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <stdexcept>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

// The depth scale of the pictures runs between these quantiles of all depths,
// of which one in so many is looked at.
constexpr double kLowQuantile = 0.02;
constexpr double kHighQuantile = 0.98;
constexpr size_t kDepthStride = 61;

constexpr double kLargestError = 0.2;       // metres
constexpr double kLargestDifference = 0.1;  // relative
constexpr double kWarnAlignmentError = 0.02;

MapType OtherType(const MapType type) {
  return type == MapType::kGeometric ? MapType::kPhotometric
                                     : MapType::kGeometric;
}

bool IsDepth(const float value) { return value > 0 && std::isfinite(value); }

double ShareOfDepths(const std::optional<PredictedDepth>& map) {
  if (!map) {
    return 0;
  }
  return static_cast<double>(
             std::count_if(map->depth.begin(), map->depth.end(), IsDepth)) /
         map->depth.total();
}

// Whether the view is one of `num_chosen` that are spread over `num_all`.
bool IsChosen(const size_t idx, const size_t num_all, const size_t num_chosen) {
  return num_chosen == 0 || num_chosen >= num_all ||
         idx * num_chosen / num_all != (idx + 1) * num_chosen / num_all;
}

// Runs one part after another and keeps the progress.
class Comparer {
 public:
  Comparer(const ComparisonOptions& options, RunProgress* progress)
      : options_(options), progress_(progress) {
    comparison_.options = options;
    comparison_.largest_error = kLargestError;
    comparison_.largest_difference = kLargestDifference;
  }

  Comparison Run() {
    OpenWorkspaces();
    ChooseMapTypes();
    FindCommonViews();
    ReadFacts();
    if (!options_.truth.path.empty()) {
      CompareWithTruth();
    }
    MeasureMaps();
    MakePictures();
    return std::move(comparison_);
  }

 private:
  void Note(const std::string& sentence) {
    comparison_.notes.push_back(sentence);
  }

  MapType TypeOf(const size_t i) const {
    return comparison_.workspaces[i].map_type;
  }

  void OpenWorkspaces() {
    const StageProgress stage("Reading workspaces", progress_);
    for (size_t i = 0; i < 2; ++i) {
      maps_[i] = std::make_unique<ComparedMaps>(options_.workspace_paths[i]);
    }
  }

  void ChooseMapTypes() {
    const MapType wanted = options_.map_type == MapTypeName(MapType::kGeometric)
                               ? MapType::kGeometric
                               : MapType::kPhotometric;
    const auto both_have = [&](const MapType type) {
      return maps_[0]->Has(type) && maps_[1]->Has(type);
    };
    const MapType type = !both_have(wanted) && both_have(OtherType(wanted))
                             ? OtherType(wanted)
                             : wanted;
    for (size_t i = 0; i < 2; ++i) {
      if (!maps_[i]->Has(wanted)) {
        Note(std::string("Workspace ") + kLetters[i] + " has no " +
             MapTypeName(wanted) + " maps; its " +
             MapTypeName(OtherType(wanted)) + " ones are compared" +
             (type != wanted ? " with those of the other workspace." : "."));
      }
      comparison_.workspaces[i].map_type =
          maps_[i]->Has(type) ? type : OtherType(type);
    }
  }

  void FindCommonViews() {
    for (const View& view : maps_[0]->Views()) {
      if (maps_[1]->FindView(view.name) != nullptr) {
        names_.push_back(view.name);
      }
    }
    if (names_.empty()) {
      throw std::runtime_error("The workspaces " + options_.workspace_paths[0] +
                               " and " + options_.workspace_paths[1] +
                               " have no image in common.");
    }
    std::sort(names_.begin(), names_.end());
    const ModelAlignment alignment =
        AlignModels(maps_[1]->Views(), maps_[0]->Views());
    comparison_.a_per_b = alignment.scale;
    if (alignment.relative_error > kWarnAlignmentError) {
      Note("The two sparse models differ: camera positions by " +
           FormatNumber("%.1f", 100 * alignment.relative_error) +
           " % of their spread. Part of the differences in depth is theirs.");
    }
    for (size_t i = 0; i < 2; ++i) {
      const size_t num_more = maps_[i]->Views().size() - names_.size();
      if (num_more > 0) {
        Note(std::to_string(num_more) + " images are in workspace " +
             kLetters[i] + " alone and are not compared.");
      }
    }
  }

  // What the workspaces say about themselves.
  void ReadFacts() {
    for (size_t i = 0; i < 2; ++i) {
      ComparedWorkspace& compared = comparison_.workspaces[i];
      const DenseWorkspace& workspace = maps_[i]->Workspace();
      compared.path = workspace.Path();
      compared.num_views = maps_[i]->Views().size();
      if (fs::exists(workspace.FusedPath())) {
        compared.num_fused_points =
            ReadPlyPositions(workspace.FusedPath()).size();
      }
      const std::string report_path =
          (fs::path(workspace.ReportFolder()) / "report.json").string();
      if (fs::exists(report_path)) {
        const FinishedRun run = ReadReport(report_path);
        compared.seconds = run.seconds;
        compared.cpu_seconds = run.cpu_seconds;
      } else {
        Note(std::string("The time of workspace ") + kLetters[i] +
             " is not known, because it has no report.");
      }
    }
  }

  void CompareWithTruth() {
    comparison_.is_metric = true;
    for (size_t i = 0; i < 2; ++i) {
      EvaluationOptions evaluation;
      evaluation.workspace_path = options_.workspace_paths[i];
      evaluation.image_path = options_.image_path;
      evaluation.input_path = options_.input_path;
      evaluation.truth = options_.truth;
      evaluation.map_type = TypeOf(i);
      auto& measured = comparison_.workspaces[i].evaluation;
      measured = Evaluate(evaluation, progress_);
      if (measured->scale.metres_per_unit <= 0) {
        comparison_.is_metric = false;
        Note(std::string("Errors of single pixels are not shown, because the "
                         "scale of workspace ") +
             kLetters[i] + " is not known from its sparse points.");
      }
    }
    const bool is_original = !options_.input_path.empty();
    if (is_original) {
      original_model_ = ReadModel(options_.input_path);
    }
    truth_ = std::make_unique<TruthViews>(
        is_original ? original_model_ : maps_[0]->Model(),
        is_original ? options_.image_path : maps_[0]->Workspace().ImagesPath(),
        options_.truth);
  }

  void MeasureMaps() {
    StageProgress stage("Comparing maps", progress_);
    AgreementCounter agreement;
    std::vector<float> depths;
    for (const std::string& name : names_) {
      ViewComparison& view = comparison_.views.emplace_back();
      view.name = name;
      std::array<std::optional<PredictedDepth>, 2> maps;
      for (size_t i = 0; i < 2; ++i) {
        maps[i] = maps_[i]->Depth(name, TypeOf(i));
        view.coverage[i] = ShareOfDepths(maps[i]);
        comparison_.workspaces[i].coverage += view.coverage[i] / names_.size();
        view.median_error[i] = MedianError(name, i);
        if (maps[i]) {
          CollectDepths(
              maps[i]->depth,
              comparison_.DisplayScale() * (i == 0 ? 1.0 : comparison_.a_per_b),
              &depths);
        }
      }
      if (maps[0] && maps[1]) {
        view.agreement = agreement.Add(
            RelativeDifferences(*maps[0], *maps[1], comparison_.a_per_b));
      }
      stage.Report(comparison_.views.size(), names_.size());
    }
    comparison_.agreement = agreement.Total();
    if (!depths.empty()) {
      comparison_.nearest_depth = Quantile(&depths, kLowQuantile);
      comparison_.farthest_depth = Quantile(&depths, kHighQuantile);
    }
  }

  static void CollectDepths(const cv::Mat1f& depth,
                            const double scale,
                            std::vector<float>* depths) {
    for (size_t i = 0; i < depth.total(); i += kDepthStride) {
      const float value = depth(static_cast<int>(i / depth.cols),
                                static_cast<int>(i % depth.cols));
      if (IsDepth(value)) {
        depths->push_back(static_cast<float>(scale * value));
      }
    }
  }

  std::optional<double> MedianError(const std::string& name,
                                    const size_t i) const {
    const auto& evaluation = comparison_.workspaces[i].evaluation;
    if (!evaluation) {
      return std::nullopt;
    }
    const auto maps = evaluation->maps.find(MapTypeName(TypeOf(i)));
    if (maps == evaluation->maps.end()) {
      return std::nullopt;
    }
    for (const ImageDepthMetrics& image : maps->second.depth.images) {
      if (image.name == name && image.metrics.num_predictions > 0) {
        return image.metrics.median_error;
      }
    }
    return std::nullopt;
  }

  void MakePictures() {
    StageProgress stage("Making pictures", progress_);
    for (size_t i = 0; i < names_.size(); ++i) {
      if (IsChosen(i, names_.size(), options_.max_pictured_views)) {
        comparison_.views[i].pictures = MakeComparisonPictures(
            comparison_,
            {{maps_[0].get(), maps_[1].get()}, truth_.get()},
            names_[i]);
      }
      stage.Report(i + 1, names_.size());
    }
  }

  const ComparisonOptions options_;
  RunProgress* progress_;
  std::array<std::unique_ptr<ComparedMaps>, 2> maps_;
  std::vector<std::string> names_;  // of the common images, ascending
  colmap::Reconstruction original_model_;
  std::unique_ptr<TruthViews> truth_;
  Comparison comparison_;
};

}  // namespace

void ComparisonOptions::Check() const {
  for (const std::string& path : workspace_paths) {
    if (path.empty()) {
      throw std::runtime_error(
          "Two workspaces are needed: structnerf_compare A B.");
    }
    CheckWorkspaceFolder(path);
  }
  if (map_type != MapTypeName(MapType::kGeometric) &&
      map_type != MapTypeName(MapType::kPhotometric)) {
    throw std::runtime_error(
        "The option --input_type must be geometric or photometric, but is " +
        map_type + ".");
  }
  if (max_pictured_views < 0 || picture_size < 16) {
    throw std::runtime_error(
        "The option --max_pictured_views must not be negative, --picture_size "
        "must be at least 16.");
  }
  CheckTruth(truth, input_path, image_path);
}

double Comparison::DisplayScale() const {
  return is_metric ? workspaces[0].evaluation->scale.metres_per_unit : 1.0;
}

Comparison Compare(const ComparisonOptions& options, RunProgress* progress) {
  options.Check();
  return Comparer(options, progress).Run();
}

}  // namespace structnerf
