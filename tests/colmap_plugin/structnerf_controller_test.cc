#include "colmap_plugin/structnerf_controller.h"

#include "colmap_plugin/input_check.h"
#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/temp_dir.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using Status = StructNerfController::Status;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Throws when a stage is reported.
class ThrowingProgress : public RunProgress {
 public:
  ThrowingProgress(const std::string& stage, std::function<void()> throw_error)
      : stage_(stage), throw_error_(std::move(throw_error)) {}

  void Report(const ProgressUpdate& update) override {
    if (update.stage == stage_) {
      throw_error_();
    }
  }

 private:
  const std::string stage_;
  const std::function<void()> throw_error_;
};

// Aborts the run, and throws when it is asked why.
class ThrowingAbort : public RunProgress {
 public:
  bool ShouldAbort() override { return true; }
  bool ShouldSave() override { throw 1; }
};

// Stops the run once images are being loaded, and counts what it is told.
class StoppedWhileLoading : public RunProgress {
 public:
  void Report(const ProgressUpdate& update) override {
    is_loading_ = is_loading_ || update.stage == "Loading images";
  }
  bool ShouldStop() override { return is_loading_; }
  void Note(const std::string& sentence) override {
    notes_.push_back(sentence);
  }

  const std::vector<std::string>& Notes() const { return notes_; }

 private:
  bool is_loading_ = false;
  std::vector<std::string> notes_;
};

class StructNerfControllerTest : public testing::Test {
 protected:
  StructNerfControllerTest() {
    const TinyModel model = MakeTinyModel(3);
    model.WriteModel(folder_ / "model");
    model.WriteImages(folder_ / "images");
    options_.reconstruction = QualityPreset("low");
    options_.reconstruction.training.num_steps = 20;
    options_.image_path = folder_ / "images";
    options_.output_path = folder_ / "dense";
  }

  std::unique_ptr<StructNerfController> Run(RunProgress* progress) {
    auto controller = std::make_unique<StructNerfController>(
        options_,
        std::make_shared<const colmap::Reconstruction>(
            ReadModel(folder_ / "model")),
        progress);
    controller->Run();
    return controller;
  }

  // Of the report of a run that succeeds.
  std::vector<std::string> StageNames() {
    RunProgress silent;
    const auto controller = Run(&silent);
    EXPECT_EQ(controller->GetStatus(), Status::kSuccess) << controller->Error();
    std::vector<std::string> names;
    for (const StageReport& stage : controller->Report().stages) {
      names.push_back(stage.name);
    }
    fs::remove_all(options_.output_path);
    return names;
  }

  const TempDir folder_;
  StructNerfOptions options_;
};

TEST_F(StructNerfControllerTest, StagesAreNamedByWhatIsDone) {
  EXPECT_THAT(StageNames(), Contains("Completing planes"));
  EXPECT_EQ(StageNames().back(), "Averaging depth maps");

  options_.reconstruction.stereo.num_iterations = 0;
  EXPECT_THAT(StageNames(),
              ElementsAre("Undistorting images",
                          "Loading images",
                          "Training",
                          "Rendering depth maps",
                          "Writing depth maps",
                          "Checking consistency",
                          "Fusing points"));
}

TEST_F(StructNerfControllerTest, WhateverIsThrownBecomesASentence) {
  struct Error {
    std::function<void()> throw_it;
    std::string text;
  };
  for (const char* stage : {"Undistorting images", "Training"}) {
    for (const Error& error :
         {Error{[]() { throw std::runtime_error("The disk is full."); },
                "The disk is full."},
          Error{[]() { throw std::bad_alloc(); }, "memory did not suffice"},
          Error{[]() { throw 1; }, "unknown"}}) {
      ThrowingProgress progress(stage, error.throw_it);
      const auto controller = Run(&progress);
      EXPECT_EQ(controller->GetStatus(), Status::kFailed);
      EXPECT_THAT(controller->Error(), HasSubstr(error.text)) << stage;
      EXPECT_FALSE(fs::exists(options_.output_path)) << stage;
    }
  }
}

TEST_F(StructNerfControllerTest, WhatWasLearnedIsKeptWhateverIsThrown) {
  ThrowingProgress progress("Fusing points", []() { throw 1; });
  const auto failed = Run(&progress);
  EXPECT_EQ(failed->GetStatus(), Status::kFailed);
  EXPECT_FALSE(failed->KeptPath().empty());

  RunProgress silent;
  const auto resumed = Run(&silent);
  EXPECT_EQ(resumed->GetStatus(), Status::kSuccess) << resumed->Error();
  EXPECT_EQ(resumed->Report().training.num_resumed_steps, 20);
}

TEST_F(StructNerfControllerTest, StopsBeforeTrainingIsPrepared) {
  StoppedWhileLoading progress;
  EXPECT_EQ(Run(&progress)->GetStatus(), Status::kAborted);
  EXPECT_THAT(progress.Notes(), IsEmpty()) << "what was decided for training";
  EXPECT_FALSE(fs::exists(options_.output_path));
}

TEST_F(StructNerfControllerTest, AnErrorWhileCleaningUpBecomesASentence) {
  ThrowingAbort progress;
  const auto controller = Run(&progress);
  EXPECT_EQ(controller->GetStatus(), Status::kFailed);
  EXPECT_THAT(controller->Error(), HasSubstr("unknown"));
  EXPECT_FALSE(fs::exists(options_.output_path));
}

}  // namespace
}  // namespace structnerf
