#include "colmap_plugin/run_identity.h"

#include "colmap_plugin/input_check.h"
#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/temp_dir.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

TEST(RunIdentity, HasEveryOptionThatMatters) {
  StructNerfOptions options;
  const auto run = DescribeRun(options);
  EXPECT_EQ(run.at("--StructNeRF.num_steps"), "1500");
  EXPECT_EQ(run.at("--StructNeRF.grid_learning_rate"), "0.02");
  EXPECT_EQ(run.count("version"), 1u);
  const auto expect_other = [&](const std::function<void()>& change) {
    const StructNerfOptions before = options;
    change();
    EXPECT_NE(DescribeRun(options), run);
    options = before;
  };
  expect_other([&]() { options.device = "cuda"; });
  expect_other([&]() { options.reconstruction.training.seed = 1; });
  expect_other(
      [&]() { options.reconstruction.loss.patch_weight *= 1 + 1e-15; });
  expect_other([&]() { options.reconstruction.stereo.num_iterations = 1; });
  expect_other(
      [&]() { options.reconstruction.extraction.max_relative_std = 1; });
}

TEST(RunIdentity, WhatDoesNotChangeTheMapsMayChange) {
  StructNerfOptions options;
  const auto run = DescribeRun(options);
  options.reconstruction.training.num_threads = 7;
  options.max_memory_gb = 100;
  options.input_type = "photometric";
  options.checkpoint_minutes = 1;
  EXPECT_EQ(DescribeRun(options), run);
}

TEST(InputFingerprint, ChangesWithTheInput) {
  const TempDir folder;
  TinyModel model = MakeTinyModel(3);
  model.WriteImages(folder / "images");
  model.WriteImages(folder / "masks");
  fs::rename(folder / "masks/1.png", folder / "masks/1.png.png");
  const auto fingerprint = [&](const std::string& mask_path = "") {
    model.WriteModel(folder / "sparse");
    return InputFingerprint(
        ReadModel(folder / "sparse"), folder / "images", mask_path);
  };
  const std::string expected = fingerprint();
  EXPECT_EQ(fingerprint(), expected);
  const TinyModel before = model;
  const auto expect_other = [&](const std::function<void()>& change) {
    change();
    EXPECT_NE(fingerprint(), expected);
    model = before;
  };
  expect_other([&]() { model.images[1].x += 0.01; });
  expect_other([&]() { model.cameras[0].params[0] += 0.01; });
  expect_other([&]() { model.points[3].z() += 0.01; });
  expect_other([&]() { model.images.pop_back(); });
  expect_other([&]() { model.points.pop_back(); });
  EXPECT_EQ(fingerprint(), expected);

  const std::string with_masks = fingerprint(folder / "masks");
  EXPECT_NE(with_masks, expected);
  fs::remove(folder / "masks/1.png.png");
  EXPECT_NE(fingerprint(folder / "masks"), with_masks);
  const std::string image = folder / "images/1.png";
  fs::last_write_time(image,
                      fs::last_write_time(image) + std::chrono::seconds(1));
  EXPECT_NE(fingerprint(), expected);
}

}  // namespace
}  // namespace structnerf
