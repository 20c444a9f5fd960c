#include "colmap_plugin/evaluation/evaluation_report.h"
#include "colmap_plugin/json_text.h"
#include "nerf/extract/confidence.h"

#include <nlohmann/json.hpp>

namespace structnerf {
namespace {

using nlohmann::json;

// Raised when a field changes its name or meaning.
constexpr int kSchemaVersion = 1;

constexpr const char* kDeltaNames[] = {
    "delta_1.25", "delta_1.25^2", "delta_1.25^3"};

json KnownOrNull(const double value, const bool is_known) {
  return is_known ? json(value) : json(nullptr);
}

json MetricsJson(const DepthMetrics& metrics) {
  const bool has_errors = metrics.num_predictions > 0;
  json object = {
      {"pixels", metrics.num_pixels},
      {"predictions", metrics.num_predictions},
      {"completeness", metrics.completeness},
      {"rmse_m", KnownOrNull(metrics.rmse, has_errors)},
      {"median_abs_m", KnownOrNull(metrics.median_error, has_errors)},
      {"abs_rel", KnownOrNull(metrics.abs_rel, has_errors)}};
  for (size_t i = 0; i < metrics.delta.size(); ++i) {
    object[kDeltaNames[i]] = KnownOrNull(metrics.delta[i], has_errors);
  }
  for (size_t i = 0; i < metrics.within.size(); ++i) {
    object[std::string("within_") + kErrorThresholdNames[i]] =
        metrics.within[i];
  }
  return object;
}

json SplitJson(const std::optional<SplitDepthMetrics>& metrics) {
  if (!metrics) {
    return nullptr;
  }
  return {{"all", MetricsJson(metrics->all)},
          {"textured", MetricsJson(metrics->textured)},
          {"untextured", MetricsJson(metrics->untextured)}};
}

json PlanesJson(const PlaneEvaluation& planes) {
  return {
      {"mean_deviation_m",
       KnownOrNull(planes.predicted.Mean(), planes.predicted.NumPoints() > 0)},
      {"planes", planes.predicted.NumPlanes()},
      {"points", planes.predicted.NumPoints()},
      {"truth_mean_deviation_m",
       KnownOrNull(planes.truth.Mean(), planes.truth.NumPoints() > 0)}};
}

json MapsJson(const MapEvaluation& maps) {
  const DepthEvaluation& depth = maps.depth;
  json images = json::array();
  for (const ImageDepthMetrics& image : depth.images) {
    json object = MetricsJson(image.metrics);
    object["name"] = image.name;
    object["has_map"] = image.has_map;
    object["metres_per_unit"] =
        KnownOrNull(image.metres_per_unit, image.metres_per_unit > 0);
    images.push_back(std::move(object));
  }
  return {{"images", depth.num_images},
          {"images_without_map", depth.num_images_without_map},
          {"predictions_metres_per_unit",
           KnownOrNull(depth.predictions_metres_per_unit,
                       depth.predictions_metres_per_unit > 0)},
          {"textured_share", depth.textured_share},
          {"sfm_scale", SplitJson(depth.in_sfm_scale)},
          {"predictions_scale", SplitJson(depth.in_predictions_scale)},
          {"image_scale", SplitJson(depth.in_image_scale)},
          {"planes", PlanesJson(maps.planes)},
          {"per_image", std::move(images)}};
}

json ConfidenceJson(const Reliability& confidence) {
  json bins = json::array();
  for (size_t bin = 0; bin < Reliability::kNumBins; ++bin) {
    const bool is_known = confidence.NumPixels(bin) > 0;
    bins.push_back(
        {{"pixels", confidence.NumPixels(bin)},
         {"predicted", KnownOrNull(confidence.MeanPrediction(bin), is_known)},
         {"right", KnownOrNull(confidence.ShareRight(bin), is_known)}});
  }
  return {{"pixels", confidence.NumPixels()},
          {"max_relative_error", kConfidentError},
          {"calibration_error", confidence.CalibrationError()},
          {"bins", std::move(bins)}};
}

json CloudJson(const CloudEvaluation& cloud,
               const CloudEvaluationOptions& options) {
  const CloudMetrics& metrics = cloud.metrics;
  json object = {{"fused_points", cloud.num_fused_points},
                 {"unobserved_points", cloud.num_unobserved_points},
                 {"voxel_m", options.voxel_size},
                 {"predicted_points", metrics.num_predicted_points},
                 {"truth_points", metrics.num_true_points}};
  const bool is_known =
      metrics.num_predicted_points > 0 && metrics.num_true_points > 0;
  object["accuracy_mean_m"] = KnownOrNull(metrics.accuracy_mean, is_known);
  object["accuracy_median_m"] = KnownOrNull(metrics.accuracy_median, is_known);
  object["completeness_mean_m"] =
      KnownOrNull(metrics.completeness_mean, is_known);
  object["completeness_median_m"] =
      KnownOrNull(metrics.completeness_median, is_known);
  for (size_t i = 0; i < metrics.precision.size(); ++i) {
    const std::string name = kErrorThresholdNames[i];
    object["precision_" + name] = metrics.precision[i];
    object["recall_" + name] = metrics.recall[i];
    object["f_" + name] = metrics.f_score[i];
  }
  return object;
}

json HeldOutJson(const Evaluation& evaluation) {
  const HeldOutEvaluation& held_out = *evaluation.held_out;
  json images = json::array();
  for (const HeldOutImage& image : held_out.images) {
    images.push_back(
        {{"name", image.name},
         {"psnr", image.psnr},
         {"ssim", image.ssim},
         {"lpips",
          KnownOrNull(image.lpips.value_or(0), image.lpips.has_value())}});
  }
  const std::optional<double> lpips = held_out.MeanLpips();
  json object = {{"psnr", held_out.MeanPsnr()},
                 {"ssim", held_out.MeanSsim()},
                 {"lpips", KnownOrNull(lpips.value_or(0), lpips.has_value())},
                 {"seen_by_structure_from_motion",
                  evaluation.options.held_out.test_workspace_path.empty()},
                 {"per_image", std::move(images)}};
  if (held_out.num_common_views > 0) {
    object["alignment"] = {{"common_views", held_out.num_common_views},
                           {"relative_error", held_out.alignment_error}};
  }
  if (evaluation.held_out_depth) {
    object["depth"] = MapsJson(*evaluation.held_out_depth);
  }
  return object;
}

}  // namespace

std::string EvaluationJson(const Evaluation& evaluation) {
  const EvaluationOptions& options = evaluation.options;
  json object = {{"schema_version", kSchemaVersion},
                 {"workspace_path", options.workspace_path},
                 {"maps", json::object()},
                 {"notes", evaluation.notes}};
  if (!options.truth.path.empty()) {
    object["ground_truth"] = {
        {"path", options.truth.path},
        {"depth_scale", options.truth.scale},
        {"min_depth_m", options.truth.min_depth},
        {"max_depth_m", options.truth.max_depth},
        {"images_without", evaluation.num_images_without_truth}};
    const SceneScale& scale = evaluation.scale;
    const bool is_known = scale.num_observations > 0;
    object["scale"] = {
        {"metres_per_unit", KnownOrNull(scale.metres_per_unit, is_known)},
        {"relative_spread", KnownOrNull(scale.relative_spread, is_known)},
        {"observations", scale.num_observations}};
  }
  for (const auto& [name, maps] : evaluation.maps) {
    object["maps"][name] = MapsJson(maps);
  }
  if (evaluation.confidence) {
    object["confidence"] = ConfidenceJson(*evaluation.confidence);
  }
  if (evaluation.cloud) {
    object["cloud"] = CloudJson(*evaluation.cloud, options.cloud);
  }
  if (evaluation.held_out) {
    object["held_out"] = HeldOutJson(evaluation);
  }
  return JsonText(object);
}

}  // namespace structnerf
