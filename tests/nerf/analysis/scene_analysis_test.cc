#include "nerf/analysis/scene_analysis.h"

#include "nerf/scene_frame.h"
#include "tests/nerf/plane_scene.h"

#include <cmath>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

// Three cameras in front of a wall.
Scene WallScene(const double distance, const int width) {
  Scene scene;
  const PinholeCamera camera = MakeCamera(width, width * 3 / 4, 0.8 * width);
  for (int v = 0; v < 3; ++v) {
    scene.views.push_back(MakeView("view", camera, {0.2 * v, 0, 0}));
  }
  for (double y = -0.4; y < 0.45; y += 0.1) {
    for (double x = -0.5; x < 0.55; x += 0.1) {
      scene.points.push_back(
          MakePoint(scene, {x * distance, y * distance, distance}, {0, 1, 2}));
    }
  }
  return scene;
}

std::string ChoiceOf(const SceneAnalysis& analysis,
                     const std::string& subject) {
  for (const SceneDecision& decision : analysis.decisions) {
    if (decision.subject == subject) {
      return decision.choice + " (" + decision.reason + ")";
    }
  }
  return "";
}

ReconstructionOptions PresetOf(const int max_image_size) {
  ReconstructionOptions options = QualityPreset("low");
  options.training.max_image_size = max_image_size;
  return options;
}

TEST(AnalyzeScene, TheFinestCellIsAsLargeAsPixels) {
  const Scene scene = WallScene(4, 640);
  const SceneAnalysis analysis = AnalyzeScene(scene, PresetOf(320));
  const double box = 1 / ComputeSceneFrame(scene).scale;
  const double pixel = 4 / (0.8 * 320);
  EXPECT_NEAR(analysis.options.field.max_resolution, box / (1.5 * pixel), 1);
}

TEST(AnalyzeScene, LargerImagesWantFinerGridsAndLargerTables) {
  const Scene scene = WallScene(4, 1280);
  const FieldOptions small = AnalyzeScene(scene, PresetOf(160)).options.field;
  const FieldOptions large = AnalyzeScene(scene, PresetOf(1280)).options.field;
  EXPECT_NEAR(large.max_resolution, 8 * small.max_resolution, 8);
  EXPECT_GT(large.num_levels, small.num_levels);
  EXPECT_GT(large.log2_table_size, small.log2_table_size);
  // But not than the photographs are.
  EXPECT_EQ(AnalyzeScene(scene, PresetOf(2560)).options.field.max_resolution,
            large.max_resolution);
}

TEST(AnalyzeScene, ImagesThatAreLoadedCountAsTheyAre) {
  Scene scene = WallScene(4, 640);
  const int small =
      AnalyzeScene(scene, PresetOf(160)).options.field.max_resolution;
  for (View& view : scene.views) {
    view.image = PlainImage(
        160, 160 * view.camera.height / view.camera.width, /*value=*/99);
  }
  EXPECT_EQ(AnalyzeScene(scene, PresetOf(640)).options.field.max_resolution,
            small);
}

TEST(AnalyzeScene, TheUnitOfTheModelMakesNoDifference) {
  const FieldOptions metres =
      AnalyzeScene(WallScene(4, 640), PresetOf(320)).options.field;
  Scene scene = WallScene(4, 640);
  for (View& view : scene.views) {
    view.cam_from_world_translation *= 1000;
  }
  for (SparsePoint& point : scene.points) {
    point.xyz *= 1000;
  }
  const FieldOptions millimetres =
      AnalyzeScene(scene, PresetOf(320)).options.field;
  EXPECT_EQ(millimetres.max_resolution, metres.max_resolution);
  EXPECT_EQ(millimetres.log2_table_size, metres.log2_table_size);
}

TEST(AnalyzeScene, GrowthBetweenLevelsIsLimited) {
  for (const int size : {32, 100, 320, 1000}) {
    SCOPED_TRACE(size);
    const FieldOptions field =
        AnalyzeScene(WallScene(4, 1280), PresetOf(size)).options.field;
    const double growth =
        static_cast<double>(field.max_resolution) / field.min_resolution;
    EXPECT_LE(growth, std::pow(4, field.num_levels - 1) * (1 + 1e-6));
    EXPECT_GT(growth, std::pow(4, field.num_levels - 2));
  }
}

TEST(AnalyzeScene, PatchesCoverAsMuchOfAllLargePhotographs) {
  ReconstructionOptions options = PresetOf(1600);
  options.loss.patch_dilation = kFromScene;
  options.training.max_image_size = 10000;
  for (const auto& [width, dilation] : {std::pair(16, 3),
                                        std::pair(640, 3),
                                        std::pair(1024, 4),
                                        std::pair(1600, 6),
                                        std::pair(9999, 16)}) {
    const SceneAnalysis analysis = AnalyzeScene(WallScene(4, width), options);
    EXPECT_EQ(analysis.options.loss.patch_dilation, dilation);
    EXPECT_THAT(ChoiceOf(analysis, "patches"),
                HasSubstr(std::to_string(dilation) + " pixels apart"));
    EXPECT_THAT(ChoiceOf(analysis, "patches"),
                HasSubstr(std::to_string(width) + " pixels along"));
  }
  options.training.max_image_size = 1080;
  EXPECT_EQ(
      AnalyzeScene(WallScene(4, 1600), options).options.loss.patch_dilation, 4);
}

TEST(AnalyzeScene, DoesWhatItIsTold) {
  ReconstructionOptions options = PresetOf(320);
  options.field.max_resolution = 100;
  options.field.num_levels = 7;
  options.field.log2_table_size = 11;
  options.loss.patch_dilation = 7;
  const SceneAnalysis analysis = AnalyzeScene(WallScene(4, 640), options);
  EXPECT_EQ(analysis.options.field.max_resolution, 100);
  EXPECT_EQ(analysis.options.field.num_levels, 7);
  EXPECT_EQ(analysis.options.field.log2_table_size, 11);
  EXPECT_EQ(ChoiceOf(analysis, "finest grid level"),
            "100 cells along the box (as told)");
  EXPECT_EQ(ChoiceOf(analysis, "grid levels"), "7 (as told)");
  EXPECT_EQ(ChoiceOf(analysis, "grid table"), "2^11 entries a level (as told)");
  EXPECT_EQ(ChoiceOf(analysis, "patches"), "taps 7 pixels apart (as told)");
}

TEST(AnalyzeScene, TwiceIsOnce) {
  const Scene scene = WallScene(4, 640);
  ReconstructionOptions options = PresetOf(320);
  options.loss.patch_dilation = kFromScene;
  const ReconstructionOptions once = AnalyzeScene(scene, options).options;
  const ReconstructionOptions twice = AnalyzeScene(scene, once).options;
  EXPECT_EQ(twice.field.max_resolution, once.field.max_resolution);
  EXPECT_EQ(twice.field.num_levels, once.field.num_levels);
  EXPECT_EQ(twice.field.log2_table_size, once.field.log2_table_size);
  EXPECT_EQ(twice.loss.patch_dilation, once.loss.patch_dilation);
}

TEST(AnalyzeScene, ExtremesStayWithinWhatIsAllowed) {
  std::string error;
  for (const double distance : {1e-3, 1e4}) {
    for (const int size : {16, 32768}) {
      const ReconstructionOptions options =
          AnalyzeScene(WallScene(distance, 8000), PresetOf(size)).options;
      EXPECT_TRUE(options.Check(&error)) << error;
      EXPECT_NE(options.field.max_resolution, kFromScene);
    }
  }
  ReconstructionOptions coarse = PresetOf(16);
  coarse.field.min_resolution = 1024;
  const ReconstructionOptions options =
      AnalyzeScene(WallScene(4, 640), coarse).options;
  EXPECT_TRUE(options.Check(&error)) << error;
  EXPECT_EQ(options.field.num_levels, 1);
}

TEST(AnalyzeScene, TellsTheNumbers) {
  Scene scene = WallScene(4, 640);
  scene.points[0].track.pop_back();
  const SceneAnalysis analysis = AnalyzeScene(scene, PresetOf(320));
  EXPECT_THAT(ChoiceOf(analysis, "scene box"),
              HasSubstr("100.0 % of the sparse points"));
  EXPECT_THAT(ChoiceOf(analysis, "finest grid level"),
              HasSubstr("a training pixel covers 1/"));
  EXPECT_THAT(ChoiceOf(analysis, "grid levels"), HasSubstr("times finer"));
  EXPECT_THAT(ChoiceOf(analysis, "grid table"),
              HasSubstr("pass through about"));
  EXPECT_THAT(ChoiceOf(analysis, "source views"), HasSubstr("2 of 2 others"));
  // All points are equally far, and rays begin at 0.3 times their depth.
  EXPECT_EQ(ChoiceOf(analysis, "samples"),
            "16 a ray (spread evenly over depths up to 3 times the nearest, "
            "they would be 8 % apart)");
  EXPECT_EQ(ChoiceOf(analysis, "view-dependent colour"), "");
  EXPECT_EQ(ChoiceOf(analysis, "planar term"), "");
}

TEST(AnalyzeScene, LooksAtColorsOnceThereArePhotographs) {
  Scene scene = WallScene(4, 640);
  for (size_t v = 0; v < scene.views.size(); ++v) {
    scene.views[v].image =
        PlainImage(40, 30, static_cast<uint8_t>(102 + 51 * (v % 2)));
  }
  ReconstructionOptions options = PresetOf(320);
  EXPECT_THAT(ChoiceOf(AnalyzeScene(scene, options), "view-dependent colour"),
              HasSubstr("on (colours in which photographs show a point differ "
                        "by 6.7 % of the range"));
  options.field.direction_degree = 0;
  EXPECT_THAT(ChoiceOf(AnalyzeScene(scene, options), "view-dependent colour"),
              HasSubstr("off ("));
}

TEST(AnalyzeScene, LooksAtSuperpixelsOnceThereAreAny) {
  Scene scene = WallScene(4, 640);
  for (View& view : scene.views) {
    view.image = PlainImage(40, 30, 99);
    view.segments.assign(1200, -1);
  }
  ReconstructionOptions options = PresetOf(320);
  EXPECT_THAT(ChoiceOf(AnalyzeScene(scene, options), "planar term"),
              HasSubstr("off (0 large superpixels"));
  std::fill_n(scene.views[1].segments.begin(), 900, 0);
  EXPECT_EQ(ChoiceOf(AnalyzeScene(scene, options), "planar term"),
            "on (1 large superpixels cover 25 % of the images)");
  options.loss.planar_weight = 0;
  EXPECT_THAT(ChoiceOf(AnalyzeScene(scene, options), "planar term"),
              HasSubstr("off (1"));
}

TEST(AnalyzeScene, TheMlpHasNoGrid) {
  const SceneAnalysis analysis =
      AnalyzeScene(WallScene(4, 640), QualityPreset("paper"));
  EXPECT_EQ(ChoiceOf(analysis, "grid table"), "");
  EXPECT_NE(ChoiceOf(analysis, "scene box"), "");
}

TEST(AnalyzeScene, RefusesScenesWithoutExtent) {
  EXPECT_THROW(AnalyzeScene(Scene(), PresetOf(320)), std::invalid_argument);
}

}  // namespace
}  // namespace structnerf
