#include "colmap_plugin/quality_choice.h"

#include "colmap_plugin/staged_folder.h"
#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

const std::vector<PinholeCamera> kCameras(20,
                                          PinholeCamera{
                                              640, 480, 500, 500, 320, 240});

class QualityChoiceTest : public testing::Test {
 protected:
  QualityChoiceTest() {
    options_.output_path = (temp_dir_.Path() / "dense").string();
    options_.max_minutes = 1e4;
  }

  void LeaveCheckpoint() {
    const fs::path notes_path = StagedFolder::NotesPathOf(options_.output_path);
    fs::create_directories(notes_path);
    std::ofstream(notes_path / "checkpoint.bin") << "any";
  }

  TempDir temp_dir_;
  StructNerfOptions options_;
};

TEST_F(QualityChoiceTest, FollowsTheTime) {
  EXPECT_EQ(ChooseQuality(options_, kCameras).quality, "high");
  options_.max_minutes = 1e-4;
  EXPECT_EQ(ChooseQuality(options_, kCameras).quality, "low");
}

TEST_F(QualityChoiceTest, ARunGoesOnWithWhatItBeganWith) {
  LeaveCheckpoint();
  EXPECT_EQ(ChooseQuality(options_, kCameras).quality, "high");
  RememberQuality(StagedFolder::NotesPathOf(options_.output_path),
                  {"medium", 1});
  EXPECT_EQ(ChooseQuality(options_, kCameras).quality, "medium");
  EXPECT_EQ(ChooseQuality(options_, kCameras).num_sweeps, 1);
  options_.resume = false;
  EXPECT_EQ(ChooseQuality(options_, kCameras).quality, "high");
}

TEST_F(QualityChoiceTest, WithoutAFolderForResultsNothingIsGoneOnWith) {
  const fs::path working_folder = fs::current_path();
  fs::current_path(temp_dir_.Path());
  options_.output_path = "";
  LeaveCheckpoint();
  RememberQuality(StagedFolder::NotesPathOf(""), {"medium", 1});
  EXPECT_EQ(ChooseQuality(options_, kCameras).quality, "high");
  fs::current_path(working_folder);
}

TEST_F(QualityChoiceTest, WithoutCheckpointNothingIsRemembered) {
  LeaveCheckpoint();
  const std::string notes_path =
      StagedFolder::NotesPathOf(options_.output_path);
  RememberQuality(notes_path, {"medium", 4});
  fs::remove(fs::path(notes_path) / "checkpoint.bin");
  EXPECT_EQ(ChooseQuality(options_, kCameras).quality, "high");
}

TEST_F(QualityChoiceTest, AFolderThatIsNotThereIsNamed) {
  try {
    RememberQuality("/nowhere/at/all", {"medium", 4});
    ADD_FAILURE();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("/nowhere/at/all/quality"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace structnerf
