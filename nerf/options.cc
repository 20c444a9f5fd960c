#include "nerf/options.h"

#include "nerf/kernels/compositing.h"
#include "nerf/kernels/ray_sampling.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace structnerf {
namespace {

// Collects the first violated range.
class RangeChecker {
 public:
  template <typename T>
  RangeChecker& In(const char* name, const T value, const T low, const T high) {
    if (message_.empty() && !(value >= low && value <= high)) {
      std::ostringstream stream;
      stream << name << " must be between " << low << " and " << high
             << ", but is " << value;
      message_ = stream.str();
    }
    return *this;
  }

  // Or kFromScene.
  RangeChecker& InOrFromScene(const char* name,
                              const int value,
                              const int low,
                              const int high) {
    if (message_.empty() && value != kFromScene) {
      In(name, value, low, high);
      if (!message_.empty()) {
        message_ +=
            " (" + std::to_string(kFromScene) + " leaves it to the scene)";
      }
    }
    return *this;
  }

  RangeChecker& OneOf(const char* name,
                      const std::string& value,
                      const std::vector<std::string>& allowed) {
    if (message_.empty() &&
        std::find(allowed.begin(), allowed.end(), value) == allowed.end()) {
      message_ = std::string(name) + " must be ";
      for (size_t i = 0; i < allowed.size(); ++i) {
        const bool is_last = i + 1 == allowed.size();
        message_ += (i == 0 ? "" : is_last ? " or " : ", ") + allowed[i];
      }
      message_ += ", but is \"" + value + "\"";
    }
    return *this;
  }

  RangeChecker& Require(const bool condition, const char* message) {
    if (message_.empty() && !condition) {
      message_ = message;
    }
    return *this;
  }

  bool Report(std::string* error) const {
    if (!message_.empty()) {
      *error = message_;
    }
    return message_.empty();
  }

 private:
  std::string message_;
};

constexpr double kAnyWeight = 1e6;

// Matches of two views err independently, unlike the depth of one field: that
// they agree says more.
constexpr double kMaxDepthErrorOfMatches = 0.03;
constexpr double kMaxReprojectionErrorOfMatches = 3.0;
constexpr double kMinAngleOfMatches = 3.0;

// 0.01 to 0.03 are as good (nerf/EXPERIMENTS.md).
constexpr double kMatchWeight = 0.02;

void MatchViews(const int num_iterations, ReconstructionOptions* options) {
  options->stereo.num_iterations = num_iterations;
  options->extraction.max_relative_depth_error = kMaxDepthErrorOfMatches;
  options->extraction.max_reprojection_error = kMaxReprojectionErrorOfMatches;
  options->extraction.min_triangulation_angle = kMinAngleOfMatches;
}

}  // namespace

bool FieldOptions::Check(std::string* error) const {
  return RangeChecker()
      // The option's name on the command line.
      .OneOf("field", type, {"grid", "mlp"})
      .InOrFromScene("num_levels", num_levels, 1, 16)
      .InOrFromScene("log2_table_size", log2_table_size, 10, 24)
      .In("min_resolution", min_resolution, 2, 1024)
      .InOrFromScene("max_resolution", max_resolution, min_resolution, 65536)
      .In("hidden_width", hidden_width, 16, 64)
      .Require(hidden_width % 16 == 0, "hidden_width must be a multiple of 16")
      .In("direction_degree", direction_degree, 0, 2)
      .In("mlp_num_layers", mlp_num_layers, 1, 32)
      .In("mlp_width", mlp_width, 2, 1024)
      .Require(mlp_width % 2 == 0, "mlp_width must be even")
      .In("latent_size", latent_size, 0, 1024)
      .Require(latent_size == 0 || type == "mlp",
               "latent_size must be 0 unless field is mlp")
      .Report(error);
}

bool SamplingOptions::Check(std::string* error) const {
  return RangeChecker()
      .In("num_bins", num_bins, 8, kMaxRayBins)
      .In("num_samples", num_samples, 1, kMaxRaySamples)
      .In("num_fine_samples", num_fine_samples, 0, 1024)
      .In("cache_resolution", cache_resolution, 8, 512)
      .In("cache_interval", cache_interval, 1, 1000000)
      .In("cache_decay", cache_decay, 0.0, 0.999)
      .In("uniform_share", uniform_share, 0.0, 1.0)
      .Report(error);
}

bool LossOptions::Check(std::string* error) const {
  return RangeChecker()
      .In("color_weight", color_weight, 0.0, kAnyWeight)
      .OneOf("exposure", exposure, {"auto", "none", "affine"})
      .In("patch_weight", patch_weight, 0.0, kAnyWeight)
      .In("patch_ssim_share", patch_ssim_share, 0.0, 1.0)
      .In("patch_radius", patch_radius, 0, 3)
      .InOrFromScene("patch_dilation", patch_dilation, 1, 16)
      .OneOf("patch_sampling", patch_sampling, {"dense", "keypoints"})
      .OneOf(
          "source_selection", source_selection, {"covisibility", "neighbors"})
      .In("num_sources", num_sources, 1, 32)
      .Require(source_selection != "neighbors" || num_sources >= 2,
               "num_sources must be at least 2 if source_selection is "
               "neighbors")
      .In("num_best_sources", num_best_sources, 1, 32)
      .In("planar_weight", planar_weight, 0.0, kAnyWeight)
      .OneOf("planar_form", planar_form, {"inverse_depth", "triple_product"})
      .In("planar_min_area", planar_min_area, 4, 1 << 30)
      .In("sparse_weight", sparse_weight, 0.0, kAnyWeight)
      .OneOf("sparse_form", sparse_form, {"line_of_sight", "squared", "kl"})
      .In("sparse_deviation", sparse_deviation, 1e-4, 10.0)
      .In("sparse_fraction", sparse_fraction, 0.0, 1.0)
      .In("prior_weight", prior_weight, 0.0, kAnyWeight)
      .In("far_weight", far_weight, 0.0, kAnyWeight)
      .In("prior_fraction", prior_fraction, 0.0, 1.0)
      .In("dense_prior_weight", dense_prior_weight, 0.0, kAnyWeight)
      .Require(prior_weight == 0 || dense_prior_weight == 0,
               "prior_weight must be 0 if dense_prior_weight is not: they pull "
               "at the same rays")
      .In("match_weight", match_weight, 0.0, kAnyWeight)
      .In("match_fraction", match_fraction, 0.1, 0.9)
      .Require(
          match_weight == 0 || (prior_weight == 0 && dense_prior_weight == 0),
          "match_weight must be 0 if prior_weight or dense_prior_weight "
          "is not: they pull at the same rays")
      .Report(error);
}

bool TrainingOptions::Check(std::string* error) const {
  return RangeChecker()
      .In("num_steps", num_steps, 1, 100000000)
      .In("rays_per_step", rays_per_step, 32, 1 << 20)
      .In("max_image_size", max_image_size, 16, 1 << 15)
      .In("grid_learning_rate", grid_learning_rate, 0.0, 1e3)
      .In("network_learning_rate", network_learning_rate, 0.0, 1e3)
      .In("final_learning_rate_factor", final_learning_rate_factor, 1e-6, 1.0)
      .In("coarse_to_fine_fraction", coarse_to_fine_fraction, 0.0, 0.9)
      .In("test_every", test_every, 0, 1 << 30)
      .Require(test_every != 1, "test_every must be 0 (none) or at least 2")
      .Require(num_threads == -1 || num_threads > 0,
               "num_threads must be positive, or -1 for all cores")
      .OneOf("latent_test", latent_test, {"zero", "neighbors"})
      .Report(error);
}

bool StereoOptions::Check(std::string* error) const {
  return RangeChecker()
      .In("num_iterations", num_iterations, 0, 100)
      .In("window_radius", window_radius, 1, 10)
      .In("window_step", window_step, 1, 10)
      .Require(window_step < 1 || 2 * window_radius / window_step + 1 <= 11,
               "window_radius may be at most 5 times window_step")
      .Require(
          window_step <= 2 * window_radius,
          "window_step may be at most twice window_radius: a window of one "
          "pixel matches anything")
      .In("num_used_sources", num_used_sources, 1, 32)
      .In("num_best_sources", num_best_sources, 1, 32)
      .In("perturbation", perturbation, 0.0, 1.0)
      .Report(error);
}

bool ExtractionOptions::Check(std::string* error) const {
  return RangeChecker()
      .In("max_relative_std", max_relative_std, 0.0, 1e6)
      .In("max_relative_depth_error", max_relative_depth_error, 0.0, 1.0)
      .In("max_reprojection_error", max_reprojection_error, 0.0, 1e6)
      .In("min_num_consistent", min_num_consistent, 1, 1000)
      .In("min_triangulation_angle", min_triangulation_angle, 0.0, 180.0)
      .In("averaging_num_views", averaging_num_views, 0, 1000)
      .In("averaging_max_depth_error", averaging_max_depth_error, 0.0, 1.0)
      .Report(error);
}

bool ReconstructionOptions::Check(std::string* error) const {
  return field.Check(error) && sampling.Check(error) && loss.Check(error) &&
         training.Check(error) && stereo.Check(error) &&
         extraction.Check(error);
}

bool ReconstructionOptions::NeedsPrior() const {
  return loss.dense_prior_weight > 0 || sampling.guide_by_prior ||
         sampling.bound_by_prior;
}

bool ReconstructionOptions::MatchesViews() const {
  return stereo.num_iterations > 0;
}

bool ReconstructionOptions::AveragesDepth() const {
  return MatchesViews() && extraction.averaging_num_views > 0;
}

size_t ReconstructionOptions::NumAveragedViews(const size_t num_views) const {
  return AveragesDepth()
             ? std::min(num_views - 1,
                        static_cast<size_t>(extraction.averaging_num_views))
             : 0;
}

bool ReconstructionOptions::LearnsFromMatches() const {
  return MatchesViews() && loss.match_weight > 0;
}

bool ReconstructionOptions::CompletesPlanes() const {
  return MatchesViews() && stereo.complete_planes;
}

ReconstructionOptions QualityPreset(const std::string& quality) {
  ReconstructionOptions options;
  options.field.num_levels = kFromScene;
  options.field.log2_table_size = kFromScene;
  options.field.max_resolution = kFromScene;
  if (quality == "low") {
    options.training.num_steps = 600;
    MatchViews(1, &options);
  } else if (quality == "medium" || quality == "high" || quality == "extreme") {
    // Matching needs a field that is right in the coarse. A short training
    // without rest at its end gives that (nerf/EXPERIMENTS.md).
    options.training.final_learning_rate_factor = 0.5;
    options.training.coarse_to_fine_fraction = 0.4;
    options.training.max_image_size = quality == "extreme" ? 1600 : 640;
    options.loss.sparse_fraction = 1;
    options.loss.patch_dilation = kFromScene;
    options.sampling.num_samples = 32;
    if (quality == "medium") {
      options.training.num_steps = 800;
      MatchViews(3, &options);
    } else {
      // What extreme spends, it spends on more pixels: neither more samples nor
      // more sweeps nor more steps gain anything (nerf/EXPERIMENTS.md).
      options.training.num_steps = 1600;
      options.loss.match_weight = kMatchWeight;
      MatchViews(2, &options);
    }
  } else if (quality == "paper") {
    options.field.type = "mlp";
    options.sampling.num_samples = 64;
    options.loss.patch_weight = 0.025;
    options.loss.num_sources = 4;
    options.loss.num_best_sources = 4;
    options.loss.source_selection = "neighbors";
    options.loss.planar_weight = 0.025;
    options.loss.planar_form = "triple_product";
    options.loss.sparse_weight = 0.05;
    options.loss.sparse_form = "squared";
    options.loss.far_weight = 0;
    options.training.num_steps = 100000;
    options.training.max_image_size = 640;
    options.training.network_learning_rate = 5e-4;
    options.training.final_learning_rate_factor = 1;
    options.stereo.num_iterations = 0;
  } else {
    throw std::invalid_argument(
        "quality must be low, medium, high, extreme or paper, "
        "but is \"" +
        quality + "\"");
  }
  return options;
}

}  // namespace structnerf
