// What the method says about scenes that are wrong, and that it takes scenes
// that are odd.

#include "nerf/methods.h"
#include "nerf/reconstructor.h"
#include "nerf/util/random.h"
#include "tests/nerf/plane_scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <stdexcept>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
namespace structnerf {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

ReconstructionOptions TinyOptions() {
  ReconstructionOptions options;
  options.field.num_levels = 2;
  options.field.log2_table_size = 12;
  options.field.max_resolution = 64;
  options.sampling.cache_resolution = 16;
  options.training.num_steps = 40;
  options.training.rays_per_step = 64;
  options.training.num_threads = 1;
  return options;
}

// Four views of a textured wall with points all over it.
Scene MakeWallScene() {
  TexturedPlane plane;
  Scene scene;
  for (int v = 0; v < 4; ++v) {
    View view = MakeView("photo" + std::to_string(v) + ".jpg",
                         MakeCamera(32, 24, 30),
                         {0.3 * v - 0.4, 0.1 * (v % 2), 0});
    plane.Photograph(32, 24, &view);
    scene.views.push_back(view);
  }
  for (int i = 0; i < 60; ++i) {
    scene.points.push_back(MakePoint(
        scene, {0.31 * (i % 10) - 1.4, 0.37 * (i / 10) - 1, 4}, {0, 1, 2, 3}));
  }
  return scene;
}

std::vector<DenseMaps> TrainAndRender(const Scene& scene,
                                      const ReconstructionOptions& options) {
  Reconstructor reconstructor(scene, options);
  Progress progress;
  reconstructor.Train(&progress);
  std::vector<DenseMaps> maps;
  for (size_t v = 0; v < scene.views.size(); ++v) {
    maps.push_back(reconstructor.RenderView(v, &progress));
  }
  return maps;
}

void ExpectFinite(const std::vector<DenseMaps>& maps) {
  for (const DenseMaps& view_maps : maps) {
    for (const std::vector<float>* values :
         {&view_maps.depth, &view_maps.normal, &view_maps.relative_std}) {
      EXPECT_TRUE(std::all_of(values->begin(),
                              values->end(),
                              [](const float f) { return std::isfinite(f); }));
    }
  }
}

void ExpectRefused(const Scene& scene,
                   const ReconstructionOptions& options,
                   const std::string& matter) {
  try {
    Reconstructor reconstructor(scene, options);
    ADD_FAILURE() << "nothing was thrown";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr(matter));
  }
}

TEST(Reconstructor, WrongScenesAndOptionsAreRefused) {
  const ReconstructionOptions options = TinyOptions();
  Scene scene = MakeWallScene();
  scene.views.resize(1);
  scene.points.clear();
  ExpectRefused(scene, options, "fewer than two registered images");
  ExpectRefused(Scene(), options, "fewer than two registered images");

  scene = MakeWallScene();
  scene.points.clear();
  ExpectRefused(scene, options, "no points");

  scene = MakeWallScene();
  scene.views[2].image.data.pop_back();
  ExpectRefused(scene, options, "photo2.jpg");

  scene = MakeWallScene();
  for (View& view : scene.views) {
    view.mask.assign(32 * 24, 0);
  }
  ExpectRefused(scene, options, "masks leave no pixel");

  ReconstructionOptions wrong = TinyOptions();
  wrong.sampling.num_samples = 0;
  ExpectRefused(MakeWallScene(), wrong, "num_samples");

  wrong = TinyOptions();
  wrong.training.test_every = 2;
  scene = MakeWallScene();
  scene.views.resize(3);
  for (SparsePoint& point : scene.points) {
    point.track.resize(3);
  }
  EXPECT_NO_THROW(Reconstructor(scene, wrong));
  scene.views.resize(2);
  for (SparsePoint& point : scene.points) {
    point.track.resize(2);
  }
  ExpectRefused(scene, wrong, "test_every");
}

TEST(Reconstructor, ViewThatDoesNotExist) {
  const Reconstructor reconstructor(MakeWallScene(), TinyOptions());
  Progress progress;
  EXPECT_THROW(reconstructor.RenderView(4, &progress), std::out_of_range);
}

TEST(Reconstructor, HealthyScenesGiveNoWarnings) {
  const Reconstructor reconstructor(MakeWallScene(), TinyOptions());
  EXPECT_THAT(reconstructor.Warnings(), IsEmpty());
  ASSERT_EQ(reconstructor.SourceViews().size(), 4u);
  for (int v = 0; v < 4; ++v) {
    EXPECT_EQ(reconstructor.SourceViews()[v].size(), 3u);
    EXPECT_THAT(reconstructor.SourceViews()[v], Not(Contains(v)));
  }
}

TEST(Reconstructor, ViewsWithoutPointsOrSourcesAreNamed) {
  Scene scene = MakeWallScene();
  // One sees no point; one looks the other way from the same place.
  for (SparsePoint& point : scene.points) {
    point.track.erase(point.track.begin() + 2);
  }
  View away =
      MakeView("away.jpg", scene.views[0].camera, {0.5, 0, 0}, {0, 0, -1});
  away.image = PlainImage(32, 24, 90);
  scene.views.push_back(away);
  Reconstructor reconstructor(scene, TinyOptions());
  EXPECT_THAT(reconstructor.Warnings(), Contains(HasSubstr("photo2.jpg")));
  EXPECT_THAT(reconstructor.Warnings(), Contains(HasSubstr("away.jpg")));
  EXPECT_THAT(reconstructor.Warnings(), Not(Contains(HasSubstr("photo1.jpg"))));
  // And they train all the same.
  ExpectFinite(TrainAndRender(scene, TinyOptions()));
}

// Images that say nothing must not break anything.
TEST(Reconstructor, PlainImagesGiveFiniteMaps) {
  for (const int value : {0, 128, 255}) {
    Scene scene = MakeWallScene();
    for (View& view : scene.views) {
      view.image = PlainImage(32, 24, static_cast<uint8_t>(value));
    }
    ReconstructionOptions options = TinyOptions();
    options.training.num_steps = 200;
    options.loss.prior_weight = 0.1;
    const auto maps = TrainAndRender(scene, options);
    ExpectFinite(maps);
    // The points alone put most of the wall in its place.
    int num_right = 0;
    for (const float depth : maps[1].depth) {
      num_right += std::abs(depth - 4) < 0.8f;
    }
    EXPECT_GT(num_right, 32 * 24 / 2) << value;
  }
}

TEST(Reconstructor, NoiseGivesFiniteMaps) {
  Scene scene = MakeWallScene();
  Random random(3);
  for (View& view : scene.views) {
    for (uint8_t& value : view.image.data) {
      value = static_cast<uint8_t>(random.NextBelow(256));
    }
  }
  ReconstructionOptions options = TinyOptions();
  ExpectFinite(TrainAndRender(scene, options));
  // As wild as options allow: nothing but an empty field comes of it.
  options.training.grid_learning_rate = 1000;
  options.training.network_learning_rate = 1000;
  try {
    TrainAndRender(scene, options);
    ADD_FAILURE() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("lower grid_learning_rate"));
  }
}

TEST(Reconstructor, CamerasInOnePlaceAreRefused) {
  Scene scene = MakeWallScene();
  for (View& view : scene.views) {
    view.cam_from_world_translation.setZero();
  }
  ExpectRefused(scene, TinyOptions(), "all cameras stand in one place");
}

TEST(Reconstructor, ImagesSmallerThanAPatchAreRefused) {
  Scene scene = MakeWallScene();
  for (View& view : scene.views) {
    view.image = PlainImage(1, 1, 90);
  }
  ReconstructionOptions options = TinyOptions();
  options.training.num_steps = 400;
  try {
    TrainAndRender(scene, options);
    ADD_FAILURE() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("raise max_image_size"));
  }
  options.loss.patch_weight = 0;
  ExpectFinite(TrainAndRender(scene, options));
}

// What acted, and what is odd about the scene, is one list.
TEST(Reconstructor, GuardsAreInTheSummary) {
  Scene scene = MakeWallScene();
  for (SparsePoint& point : scene.points) {
    point.track.pop_back();
  }
  Reconstructor reconstructor(scene, TinyOptions());
  Progress progress;
  reconstructor.Train(&progress);
  const auto& counts = reconstructor.Summary().guard_counts;
  EXPECT_EQ(counts.at("view_without_points"), 1);
  EXPECT_EQ(counts.at("non_finite_gradient"), 0);
}

TEST(Reconstructor, ExtremeOptionsGiveFiniteMaps) {
  const Scene scene = MakeWallScene();
  const auto expect_finite =
      [&](const std::function<void(ReconstructionOptions*)>& change) {
        ReconstructionOptions options = TinyOptions();
        options.training.num_steps = 10;
        change(&options);
        ExpectFinite(TrainAndRender(scene, options));
      };
  expect_finite([](ReconstructionOptions* o) { o->field.num_levels = 1; });
  expect_finite([](ReconstructionOptions* o) {
    o->field.num_levels = 16;
    o->field.log2_table_size = 10;
    o->field.hidden_width = 64;
    o->field.max_resolution = 65536;
  });
  expect_finite([](ReconstructionOptions* o) { o->sampling.num_samples = 1; });
  expect_finite([](ReconstructionOptions* o) {
    o->sampling.num_samples = 64;
    o->sampling.num_bins = 8;
  });
  expect_finite([](ReconstructionOptions* o) {
    o->sampling.num_bins = 256;
    o->sampling.uniform_share = 0;
    o->sampling.cache_resolution = 8;
    o->sampling.cache_interval = 1;
  });
  expect_finite([](ReconstructionOptions* o) {
    o->loss.patch_radius = 3;
    o->loss.patch_dilation = 16;  // wider than the image
    o->loss.num_sources = 32;
    o->loss.num_best_sources = 32;
  });
  expect_finite([](ReconstructionOptions* o) { o->training.num_steps = 1; });
  expect_finite([](ReconstructionOptions* o) {
    o->loss.color_weight = 0;
    o->loss.patch_weight = 0;
    o->loss.sparse_weight = 0;
    o->loss.prior_weight = 0;
  });
}

bool AreEqual(const std::vector<DenseMaps>& a,
              const std::vector<DenseMaps>& b) {
  for (size_t v = 0; v < a.size(); ++v) {
    if (std::memcmp(a[v].depth.data(),
                    b[v].depth.data(),
                    a[v].depth.size() * sizeof(float)) != 0) {
      return false;
    }
  }
  return true;
}

// Whatever is under a mask, training does not see it.
TEST(Reconstructor, MaskedPixelsHaveNoInfluence) {
  Scene scene = MakeWallScene();
  for (View& view : scene.views) {
    view.mask.assign(32 * 24, 255);
    for (int row = 4; row < 15; ++row) {
      std::fill_n(view.mask.begin() + row * 32 + 8, 12, 0);
    }
    view.segments.assign(32 * 24, 1);
  }
  const auto expected = TrainAndRender(scene, TinyOptions());
  for (View& view : scene.views) {
    for (size_t i = 0; i < view.mask.size(); ++i) {
      if (view.mask[i] == 0) {
        view.image.data[3 * i] ^= 0xff;
        view.image.data[3 * i + 1] ^= 0x55;
      }
    }
  }
  EXPECT_TRUE(AreEqual(TrainAndRender(scene, TinyOptions()), expected));
  // The test can tell: next to the mask it does matter.
  scene.views[0].image.data[3 * (20 * 32 + 5)] ^= 0xff;
  EXPECT_FALSE(AreEqual(TrainAndRender(scene, TinyOptions()), expected));
}

// A view that is held out neither is drawn, nor guides or confirms the others.
TEST(Reconstructor, HeldOutPhotographsHaveNoInfluence) {
  ReconstructionOptions options = TinyOptions();
  options.training.test_every = 3;
  Scene scene = MakeWallScene();
  auto expected = TrainAndRender(scene, options);
  for (uint8_t& value : scene.views[2].image.data) {
    value ^= 0xff;
  }
  auto maps = TrainAndRender(scene, options);
  // Once trained, its own depth is matched with it.
  EXPECT_NE(maps[2].depth, expected[2].depth);
  maps.erase(maps.begin() + 2);
  expected.erase(expected.begin() + 2);
  EXPECT_TRUE(AreEqual(maps, expected));
  scene.views[1].image.data[500] ^= 0xff;
  EXPECT_FALSE(AreEqual(TrainAndRender(scene, options), expected));
}

// Priors that are 4 units, the wall's depth, for the first views.
Scene SceneWithPriors(const int num_views) {
  Scene scene = MakeWallScene();
  for (int v = 0; v < num_views; ++v) {
    scene.views[v].prior_depth.assign(32 * 24, 4);
  }
  return scene;
}

TEST(Reconstructor, MethodsWithPriorsFollowThem) {
  for (const char* const method : {"dense_depth_prior", "nerfing_mvs"}) {
    SCOPED_TRACE(method);
    ReconstructionOptions options = ApplyMethod(method, TinyOptions());
    options.training.num_steps = 150;
    options.loss.dense_prior_weight *= 10;
    const auto error_of = [](const std::vector<DenseMaps>& maps) {
      double sum = 0;
      for (const float depth : maps[1].depth) {
        sum += std::abs(depth - 4) / static_cast<double>(maps[1].depth.size());
      }
      return sum;
    };
    const double error = error_of(TrainAndRender(SceneWithPriors(4), options));
    const double error_of_color = error_of(
        TrainAndRender(MakeWallScene(), ApplyMethod("nerf", TinyOptions())));
    EXPECT_LT(error, 0.3);
    EXPECT_LT(error, 0.7 * error_of_color);
  }
}

TEST(Reconstructor, MissingPriorsAreCounted) {
  ReconstructionOptions options = ApplyMethod("nerfing_mvs", TinyOptions());
  options.training.num_steps = 3;
  Reconstructor reconstructor(SceneWithPriors(3), options);
  Progress progress;
  reconstructor.Train(&progress);
  const auto& counts = reconstructor.Summary().guard_counts;
  EXPECT_EQ(counts.at("view_without_prior"), 1);
  EXPECT_EQ(counts.at("prior_behind_camera"), 0);
  // The rim of the wall, which has no points, is outside of the scene box.
  EXPECT_GT(counts.at("inverted_ray_bounds"), 0);
  EXPECT_LT(counts.at("inverted_ray_bounds"), 3 * 32 * 24 / 4);
  ExpectRefused(MakeWallScene(), options, "no image has a depth prior");
  // That of a held-out view is not looked at.
  options.training.test_every = 4;
  Reconstructor without_last(SceneWithPriors(4), options);
  without_last.Train(&progress);
  EXPECT_EQ(without_last.Summary().guard_counts.at("view_without_prior"), 0);
}

}  // namespace
}  // namespace structnerf
