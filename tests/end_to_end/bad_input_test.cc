// Bad input gets one clear line, a failing exit code, and leaves the disk as it
// was.

#include "tests/colmap_plugin/tiny_model.h"
#include "tests/end_to_end/run_program.h"
#include "tests/support/temp_dir.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;
using testing::StartsWith;

class BadInputTest : public testing::Test {
 protected:
  BadInputTest() : model_(MakeTinyModel(3)) {
    options_.arguments = {"structnerf_dense",
                          "--image_path",
                          temp_dir_ / "images",
                          "--input_path",
                          temp_dir_ / "sparse/0",
                          "--output_path",
                          temp_dir_ / "dense",
                          "--StructNeRF.num_steps=5"};
    model_.WriteImages(temp_dir_ / "images");
    model_.WriteModel(temp_dir_ / "sparse/0");
  }

  // Fails unless the run ends with one line of error that contains the text.
  void ExpectError(const std::string& text) {
    const auto before = ReadFolder(temp_dir_.Path());
    const ProgramResult result = RunProgram(options_);
    EXPECT_EQ(result.exit_code, EXIT_FAILURE);
    EXPECT_THAT(result.error, HasSubstr(text));
    EXPECT_EQ(ReadFolder(temp_dir_.Path()), before);
    // Stages may have been announced before it.
    const size_t start = result.error.rfind('\n', result.error.size() - 2);
    const std::string last_line =
        result.error.substr(start == std::string::npos ? 0 : start + 1);
    EXPECT_THAT(last_line, HasSubstr(text));
    EXPECT_EQ(result.error.find("ERROR"), result.error.rfind("ERROR"));
  }

  void Add(const std::vector<std::string>& arguments) {
    options_.arguments.insert(
        options_.arguments.end(), arguments.begin(), arguments.end());
  }

  // Takes an option and its value away.
  void Remove(const std::string& option) {
    const auto it =
        std::find(options_.arguments.begin(), options_.arguments.end(), option);
    options_.arguments.erase(it, it + 2);
  }

  TempDir temp_dir_;
  TinyModel model_;
  ProgramOptions options_;
};

TEST_F(BadInputTest, MissingImage) {
  fs::remove(temp_dir_ / "images/1.png");
  ExpectError(temp_dir_ / "images/1.png");
}

TEST_F(BadInputTest, UnreadableImage) {
  std::ofstream(temp_dir_ / "images/1.png") << "no image";
  ExpectError(temp_dir_ / "images/1.png");
}

TEST_F(BadInputTest, CutOffImage) {
  for (const bool is_distorted : {false, true}) {
    if (is_distorted) {
      model_.cameras[0] = {"SIMPLE_RADIAL", 64, 48, {60, 32, 24, 0.1}};
    }
    model_.images[1].name = "1.jpg";
    model_.WriteModel(temp_dir_ / "sparse/0");
    model_.WriteImages(temp_dir_ / "images");
    fs::resize_file(temp_dir_ / "images/1.jpg",
                    fs::file_size(temp_dir_ / "images/1.jpg") / 2);
    ExpectError("images/1.jpg is cut off");
  }
}

// Overwrites bytes in the middle of a file.
void Damage(const std::string& path) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(fs::file_size(path) / 2));
  file << std::string(64, '\0');
}

TEST_F(BadInputTest, DamagedImage) {
  // Both ends are fine, so this is only found when the pixels are read.
  Damage(temp_dir_ / "images/1.png");
  ExpectError("1.png");
}

TEST_F(BadInputTest, DamagedDistortedImage) {
  model_.cameras[0] = {"SIMPLE_RADIAL", 64, 48, {60, 32, 24, 0.1}};
  model_.WriteModel(temp_dir_ / "sparse/0");
  Damage(temp_dir_ / "images/1.png");
  ExpectError("1.png");
}

TEST_F(BadInputTest, ImageOfAnotherSize) {
  cv::imwrite(temp_dir_ / "images/1.png", RandomImage(48, 64, 0));
  ExpectError("48x64");
}

TEST_F(BadInputTest, MissingFolders) {
  const auto arguments = options_.arguments;
  fs::rename(temp_dir_ / "images", temp_dir_ / "other");
  ExpectError(temp_dir_ / "images");
  fs::rename(temp_dir_ / "sparse/0", temp_dir_ / "sparse/1");
  ExpectError(temp_dir_ / "sparse/0");
}

TEST_F(BadInputTest, ModelWithoutImagesOrPoints) {
  TinyModel model = model_;
  model.images.resize(1);
  model.WriteModel(temp_dir_ / "sparse/0");
  ExpectError("1 registered images");
  model.images.clear();
  model.WriteModel(temp_dir_ / "sparse/0");
  ExpectError("0 registered images");
  model = model_;
  model.points.clear();
  model.WriteModel(temp_dir_ / "sparse/0");
  ExpectError("no sparse points");
}

TEST_F(BadInputTest, UnsupportedCamera) {
  model_.cameras[0].model = "EQUIRECTANGULAR";
  model_.WriteModel(temp_dir_ / "sparse/0");
  ExpectError("spherical");
}

TEST_F(BadInputTest, NameThatLeavesTheWorkspace) {
  const std::string outside = temp_dir_ / "images/1.png";
  for (const std::string& name : {std::string("../../1.png"),
                                  std::string("a/../../1.png"),
                                  std::string(".."),
                                  std::string("./../1.png"),
                                  std::string("1.png/"),
                                  outside}) {
    model_.images[1].name = name;
    model_.WriteModel(temp_dir_ / "sparse/0");
    ExpectError("\"" + name + "\"");
  }
  // What a terminal would obey is not shown to it.
  model_.images[1].name = "1\x1b]0;title\x07\x7f.png";
  model_.WriteModel(temp_dir_ / "sparse/0");
  ExpectError("\"1?]0;title??.png\"");
}

TEST_F(BadInputTest, ExistingResultsNeedOverwrite) {
  fs::create_directories(temp_dir_ / "dense/stereo/depth_maps");
  std::ofstream(temp_dir_ / "dense/stereo/depth_maps/0.png.geometric.bin")
      << "precious";
  ExpectError("--overwrite");
}

TEST_F(BadInputTest, ExistingWorkspaceNeedsADecision) {
  fs::create_directories(temp_dir_ / "dense/images");
  ExpectError("choose a new one");
  model_.WriteModel(temp_dir_ / "dense/sparse");
  ExpectError("--workspace_path");
}

TEST_F(BadInputTest, UnknownOrUnsuitableDevice) {
  Add({"--StructNeRF.device=tpu"});
  ExpectError("--StructNeRF.device is tpu, but must be auto, cpu or cuda.");
  Add({"--StructNeRF.field=mlp"});
  options_.arguments[options_.arguments.size() - 2] =
      "--StructNeRF.device=cuda";
  ExpectError("--StructNeRF.device is cuda, but");
}

TEST_F(BadInputTest, OutputOverTheInput) {
  Remove("--output_path");
  Add({"--output_path", temp_dir_.Path(), "--overwrite"});
  ExpectError("would overwrite the original images");
}

TEST_F(BadInputTest, OutputOverTheModel) {
  fs::rename(temp_dir_ / "sparse/0", temp_dir_ / "model");
  fs::remove(temp_dir_ / "sparse");
  fs::create_directories(temp_dir_ / "dense");
  fs::rename(temp_dir_ / "model", temp_dir_ / "dense/sparse");
  Remove("--input_path");
  Add({"--input_path", temp_dir_ / "dense/sparse", "--overwrite"});
  ExpectError("would overwrite the model");
}

TEST_F(BadInputTest, UnwritableOutput) {
  Remove("--output_path");
  std::ofstream(temp_dir_ / "file") << "a file";
  Add({"--output_path", temp_dir_ / "file/dense"});
  ExpectError(temp_dir_ / "file/dense");
}

TEST_F(BadInputTest, FullDisk) {
  // The images have 9 kB, the model's files about 1 kB, maps of normals 36 kB.
  for (const size_t max_file_size : {500, 5000, 30000}) {
    options_.max_file_size = max_file_size;
    ExpectError("full");
  }
  // As above, but COLMAP writes new images instead of copying these.
  model_.cameras[0] = {"SIMPLE_RADIAL", 64, 48, {60, 32, 24, 0.1}};
  model_.WriteModel(temp_dir_ / "sparse/0");
  options_.max_file_size = 5000;
  ExpectError("is the disk full?");
}

TEST_F(BadInputTest, WrongOptions) {
  const auto arguments = options_.arguments;
  Add({"--StructNeRF.no_such_option", "1"});
  ExpectError("StructNeRF.no_such_option");
  options_.arguments = arguments;
  Add({"--StructNeRF.num_sources", "0"});
  ExpectError("StructNeRF.num_sources");
  options_.arguments = arguments;
  Add({"--StructNeRF.quality", "best"});
  ExpectError("StructNeRF.quality");
  options_.arguments = arguments;
  Add({"--StructNeRF.method", "dsnerf++"});
  ExpectError("StructNeRF.method");
  options_.arguments = arguments;
  Add({"--StructNeRF.method", "nerfing_mvs"});
  ExpectError("--StructNeRF.prior_path");
  options_.arguments = arguments;
  Add({"--StructNeRF.sparse_form", "huber"});
  ExpectError("StructNeRF.sparse_form");
  options_.arguments = arguments;
  Add({"--StructNeRF.max_memory_gb", "0.01"});
  ExpectError("StructNeRF.max_memory_gb");
  options_.arguments = arguments;
  Add({"--mask_path", temp_dir_ / "no_masks"});
  ExpectError(temp_dir_ / "no_masks");
  options_.arguments = arguments;
  Add({"--project_path", temp_dir_ / "none.ini"});
  ExpectError(temp_dir_ / "none.ini");
  options_.arguments = arguments;
  Add({"--StructNeRF.meth", "nerf"});
  ExpectError("--StructNeRF.method");
  options_.arguments = arguments;
  Remove("--input_path");
  ExpectError("--input_path");
}

TEST_F(BadInputTest, ContradictingPaths) {
  Add({"--workspace_path", temp_dir_ / "dense"});
  ExpectError("--workspace_path");
}

TEST_F(BadInputTest, WorkspacesHaveTheirOwnImages) {
  model_.WriteImages(temp_dir_ / "workspace/images");
  model_.WriteModel(temp_dir_ / "workspace/sparse");
  options_.arguments = {"structnerf_dense",
                        "--workspace_path",
                        temp_dir_ / "workspace",
                        "--image_path",
                        temp_dir_ / "images"};
  ExpectError("leave out --image_path");
}

TEST_F(BadInputTest, WorkspaceThatIsNone) {
  options_.arguments = {
      "structnerf_dense", "--workspace_path", temp_dir_ / "none"};
  ExpectError(temp_dir_ / "none");
  options_.arguments.back() = temp_dir_ / "images";
  ExpectError(temp_dir_ / "images/sparse");
}

TEST_F(BadInputTest, DistortedWorkspace) {
  model_.cameras[0] = {"SIMPLE_RADIAL", 64, 48, {60, 32, 24, 0.1}};
  model_.WriteImages(temp_dir_ / "workspace/images");
  model_.WriteModel(temp_dir_ / "workspace/sparse");
  options_.arguments = {
      "structnerf_dense", "--workspace_path", temp_dir_ / "workspace"};
  ExpectError("not undistorted");
}

}  // namespace
}  // namespace structnerf
