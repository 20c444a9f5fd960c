#include "colmap_plugin/exposure_fit.h"

#include "colmap_plugin/text_output.h"
#include "nerf/analysis/point_colors.h"
#include "nerf/util/median.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <ceres/ceres.h>

namespace structnerf {
namespace {

// Variation beyond which exposures are significant.
constexpr double kSignificantVariation = 0.02;

// How closely photographs show a colour, beyond which differences count less;
// and how far exposures stray from each other unless points ask for it.
constexpr double kColorDeviation = 0.03;
constexpr double kGainDeviation = 0.5;
constexpr double kOffsetDeviation = 0.05;

constexpr int kMaxIterations = 50;

// photograph - (gain * colour + offset), in deviations.
struct ColorError {
  double photograph;

  template <typename T>
  bool operator()(const T* exposure, const T* color, T* residual) const {
    *residual =
        (photograph - (exposure[0] * *color + exposure[1])) / kColorDeviation;
    return true;
  }
};

// Keeps exposures of few points near the mean, and the common brightness from
// wandering between exposures and colours.
struct ExposurePrior {
  template <typename T>
  bool operator()(const T* exposure, T* residuals) const {
    residuals[0] = (exposure[0] - 1.0) / kGainDeviation;
    residuals[1] = exposure[1] / kOffsetDeviation;
    return true;
  }
};

// One channel of a scene.
struct ChannelFit {
  std::vector<std::array<double, 2>> exposures;  // gain and offset of each view
  std::vector<double> colors;                    // of each point
};

// Equal exposures, and of each point the mean of its colours.
ChannelFit InitialFit(const Scene& scene,
                      const std::vector<PointColor>& colors,
                      const int channel) {
  ChannelFit fit;
  fit.exposures.resize(scene.views.size(), {1.0, 0.0});
  fit.colors.resize(scene.points.size(), 0.0);
  std::vector<int> counts(scene.points.size(), 0);
  for (const PointColor& observation : colors) {
    fit.colors[observation.point_idx] += observation.color[channel];
    ++counts[observation.point_idx];
  }
  for (size_t i = 0; i < counts.size(); ++i) {
    fit.colors[i] /= std::max(1, counts[i]);
  }
  return fit;
}

void Solve(const std::vector<PointColor>& colors,
           const int channel,
           ChannelFit* fit) {
  ceres::Problem problem;
  for (const PointColor& observation : colors) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<ColorError, 1, 2, 1>(
            new ColorError{observation.color[channel]}),
        new ceres::HuberLoss(1.0),
        fit->exposures[observation.view_idx].data(),
        &fit->colors[observation.point_idx]);
  }
  for (std::array<double, 2>& exposure : fit->exposures) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<ExposurePrior, 2, 2>(new ExposurePrior),
        nullptr,
        exposure.data());
    problem.SetParameterLowerBound(exposure.data(), 0, 0.05);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_SCHUR;
  options.max_num_iterations = kMaxIterations;
  options.num_threads = 1;  // sums in one order
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
}

// Moves the mean of the exposures into the colours of the points.
void NormalizeMean(ChannelFit* fit) {
  double log_gain = 0;
  double offset = 0;
  for (const std::array<double, 2>& exposure : fit->exposures) {
    log_gain += std::log(exposure[0]) / fit->exposures.size();
    offset += exposure[1] / fit->exposures.size();
  }
  const double gain = std::exp(log_gain);
  double mean_ratio = 0;
  for (std::array<double, 2>& exposure : fit->exposures) {
    exposure[0] /= gain;
    mean_ratio += exposure[0] / fit->exposures.size();
  }
  const double shift = offset / mean_ratio;
  for (std::array<double, 2>& exposure : fit->exposures) {
    exposure[1] -= exposure[0] * shift;
  }
  for (double& color : fit->colors) {
    color = gain * color + shift;
  }
}

void AddResiduals(const std::vector<PointColor>& colors,
                  const int channel,
                  const ChannelFit& fit,
                  std::vector<double>* residuals) {
  for (const PointColor& observation : colors) {
    const std::array<double, 2>& exposure = fit.exposures[observation.view_idx];
    residuals->push_back(std::abs(
        observation.color[channel] -
        (exposure[0] * fit.colors[observation.point_idx] + exposure[1])));
  }
}

}  // namespace

bool ExposureFit::IsSignificant() const {
  return variation > kSignificantVariation;
}

ExposureFit FitExposures(const Scene& scene) {
  const std::vector<PointColor> colors = CollectPointColors(scene);
  ExposureFit result;
  result.exposures.resize(scene.views.size());
  std::vector<double> residuals_before;
  std::vector<double> residuals;
  double sum_squares = 0;
  for (int channel = 0; channel < 3; ++channel) {
    ChannelFit fit = InitialFit(scene, colors, channel);
    AddResiduals(colors, channel, fit, &residuals_before);
    Solve(colors, channel, &fit);
    NormalizeMean(&fit);
    AddResiduals(colors, channel, fit, &residuals);
    for (size_t v = 0; v < scene.views.size(); ++v) {
      const auto [gain, offset] = fit.exposures[v];
      result.exposures[v].gain[channel] = static_cast<float>(gain);
      result.exposures[v].offset[channel] = static_cast<float>(offset);
      sum_squares += std::pow(0.5 * gain + offset - 0.5, 2);
    }
  }
  result.variation =
      std::sqrt(sum_squares / std::max<size_t>(1, 3 * scene.views.size()));
  result.residual_before = Median(&residuals_before);
  result.residual = Median(&residuals);
  return result;
}

SceneDecision ChooseExposures(const std::string& exposure, Scene* scene) {
  SceneDecision decision{"exposure", "equal for all images", ""};
  if (exposure == "none") {
    decision.reason =
        FormatNumber("colours of points differ by %.1f %% of the range, but ",
                     100 * MeasureColorSpread(*scene)) +
        "compensation was not asked for";
    return decision;
  }
  const ExposureFit fit = FitExposures(*scene);
  if (exposure == "affine" || fit.IsSignificant()) {
    decision.choice = "gain and offset per image";
    for (size_t v = 0; v < scene->views.size(); ++v) {
      scene->views[v].exposure = fit.exposures[v];
    }
  }
  decision.reason =
      FormatNumber("images differ by %.1f %% of the range, ",
                   100 * fit.variation) +
      FormatNumber("colours of points by %.1f %% before ",
                   100 * fit.residual_before) +
      FormatNumber("and %.1f %% after compensation", 100 * fit.residual);
  return decision;
}

}  // namespace structnerf
