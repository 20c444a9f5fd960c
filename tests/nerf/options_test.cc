#include "nerf/options.h"

#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// One value of one field.
struct Setting {
  std::string name;
  std::function<void(ReconstructionOptions*)> apply;
  std::string value;
};

#define SETTING(group, field, value)                                          \
  Setting {                                                                   \
#field, [](ReconstructionOptions * o) { o->group.field = value; }, #value \
  }

// Values at or just inside every limit.
std::vector<Setting> AllowedSettings() {
  return {
      SETTING(field, type, "mlp"),
      SETTING(field, mlp_num_layers, 1),
      SETTING(field, mlp_num_layers, 32),
      SETTING(field, mlp_width, 2),
      SETTING(field, mlp_width, 1024),
      SETTING(field, num_levels, 1),
      SETTING(field, num_levels, 16),
      SETTING(field, log2_table_size, 10),
      SETTING(field, log2_table_size, 24),
      SETTING(field, min_resolution, 2),
      SETTING(field, max_resolution, 65536),
      SETTING(field, hidden_width, 16),
      SETTING(field, hidden_width, 48),
      SETTING(field, hidden_width, 64),
      SETTING(field, direction_degree, 0),
      SETTING(sampling, num_bins, 8),
      SETTING(sampling, num_bins, 256),
      SETTING(sampling, num_samples, 1),
      SETTING(sampling, num_samples, 64),
      SETTING(sampling, num_fine_samples, 0),
      SETTING(sampling, num_fine_samples, 1024),
      SETTING(sampling, cache_resolution, 8),
      SETTING(sampling, cache_resolution, 512),
      SETTING(sampling, cache_interval, 1),
      SETTING(sampling, cache_decay, 0.0),
      SETTING(sampling, cache_decay, 0.999),
      SETTING(sampling, uniform_share, 0.0),
      SETTING(sampling, uniform_share, 1.0),
      SETTING(loss, color_weight, 0.0),
      SETTING(loss, exposure, "auto"),
      SETTING(loss, exposure, "affine"),
      SETTING(loss, patch_weight, 0.0),
      SETTING(loss, patch_ssim_share, 0.0),
      SETTING(loss, patch_ssim_share, 1.0),
      SETTING(loss, patch_radius, 0),
      SETTING(loss, patch_radius, 3),
      SETTING(loss, patch_dilation, kFromScene),
      SETTING(loss, patch_dilation, 1),
      SETTING(loss, patch_dilation, 16),
      SETTING(loss, patch_sampling, "keypoints"),
      SETTING(loss, source_selection, "neighbors"),
      SETTING(loss, num_sources, 1),
      SETTING(loss, num_sources, 32),
      SETTING(loss, num_best_sources, 1),
      SETTING(loss, num_best_sources, 32),
      SETTING(loss, planar_weight, 0.0),
      SETTING(loss, planar_form, "triple_product"),
      SETTING(loss, planar_min_area, 4),
      SETTING(loss, sparse_weight, 0.0),
      SETTING(loss, sparse_form, "squared"),
      SETTING(loss, sparse_form, "kl"),
      SETTING(loss, sparse_deviation, 1e-4),
      SETTING(loss, sparse_fraction, 0.0),
      SETTING(loss, sparse_fraction, 1.0),
      SETTING(loss, prior_weight, 0.0),
      SETTING(loss, prior_fraction, 0.0),
      SETTING(loss, prior_fraction, 1.0),
      SETTING(loss, dense_prior_weight, 1e6),
      SETTING(loss, match_weight, 1e6),
      SETTING(loss, match_fraction, 0.9),
      SETTING(training, num_steps, 1),
      SETTING(training, rays_per_step, 32),
      SETTING(training, max_image_size, 16),
      SETTING(training, grid_learning_rate, 0.0),
      SETTING(training, network_learning_rate, 0.0),
      SETTING(training, final_learning_rate_factor, 1.0),
      SETTING(training, coarse_to_fine_fraction, 0.0),
      SETTING(training, coarse_to_fine_fraction, 0.9),
      SETTING(training, test_every, 0),
      SETTING(training, test_every, 2),
      SETTING(training, latent_test, "neighbors"),
      SETTING(training, num_threads, -1),
      SETTING(training, num_threads, 1),
      SETTING(training, seed, -1),
      SETTING(stereo, num_iterations, 0),
      SETTING(stereo, num_iterations, 100),
      SETTING(stereo, window_radius, 1),
      SETTING(stereo, window_radius, 10),
      SETTING(stereo, window_step, 10),
      SETTING(stereo, num_used_sources, 1),
      SETTING(stereo, num_used_sources, 32),
      SETTING(stereo, num_best_sources, 32),
      SETTING(stereo, perturbation, 0.0),
      SETTING(extraction, max_relative_std, 0.0),
      SETTING(extraction, max_relative_depth_error, 0.0),
      SETTING(extraction, max_relative_depth_error, 1.0),
      SETTING(extraction, max_reprojection_error, 0.0),
      SETTING(extraction, min_num_consistent, 1),
      SETTING(extraction, min_triangulation_angle, 0.0),
      SETTING(extraction, averaging_num_views, 0),
      SETTING(extraction, averaging_num_views, 1000),
      SETTING(extraction, averaging_max_depth_error, 0.0),
      SETTING(extraction, averaging_max_depth_error, 1.0),
  };
}

// Values just outside every limit.
std::vector<Setting> ForbiddenSettings() {
  return {
      SETTING(field, mlp_num_layers, 0),
      SETTING(field, mlp_num_layers, 33),
      SETTING(field, mlp_width, 0),
      SETTING(field, mlp_width, 255),
      SETTING(field, mlp_width, 1026),
      SETTING(field, latent_size, -1),
      SETTING(field, latent_size, 48),  // a grid has none
      SETTING(field, num_levels, 0),
      SETTING(field, num_levels, 17),
      SETTING(field, log2_table_size, 9),
      SETTING(field, log2_table_size, 25),
      SETTING(field, min_resolution, 1),
      SETTING(field, max_resolution, 15),  // below min_resolution
      SETTING(field, max_resolution, 65537),
      SETTING(field, hidden_width, 0),
      SETTING(field, hidden_width, 24),
      SETTING(field, hidden_width, 80),
      SETTING(field, direction_degree, -1),
      SETTING(field, direction_degree, 3),
      SETTING(sampling, num_bins, 7),
      SETTING(sampling, num_bins, 257),
      SETTING(sampling, num_samples, 0),
      SETTING(sampling, num_samples, 65),
      SETTING(sampling, num_fine_samples, -1),
      SETTING(sampling, num_fine_samples, 1025),
      SETTING(sampling, cache_resolution, 7),
      SETTING(sampling, cache_resolution, 513),
      SETTING(sampling, cache_interval, 0),
      SETTING(sampling, cache_decay, -0.1),
      SETTING(sampling, cache_decay, 1.0),
      SETTING(sampling, cache_decay, kNan),
      SETTING(sampling, uniform_share, -0.1),
      SETTING(sampling, uniform_share, 1.1),
      SETTING(sampling, uniform_share, kNan),
      SETTING(loss, color_weight, -1e-9),
      SETTING(loss, exposure, "linear"),
      SETTING(loss, color_weight, kInfinity),
      SETTING(loss, patch_weight, kNan),
      SETTING(loss, patch_ssim_share, 1.01),
      SETTING(loss, patch_radius, -1),
      SETTING(loss, patch_radius, 4),
      SETTING(loss, patch_dilation, 0),
      SETTING(loss, patch_dilation, 17),
      SETTING(loss, patch_sampling, "sparse"),
      SETTING(loss, source_selection, ""),
      SETTING(loss, num_sources, 0),
      SETTING(loss, num_sources, 33),
      SETTING(loss, num_best_sources, 0),
      SETTING(loss, num_best_sources, 33),
      SETTING(loss, planar_weight, -1.0),
      SETTING(loss, planar_form, "Triple_product"),
      SETTING(loss, planar_min_area, 3),
      SETTING(loss, sparse_weight, -1.0),
      SETTING(loss, sparse_form, "quadratic"),
      SETTING(loss, sparse_deviation, 0.0),
      SETTING(loss, sparse_deviation, kNan),
      SETTING(loss, sparse_fraction, 1.1),
      SETTING(loss, sparse_fraction, kNan),
      SETTING(loss, prior_weight, -1.0),
      SETTING(loss, prior_fraction, -0.1),
      SETTING(loss, dense_prior_weight, -1.0),
      SETTING(loss, match_weight, -1.0),
      SETTING(loss, match_fraction, 0.05),
      SETTING(training, num_steps, 0),
      SETTING(training, rays_per_step, 31),
      SETTING(training, rays_per_step, (1 << 20) + 1),
      SETTING(training, max_image_size, 15),
      SETTING(training, grid_learning_rate, -1e-3),
      SETTING(training, grid_learning_rate, kNan),
      SETTING(training, network_learning_rate, kInfinity),
      SETTING(training, final_learning_rate_factor, 0.0),
      SETTING(training, final_learning_rate_factor, 1.5),
      SETTING(training, coarse_to_fine_fraction, -0.1),
      SETTING(training, coarse_to_fine_fraction, 0.95),
      SETTING(training, test_every, -1),
      SETTING(training, test_every, 1),
      SETTING(training, latent_test, "mean"),
      SETTING(training, num_threads, 0),
      SETTING(training, num_threads, -2),
      SETTING(stereo, num_iterations, -1),
      SETTING(stereo, num_iterations, 101),
      SETTING(stereo, window_radius, 0),
      SETTING(stereo, window_radius, 11),
      SETTING(stereo, window_step, 0),
      SETTING(stereo, window_step, 11),
      SETTING(stereo, num_used_sources, 0),
      SETTING(stereo, num_best_sources, 33),
      SETTING(stereo, perturbation, kNan),
      SETTING(extraction, max_relative_std, -0.1),
      SETTING(extraction, max_relative_std, kNan),
      SETTING(extraction, max_relative_depth_error, 1.1),
      SETTING(extraction, max_reprojection_error, -1.0),
      SETTING(extraction, min_num_consistent, 0),
      SETTING(extraction, min_triangulation_angle, -1.0),
      SETTING(extraction, averaging_num_views, -1),
      SETTING(extraction, averaging_num_views, 1001),
      SETTING(extraction, averaging_max_depth_error, -0.01),
      SETTING(extraction, averaging_max_depth_error, 1.01),
  };
}

#undef SETTING

TEST(ReconstructionOptions, DefaultsAreAllowed) {
  std::string error = "untouched";
  EXPECT_TRUE(ReconstructionOptions().Check(&error));
  EXPECT_EQ(error, "untouched");
}

TEST(ReconstructionOptions, LimitsAreAllowed) {
  for (const Setting& setting : AllowedSettings()) {
    SCOPED_TRACE(setting.name + " = " + setting.value);
    ReconstructionOptions options;
    setting.apply(&options);
    std::string error;
    EXPECT_TRUE(options.Check(&error)) << error;
  }
}

TEST(ReconstructionOptions, ValuesOutsideAreNamed) {
  for (const Setting& setting : ForbiddenSettings()) {
    SCOPED_TRACE(setting.name + " = " + setting.value);
    ReconstructionOptions options;
    setting.apply(&options);
    std::string error;
    EXPECT_FALSE(options.Check(&error));
    EXPECT_THAT(error, HasSubstr(setting.name));
    // Asking again changes nothing.
    std::string again;
    EXPECT_FALSE(options.Check(&again));
    EXPECT_EQ(again, error);
  }
}

TEST(ReconstructionOptions, WindowsOfTooManyTapsAreRefused) {
  ReconstructionOptions options;
  std::string error;
  options.stereo.window_step = 1;
  options.stereo.window_radius = 5;
  EXPECT_TRUE(options.Check(&error)) << error;
  options.stereo.window_radius = 6;
  EXPECT_FALSE(options.Check(&error));
  EXPECT_THAT(error, HasSubstr("window_radius"));
}

TEST(ReconstructionOptions, WindowsOfOneTapAreRefused) {
  ReconstructionOptions options;
  std::string error;
  options.stereo.window_radius = 2;
  options.stereo.window_step = 4;
  EXPECT_TRUE(options.Check(&error)) << error;
  options.stereo.window_step = 5;
  EXPECT_FALSE(options.Check(&error));
  EXPECT_THAT(error, HasSubstr("window_step"));
}

TEST(ReconstructionOptions, OnePriorPullsAtARay) {
  ReconstructionOptions options;
  options.loss.prior_weight = 0.1;
  options.loss.dense_prior_weight = 0.1;
  std::string error;
  EXPECT_FALSE(options.Check(&error));
  EXPECT_THAT(error, HasSubstr("dense_prior_weight"));
}

TEST(ReconstructionOptions, FieldsAreNamedAsOnTheCommandLine) {
  ReconstructionOptions options;
  options.field.type = "nerf";
  std::string error;
  EXPECT_FALSE(options.Check(&error));
  EXPECT_EQ(error, "field must be grid or mlp, but is \"nerf\"");
}

TEST(ReconstructionOptions, NeighborsAreOnBothSides) {
  ReconstructionOptions options;
  std::string error;
  options.loss.source_selection = "neighbors";
  options.loss.num_sources = 1;
  EXPECT_FALSE(options.Check(&error));
  EXPECT_THAT(error, HasSubstr("num_sources"));
}

TEST(ReconstructionOptions, AllowedWordsAreInTheMessage) {
  ReconstructionOptions options;
  options.loss.sparse_form = "huber";
  std::string error;
  EXPECT_FALSE(options.Check(&error));
  EXPECT_EQ(error,
            "sparse_form must be line_of_sight, squared or kl, but is "
            "\"huber\"");
}

TEST(ReconstructionOptions, RangeAndValueAreInTheMessage) {
  ReconstructionOptions options;
  options.sampling.num_samples = 99;
  std::string error;
  EXPECT_FALSE(options.Check(&error));
  EXPECT_THAT(error, HasSubstr("between 1 and 64"));
  EXPECT_THAT(error, HasSubstr("99"));
}

// Extreme is high with larger images.
TEST(QualityPreset, WordsGiveEverMoreWork) {
  int last_num_samples = 0;
  int last_image_size = 0;
  for (const char* const quality : {"low", "medium", "high", "extreme"}) {
    SCOPED_TRACE(quality);
    const ReconstructionOptions options = QualityPreset(quality);
    std::string error;
    EXPECT_TRUE(options.Check(&error)) << error;
    const int num_samples =
        options.training.num_steps * options.sampling.num_samples;
    EXPECT_GE(num_samples, last_num_samples);
    EXPECT_GE(options.training.max_image_size, last_image_size);
    EXPECT_TRUE(num_samples > last_num_samples ||
                options.training.max_image_size > last_image_size);
    last_num_samples = num_samples;
    last_image_size = options.training.max_image_size;
  }
}

TEST(QualityPreset, PaperIsThePaper) {
  const ReconstructionOptions options = QualityPreset("paper");
  std::string error;
  EXPECT_TRUE(options.Check(&error)) << error;
  EXPECT_EQ(options.field.type, "mlp");
  EXPECT_EQ(options.field.mlp_num_layers, 8);
  EXPECT_EQ(options.field.mlp_width, 256);
  EXPECT_EQ(options.sampling.num_samples, 64);
  EXPECT_EQ(options.sampling.num_fine_samples, 128);
  EXPECT_EQ(options.loss.color_weight, 1);
  EXPECT_EQ(options.loss.patch_weight, 0.025);
  EXPECT_EQ(options.loss.patch_ssim_share, 0.85);
  EXPECT_EQ(options.loss.patch_radius, 1);
  EXPECT_EQ(options.loss.patch_dilation, 2);
  EXPECT_EQ(options.loss.source_selection, "neighbors");
  EXPECT_EQ(options.loss.num_sources, 4);
  EXPECT_EQ(options.loss.num_best_sources, 4);
  EXPECT_EQ(options.loss.planar_weight, 0.025);
  EXPECT_EQ(options.loss.planar_form, "triple_product");
  EXPECT_EQ(options.loss.planar_min_area, 1000);
  EXPECT_EQ(options.loss.sparse_weight, 0.05);
  EXPECT_EQ(options.loss.sparse_form, "squared");
  EXPECT_EQ(options.loss.sparse_fraction, 0.5);
  EXPECT_EQ(options.loss.prior_weight, 0);
  EXPECT_EQ(options.training.num_steps, 100000);
  EXPECT_EQ(options.training.rays_per_step, 1024);
  EXPECT_EQ(options.training.network_learning_rate, 5e-4);
  EXPECT_EQ(options.training.final_learning_rate_factor, 1);
  EXPECT_EQ(options.stereo.num_iterations, 0);
}

TEST(QualityPreset, OtherWordsAreRefusedWithAList) {
  for (const char* const quality : {"", "Medium", "ultra"}) {
    try {
      QualityPreset(quality);
      FAIL() << quality;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(),
                  HasSubstr("low, medium, high, extreme or paper"));
      EXPECT_THAT(error.what(), HasSubstr("\"" + std::string(quality) + "\""));
    }
  }
}

}  // namespace
}  // namespace structnerf
