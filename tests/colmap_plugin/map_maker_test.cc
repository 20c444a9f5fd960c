#include "colmap_plugin/map_maker.h"

#include "colmap_plugin/input_check.h"
#include "colmap_plugin/scene_converter.h"
#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/temp_dir.h"

#include <chrono>
#include <filesystem>
#include <memory>
#include <utility>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

class MapMakerTest : public testing::Test {
 protected:
  MapMakerTest() : workspace_(temp_dir_ / "dense") {
    const TinyModel model = MakeTinyModel(3);
    model.WriteModel(temp_dir_ / "sparse");
    model.WriteImages(temp_dir_ / "images");
    SceneConverterOptions converter_options;
    converter_options.image_path = temp_dir_ / "images";
    Scene scene = ConvertScene(
        ReadModel(temp_dir_ / "sparse"), converter_options, &silent_);
    for (const View& view : scene.views) {
      scene_.views.push_back(PoseOf(view));
      options_.image_names.push_back(view.name);
    }
    workspace_.CreateFolders(options_.image_names);
    journal_ = std::make_unique<FileJournal>(
        temp_dir_ / "journal", workspace_.Path(), "key");

    ReconstructionOptions method = QualityPreset("low");
    method.field.num_levels = 2;
    method.field.max_resolution = 64;
    method.field.log2_table_size = 10;
    method.sampling.cache_resolution = 16;
    method.training.num_steps = 50;
    method.training.rays_per_step = 64;
    method.extraction.max_relative_std = 100;
    method.stereo.num_iterations = 0;
    reconstructor_ = std::make_unique<Reconstructor>(scene, method);
    reconstructor_->Train(&silent_);
    method.stereo.num_iterations = 2;
    matching_reconstructor_ =
        std::make_unique<Reconstructor>(std::move(scene), method);
    matching_reconstructor_->Train(&silent_);
    options_.max_bytes = size_t{1} << 20;
  }

  MapMaker Maker() {
    return MapMaker(options_, &scene_, &workspace_, journal_.get());
  }

  const TempDir temp_dir_;
  const DenseWorkspace workspace_;
  Progress silent_;
  StageProgress stage_{"Test", &silent_};
  Scene scene_;
  std::unique_ptr<FileJournal> journal_;
  std::unique_ptr<Reconstructor> reconstructor_;           // without matching
  std::unique_ptr<Reconstructor> matching_reconstructor_;  // of the same field
  MapMakerOptions options_;
};

TEST_F(MapMakerTest, WholeMapsOfTheSameFieldAreNotRenderedAgain) {
  Maker().RenderMaps(reconstructor_.get(), &stage_);
  const std::string path =
      workspace_.InterimMapsPath("1.png", InterimStage::kMatched);
  const auto time = fs::last_write_time(path) - std::chrono::hours(1);
  fs::last_write_time(path, time);

  options_.reuses_maps = true;
  Maker().RenderMaps(reconstructor_.get(), &stage_);
  EXPECT_EQ(fs::last_write_time(path), time);

  options_.reuses_maps = false;
  Maker().RenderMaps(reconstructor_.get(), &stage_);
  EXPECT_GT(fs::last_write_time(path), time);
}

TEST_F(MapMakerTest, WhatIsMaskedHasNoDepth) {
  options_.mask_path = temp_dir_ / "masks";
  fs::create_directory(options_.mask_path);
  cv::imwrite(options_.mask_path + "/1.png.png",
              cv::Mat(48, 64, CV_8U, cv::Scalar(0)));
  MapMaker maker = Maker();
  maker.RenderMaps(reconstructor_.get(), &stage_);
  EXPECT_EQ(maker.CompletePlanes(reconstructor_.get(), &stage_), 0u)
      << "depth was not matched";
  maker.CheckConsistency(reconstructor_->SourceViews(), &stage_);

  ASSERT_EQ(maker.Views().size(), 3u);
  EXPECT_GT(maker.Views()[0].num_photometric, 0u);
  EXPECT_EQ(maker.Views()[1].num_photometric, 0u);
  for (size_t i = 0; i < 3; ++i) {
    const ViewReport& view = maker.Views()[i];
    EXPECT_EQ(view.name, options_.image_names[i]);
    EXPECT_LE(view.num_geometric, view.num_photometric);
    EXPECT_EQ(workspace_.ReadMaps(view.name, MapType::kPhotometric).NumDepths(),
              view.num_photometric);
    EXPECT_EQ(workspace_.ReadMaps(view.name, MapType::kGeometric).NumDepths(),
              view.num_geometric);
    EXPECT_TRUE(fs::exists(workspace_.ConsistencyGraphPath(view.name)));
    EXPECT_EQ(workspace_.ReadConfidence(view.name).values.size(), 64u * 48);
  }
}

TEST_F(MapMakerTest, WhereDepthIsAveragedItLeavesToThatWhatConfirmsIt) {
  options_.averages_depth = true;
  MapMaker maker = Maker();
  maker.RenderMaps(reconstructor_.get(), &stage_);
  maker.CompletePlanes(reconstructor_.get(), &stage_);
  maker.CheckConsistency(reconstructor_->SourceViews(), &stage_);
  EXPECT_TRUE(
      fs::exists(workspace_.DepthMapPath("1.png", MapType::kGeometric)));
  EXPECT_FALSE(fs::exists(workspace_.ConsistencyGraphPath("1.png")));
  EXPECT_FALSE(fs::exists(workspace_.ConfidencePath("1.png")));
}

TEST_F(MapMakerTest, WhatNoViewConfirmsHasTheDepthOfTheField) {
  options_.matches_views = true;
  MapMaker maker = Maker();
  maker.RenderMaps(matching_reconstructor_.get(), &stage_);
  maker.CompletePlanes(matching_reconstructor_.get(), &stage_);
  maker.CheckConsistency(matching_reconstructor_->SourceViews(), &stage_);

  size_t num_confirmed = 0;
  size_t num_replaced = 0;
  for (size_t i = 0; i < 3; ++i) {
    const std::string& name = options_.image_names[i];
    const StereoMaps photometric =
        workspace_.ReadMaps(name, MapType::kPhotometric);
    const StereoMaps geometric = workspace_.ReadMaps(name, MapType::kGeometric);
    const DenseMaps completed =
        workspace_.ReadInterimMaps(name, InterimStage::kCompleted);
    const DenseMaps field = reconstructor_->RenderView(i, &silent_);
    for (size_t pixel = 0; pixel < field.depth.size(); ++pixel) {
      const bool is_confirmed = geometric.depth[pixel] > 0;
      num_confirmed += is_confirmed;
      num_replaced +=
          !is_confirmed && completed.depth[pixel] != field.depth[pixel];
      EXPECT_EQ(photometric.depth[pixel],
                is_confirmed ? completed.depth[pixel] : field.depth[pixel]);
    }
  }
  EXPECT_GT(num_confirmed, 0u);
  EXPECT_GT(num_replaced, 0u);
}

}  // namespace
}  // namespace structnerf
