#include "colmap_plugin/evaluation/evaluation_report.h"
#include "colmap_plugin/text_output.h"
#include "nerf/extract/confidence.h"

namespace structnerf {
namespace {

// "-" if there is nothing to tell.
std::string Number(const char* format, const double value, const bool known) {
  return known ? FormatNumber(format, value) : "-";
}

void AppendMetricsRow(const char* scale,
                      const char* pixels,
                      const DepthMetrics& metrics,
                      std::string* text) {
  const bool known = metrics.num_predictions > 0;
  AppendF(text,
          "  %-12s %-10s %10zu %6.1f %7s %7s %8s %6s %6.1f %6.1f %6.1f\n",
          scale,
          pixels,
          metrics.num_pixels,
          100 * metrics.completeness,
          Number("%.3f", metrics.rmse, known).c_str(),
          Number("%.2f", 100 * metrics.median_error, known).c_str(),
          Number("%.4f", metrics.abs_rel, known).c_str(),
          Number("%.1f", 100 * metrics.delta[0], known).c_str(),
          100 * metrics.within[0],
          100 * metrics.within[1],
          100 * metrics.within[2]);
}

void AppendSplit(const char* scale,
                 const std::optional<SplitDepthMetrics>& metrics,
                 std::string* text) {
  if (metrics) {
    AppendMetricsRow(scale, "all", metrics->all, text);
    AppendMetricsRow("", "textured", metrics->textured, text);
    AppendMetricsRow("", "untextured", metrics->untextured, text);
  }
}

void AppendMaps(const std::string& title,
                const MapEvaluation& maps,
                std::string* text) {
  const DepthEvaluation& depth = maps.depth;
  AppendF(text,
          "%s: %zu images, %zu without a map; %.1f %% of the pixels are "
          "textured\n"
          "  %-12s %-10s %10s %6s %7s %7s %8s %6s %6s %6s %6s\n",
          title.c_str(),
          depth.num_images,
          depth.num_images_without_map,
          100 * depth.textured_share,
          "scale from",
          "pixels",
          "number",
          "has %",
          "RMSE m",
          "med cm",
          "abs-rel",
          "d<1.25",
          "<2cm",
          "<5cm",
          "<10cm");
  AppendSplit("SfM", depth.in_sfm_scale, text);
  AppendSplit("predictions", depth.in_predictions_scale, text);
  AppendSplit("each image", depth.in_image_scale, text);
  AppendF(text,
          "  Plane mean deviation %s cm in %zu regions (truth there: %s cm)\n",
          Number("%.2f",
                 100 * maps.planes.predicted.Mean(),
                 maps.planes.predicted.NumPoints() > 0)
              .c_str(),
          maps.planes.predicted.NumPlanes(),
          Number("%.2f",
                 100 * maps.planes.truth.Mean(),
                 maps.planes.truth.NumPoints() > 0)
              .c_str());
}

void AppendCloud(const CloudEvaluation& cloud,
                 const CloudEvaluationOptions& options,
                 std::string* text) {
  const CloudMetrics& metrics = cloud.metrics;
  const bool known =
      metrics.num_predicted_points > 0 && metrics.num_true_points > 0;
  const auto centimetres = [&](const double metres) {
    return Number("%.2f", 100 * metres, known);
  };
  AppendF(text,
          "Cloud: %zu points, %zu in voxels of %g cm (%zu more unobserved), "
          "truth %zu\n"
          "  accuracy %s cm (median %s), completeness %s cm (median %s)\n",
          cloud.num_fused_points,
          metrics.num_predicted_points,
          100 * options.voxel_size,
          cloud.num_unobserved_points,
          metrics.num_true_points,
          centimetres(metrics.accuracy_mean).c_str(),
          centimetres(metrics.accuracy_median).c_str(),
          centimetres(metrics.completeness_mean).c_str(),
          centimetres(metrics.completeness_median).c_str());
  for (size_t i = 0; i < metrics.precision.size(); ++i) {
    AppendF(text,
            "  at %4s: precision %5.1f %%, recall %5.1f %%, F %5.1f %%\n",
            kErrorThresholdNames[i],
            100 * metrics.precision[i],
            100 * metrics.recall[i],
            100 * metrics.f_score[i]);
  }
}

void AppendConfidence(const Reliability& confidence, std::string* text) {
  AppendF(text,
          "Confidence: %zu pixels, calibration error %.3f\n"
          "  %-12s %10s %12s %17s\n",
          confidence.NumPixels(),
          confidence.CalibrationError(),
          "confidence",
          "pixels",
          "predicted %",
          FormatNumber("within %g %%", 100 * kConfidentError).c_str());
  for (size_t bin = 0; bin < Reliability::kNumBins; ++bin) {
    if (confidence.NumPixels(bin) > 0) {
      const double width = 1.0 / Reliability::kNumBins;
      AppendF(text,
              "  %.1f to %.1f   %10zu %12.1f %17.1f\n",
              bin * width,
              (bin + 1) * width,
              confidence.NumPixels(bin),
              100 * confidence.MeanPrediction(bin),
              100 * confidence.ShareRight(bin));
    }
  }
}

}  // namespace

std::string EvaluationText(const Evaluation& evaluation) {
  std::string text;
  if (evaluation.scale.num_observations > 0) {
    AppendF(&text,
            "Scale: %.5g m per unit, from %zu observations, spread %.2f %%\n",
            evaluation.scale.metres_per_unit,
            evaluation.scale.num_observations,
            100 * evaluation.scale.relative_spread);
  }
  for (const auto& [name, maps] : evaluation.maps) {
    AppendMaps("Depth maps (" + name + ")", maps, &text);
  }
  if (evaluation.confidence) {
    AppendConfidence(*evaluation.confidence, &text);
  }
  if (evaluation.cloud) {
    AppendCloud(*evaluation.cloud, evaluation.options.cloud, &text);
  }
  if (evaluation.held_out) {
    const HeldOutEvaluation& held_out = *evaluation.held_out;
    const std::optional<double> lpips = held_out.MeanLpips();
    AppendF(&text,
            "Held-out images: %zu, PSNR %.2f dB, SSIM %.4f, LPIPS %s\n",
            held_out.images.size(),
            held_out.MeanPsnr(),
            held_out.MeanSsim(),
            Number("%.4f", lpips.value_or(0), lpips.has_value()).c_str());
  }
  if (evaluation.held_out_depth) {
    AppendMaps("Held-out depth (rendered)", *evaluation.held_out_depth, &text);
  }
  for (const std::string& note : evaluation.notes) {
    text += "Note: " + note + "\n";
  }
  return text;
}

}  // namespace structnerf
