#include "colmap_plugin/input_check.h"

#include "nerf/scene_file.h"
#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <sys/stat.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

// Empty if the function does not throw.
template <typename Function>
std::string ErrorOf(Function function) {
  try {
    function();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

class InputCheckTest : public testing::Test {
 protected:
  std::string ErrorOfModel(const TinyModel& model) {
    model.WriteModel(temp_dir_ / "sparse");
    return ErrorOf([&]() { CheckModel(ReadModel(temp_dir_ / "sparse")); });
  }

  std::string ErrorOfImages(const TinyModel& model) {
    model.WriteModel(temp_dir_ / "sparse");
    return ErrorOf([&]() {
      CheckImages(ReadModel(temp_dir_ / "sparse"), temp_dir_ / "images");
    });
  }

  TempDir temp_dir_;
};

TEST_F(InputCheckTest, AcceptsAGoodModel) {
  const TinyModel model = MakeTinyModel(2);
  model.WriteImages(temp_dir_ / "images");
  EXPECT_EQ(ErrorOfModel(model), "");
  EXPECT_EQ(ErrorOfImages(model), "");
  EXPECT_THAT(ImageNames(ReadModel(temp_dir_ / "sparse")),
              ElementsAre("0.png", "1.png"));
}

TEST_F(InputCheckTest, NamesMissingModel) {
  EXPECT_THAT(ErrorOf([&]() { ReadModel(temp_dir_ / "none"); }),
              HasSubstr(temp_dir_ / "none"));
  EXPECT_THAT(ErrorOf([&]() { ReadModel(temp_dir_.Path()); }),
              HasSubstr("holds no COLMAP model"));
}

TEST_F(InputCheckTest, NamesDamagedModel) {
  MakeTinyModel(2).WriteModel(temp_dir_ / "sparse");
  std::ofstream(temp_dir_ / "sparse/images.txt") << "1 no number\n\n";
  EXPECT_THAT(ErrorOf([&]() { ReadModel(temp_dir_ / "sparse"); }),
              HasSubstr(temp_dir_ / "sparse"));
}

TEST_F(InputCheckTest, RefusesUnknownCameraModels) {
  TinyModel model = MakeTinyModel(2);
  model.cameras[0].model = "EQUIRECTANGULAR";
  const std::string error = ErrorOfModel(model);
  EXPECT_THAT(error, HasSubstr(temp_dir_ / "sparse"));
  EXPECT_THAT(error, HasSubstr("spherical"));
}

TEST_F(InputCheckTest, NeedsTwoImagesAndPoints) {
  EXPECT_THAT(ErrorOfModel(MakeTinyModel(0)), HasSubstr("0 registered"));
  EXPECT_THAT(ErrorOfModel(MakeTinyModel(1)), HasSubstr("1 registered"));
  TinyModel model = MakeTinyModel(2);
  model.points.clear();
  EXPECT_THAT(ErrorOfModel(model), HasSubstr("no sparse points"));
}

TEST_F(InputCheckTest, ImageNamesStayInTheWorkspace) {
  for (const std::string name :
       {"../0.png", "a/../../0.png", "/etc/0.png", "..", "sub/", "a\tb.png"}) {
    TinyModel model = MakeTinyModel(2);
    model.images[1].name = name;
    const std::string error = ErrorOfModel(model);
    EXPECT_THAT(error, HasSubstr("would leave the workspace")) << name;
    EXPECT_THAT(error, Not(HasSubstr("\t")));
  }
  for (const std::string name :
       {"a/b/0.png", "..0.png", "a..b/0.png", "ö.png"}) {
    TinyModel model = MakeTinyModel(2);
    model.images[1].name = name;
    EXPECT_EQ(ErrorOfModel(model), "") << name;
  }
}

TEST_F(InputCheckTest, ImageNamesHaveNoBlanksAtTheirEnds) {
  MakeTinyModel(2).WriteModel(temp_dir_ / "sparse");
  for (const std::string name : {" 0.png", "0.png "}) {
    colmap::Reconstruction reconstruction = ReadModel(temp_dir_ / "sparse");
    reconstruction.Image(1).SetName(name);
    EXPECT_THAT(ErrorOf([&]() { CheckModel(reconstruction); }),
                HasSubstr("\"" + name + "\" begins or ends with a blank"));
  }
}

TEST_F(InputCheckTest, FisheyesWithoutDistortionAreNoPinholes) {
  TinyModel model = MakeTinyModel(2);
  model.cameras[0] = {"OPENCV_FISHEYE", 64, 48, {60, 60, 32, 24, 0, 0, 0, 0}};
  EXPECT_THAT(ErrorOfModel(model), HasSubstr("0.png (OPENCV_FISHEYE)"));
  model.cameras[0].params[4] = 1e-6;
  EXPECT_EQ(ErrorOfModel(model), "");
}

TEST_F(InputCheckTest, PointsAreOfTheModelsImages) {
  const auto error_of = [&](const std::string& points) {
    MakeTinyModel(2).WriteModel(temp_dir_ / "sparse");
    std::ofstream(temp_dir_ / "sparse/points3D.txt") << points << "\n";
    return ErrorOf([&]() { CheckModel(ReadModel(temp_dir_ / "sparse")); });
  };
  EXPECT_EQ(error_of("1 0 0 4 1 1 1 0.5 1 0 2 0"), "");
  EXPECT_THAT(error_of("1 0 0 4 1 1 1 0.5 1 0 7 0"),
              HasSubstr("point 1 of the model was seen in image 7"));
  EXPECT_THAT(error_of("1 0 0 4 1 1 1 0.5 1 0 2 9"),
              HasSubstr("keypoint 9 of image 1.png"));
  EXPECT_THAT(error_of("1 0 nan 4 1 1 1 0.5 1 0 2 0"),
              HasSubstr("point 1 of the model has no finite coordinates"));
}

TEST_F(InputCheckTest, ImagesToFuseAreOfTheModel) {
  const auto check = [&]() {
    return ErrorOf(
        [&]() { CheckFusionConfig(temp_dir_.Path().string(), {"a b.png"}); });
  };
  EXPECT_EQ(check(), "");
  fs::create_directory(temp_dir_ / "stereo");
  std::ofstream(temp_dir_ / "stereo/fusion.cfg") << "# comment\n\n a b.png \n";
  EXPECT_EQ(check(), "");
  std::ofstream(temp_dir_ / "stereo/fusion.cfg") << "a b.png\ngone.png\n";
  EXPECT_THAT(check(),
              HasSubstr("Line 2 of " + temp_dir_ / "stereo/fusion.cfg" +
                        " names the image gone.png"));
}

TEST_F(InputCheckTest, ImageNamesAreUnique) {
  TinyModel model = MakeTinyModel(2);
  model.images[1].name = "./0.png";
  EXPECT_THAT(ErrorOfModel(model), HasSubstr("two images named ./0.png"));
}

TEST_F(InputCheckTest, NamesBadImages) {
  const TinyModel model = MakeTinyModel(3);
  EXPECT_THAT(ErrorOfImages(model), HasSubstr(temp_dir_ / "images"));
  model.WriteImages(temp_dir_ / "images");

  cv::imwrite(temp_dir_ / "images/1.png", RandomImage(63, 48, 0));
  std::string error = ErrorOfImages(model);
  EXPECT_THAT(error, HasSubstr(temp_dir_ / "images/1.png"));
  EXPECT_THAT(error, HasSubstr("63x48"));
  EXPECT_THAT(error, HasSubstr("64x48"));

  std::ofstream(temp_dir_ / "images/1.png") << "no image";
  error = ErrorOfImages(model);
  EXPECT_THAT(error, HasSubstr(temp_dir_ / "images/1.png"));
  EXPECT_THAT(error, HasSubstr("cannot be read"));

  std::ofstream(temp_dir_ / "images/1.png", std::ios::binary)
      << "\x89PNG\r\n\x1a\n";
  EXPECT_THAT(ErrorOfImages(model), HasSubstr("cannot be read"));

  cv::imwrite(temp_dir_ / "images/1.png", RandomImage(64, 48, 0));
  fs::resize_file(temp_dir_ / "images/1.png",
                  fs::file_size(temp_dir_ / "images/1.png") / 2);
  error = ErrorOfImages(model);
  EXPECT_THAT(error, HasSubstr(temp_dir_ / "images/1.png"));
  EXPECT_THAT(error, HasSubstr("cut off"));

  std::filesystem::remove(temp_dir_ / "images/1.png");
  EXPECT_THAT(ErrorOfImages(model), HasSubstr("does not exist"));

  std::filesystem::create_directory(temp_dir_ / "images/1.png");
  EXPECT_THAT(ErrorOfImages(model), HasSubstr("cannot be read"));
}

TEST_F(InputCheckTest, ImagesHaveColors) {
  const TinyModel model = MakeTinyModel(2);
  model.WriteImages(temp_dir_ / "images");
  for (const auto& [type, is_readable] :
       {std::pair(CV_8UC1, true), {CV_16UC3, true}, {CV_16UC1, false}}) {
    cv::imwrite(temp_dir_ / "images/1.png", cv::Mat(48, 64, type, 9));
    const std::string error = ErrorOfImages(model);
    if (is_readable) {
      EXPECT_EQ(error, "");
    } else {
      EXPECT_THAT(error, HasSubstr("8 bits per channel"));
    }
  }
}

TEST_F(InputCheckTest, MaskFolderMustHoldAMask) {
  MakeTinyModel(2).WriteModel(temp_dir_ / "sparse");
  const auto check = [&]() {
    CheckMasks(ReadModel(temp_dir_ / "sparse"), temp_dir_ / "masks");
  };
  EXPECT_THAT(ErrorOf(check), HasSubstr("does not exist"));
  std::filesystem::create_directory(temp_dir_ / "masks");
  std::ofstream(temp_dir_ / "masks/1.png") << "wrong name";
  EXPECT_THAT(ErrorOf(check), HasSubstr("0.png.png"));
  std::ofstream(temp_dir_ / "masks/1.png.png") << "right name";
  EXPECT_EQ(ErrorOf(check), "");
}

TEST_F(InputCheckTest, IncompleteModelIsNoticed) {
  const TinyModel model = MakeTinyModel(3);
  model.WriteModel(temp_dir_ / "sparse");
  const auto original = ReadModel(temp_dir_ / "sparse");
  const auto error_of = [&](const TinyModel& written) {
    written.WriteModel(temp_dir_ / "written");
    return ErrorOf([&]() {
      CheckWrittenModel(original, ReadModel(temp_dir_ / "written"));
    });
  };
  EXPECT_EQ(error_of(model), "");
  TinyModel written = model;
  written.images.pop_back();
  EXPECT_THAT(error_of(written), HasSubstr("disk full"));
  written = model;
  written.points.pop_back();
  EXPECT_THAT(error_of(written), HasSubstr("disk full"));
  written = model;
  written.points[3].x() += 0.1;
  EXPECT_THAT(error_of(written), HasSubstr("disk full"));
  written = model;
  written.images[1].name = "";
  EXPECT_THAT(error_of(written), HasSubstr("disk full"));
  written = model;
  written.cameras[0].width = 0;
  EXPECT_THAT(error_of(written), HasSubstr("disk full"));
}

TEST_F(InputCheckTest, SceneIsExportedBesideNothingElse) {
  const auto error_of = [](const std::string& path) {
    return ErrorOf([&]() { CheckExport(path); });
  };
  EXPECT_EQ(error_of(""), "");
  EXPECT_EQ(error_of("scene.bin"), "");  // in the present folder
  EXPECT_EQ(error_of(temp_dir_ / "scene.bin"), "");
  WriteScene(Scene(), temp_dir_ / "scene.bin");
  EXPECT_EQ(error_of(temp_dir_ / "scene.bin"), "");
  EXPECT_THAT(error_of(temp_dir_ / "none/scene.bin"),
              HasSubstr("that folder does not exist"));
  std::ofstream(temp_dir_ / "a.jpg") << "a photograph";
  EXPECT_THAT(error_of(temp_dir_ / "a.jpg"), HasSubstr("not a scene"));
  EXPECT_THAT(error_of(temp_dir_.Path()), HasSubstr("that is a folder"));
}

TEST_F(InputCheckTest, ResultsStayOnOneDisk) {
  const fs::path other_disk = "/dev/shm";
  struct stat here;
  struct stat there;
  if (stat(temp_dir_.Path().c_str(), &here) != 0 ||
      stat(other_disk.c_str(), &there) != 0 || here.st_dev == there.st_dev) {
    GTEST_SKIP() << "there is no other disk";
  }
  StructNerfOptions options;
  options.workspace_path = temp_dir_ / "dense";
  fs::create_directories(options.workspace_path);
  const auto error = [&]() {
    return ErrorOf([&]() { CheckOutput(options, {"0.png"}); });
  };
  // No results are moved there.
  fs::create_directory_symlink(other_disk,
                               fs::path(options.workspace_path) / "images");
  EXPECT_EQ(error(), "");
  fs::create_directory_symlink(other_disk,
                               fs::path(options.workspace_path) / "stereo");
  EXPECT_THAT(error(), HasSubstr("dense/stereo is on another disk"));
}

TEST_F(InputCheckTest, TellsAProjectFromAWorkspace) {
  StructNerfOptions options;
  options.output_path = temp_dir_ / "project";
  fs::create_directories(options.output_path + "/sparse/0");
  const auto error = [&]() {
    return ErrorOf([&]() { CheckOutput(options, {"0.png"}); });
  };
  EXPECT_THAT(error(), HasSubstr("for instance " + options.output_path));
  MakeTinyModel(2).WriteModel(options.output_path + "/sparse");
  EXPECT_THAT(error(), HasSubstr("pass it as --workspace_path"));
}

TEST_F(InputCheckTest, ResultsAreWrittenIntoAFolderThatExists) {
  const auto error_of = [](const std::string& path) {
    return ErrorOf([&]() { CheckOutputFile("output_path", path); });
  };
  EXPECT_EQ(error_of("eval.json"), "");
  EXPECT_EQ(error_of(temp_dir_ / "eval.json"), "");
  EXPECT_THAT(
      error_of(temp_dir_ / "none/eval.json"),
      testing::AllOf(HasSubstr("--output_path"), HasSubstr("does not exist")));
  EXPECT_THAT(error_of(temp_dir_.Path()), HasSubstr("that is a folder"));
}

}  // namespace
}  // namespace structnerf
