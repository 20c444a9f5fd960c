// What can be chosen before a run, in COLMAP's window.

#include "ui/setup_page.h"

#include "tests/ui/dense_window_fixture.h"

#include <QComboBox>
#include <QDoubleSpinBox>
#include <QLabel>
#include <QLineEdit>
#include <QTest>
#include <filesystem>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;

using SetupPageTest = DenseWindowFixture;

TEST_F(SetupPageTest, ATimeLimitChoosesTheQuality) {
  OpenDialog();
  auto* max_minutes = Find<QDoubleSpinBox>("max_minutes");
  EXPECT_EQ(max_minutes->value(), 0);
  max_minutes->setValue(1000);
  EXPECT_EQ(Find<QComboBox>("quality")->currentText(), "high");
  EXPECT_EQ(options_.quality, "high");
  EXPECT_EQ(options_.max_minutes, 1000);
  // Less than any machine needs.
  max_minutes->setValue(0.01);
  EXPECT_EQ(Find<QComboBox>("quality")->currentText(), "low");
  EXPECT_EQ(options_.reconstruction.training.num_steps,
            QualityPreset("low").training.num_steps);
  EXPECT_EQ(options_.reconstruction.stereo.num_iterations, 0);
  EXPECT_THAT(Find<QLabel>("expectation")->text().toStdString(),
              HasSubstr("about"));
  // Without it, there is time for all sweeps.
  max_minutes->setValue(0);
  EXPECT_EQ(options_.reconstruction.stereo.num_iterations,
            QualityPreset("low").stereo.num_iterations);
}

TEST_F(SetupPageTest, AnotherModelMayNeedAnotherQuality) {
  OpenDialog();
  auto* max_minutes = Find<QDoubleSpinBox>("max_minutes");
  max_minutes->setValue(1000);
  EXPECT_EQ(options_.quality, "high");
  options_.max_minutes = 0.01;
  Item()->trigger();
  EXPECT_EQ(Find<QComboBox>("quality")->currentText(), "low");
  // Chosen by hand, it stays.
  auto* quality = Find<QComboBox>("quality");
  quality->setCurrentText("high");
  emit quality->activated(quality->currentIndex());
  Item()->trigger();
  EXPECT_EQ(options_.quality, "high");
}

TEST_F(SetupPageTest, WhatIsTypedInStaysWhenTheDialogIsRaised) {
  OpenDialog();
  const std::pair<const char*, const char*> typed[] = {
      {"workspace_path", "/my/workspace"},
      {"image_path", "/my/images"},
      {"mask_path", "/my/masks"}};
  for (const auto& [name, path] : typed) {
    Find<QLineEdit>(name)->setText(path);
  }
  Item()->trigger();
  for (const auto& [name, path] : typed) {
    EXPECT_EQ(Find<QLineEdit>(name)->text().toStdString(), path);
  }
}

TEST_F(SetupPageTest, WordsKeepWhatWasChanged) {
  OpenDialog();
  SetNumSteps(7);
  const auto choose = [this](const char* name, const char* word) {
    auto* choice = Find<QComboBox>(name);
    choice->setCurrentText(word);
    emit choice->activated(choice->currentIndex());
  };
  choose("quality", "high");
  EXPECT_EQ(options_.reconstruction.training.num_steps, 7);
  EXPECT_EQ(options_.reconstruction.training.max_image_size,
            QualityPreset("high").training.max_image_size);
  choose("method", "nerf");
  EXPECT_EQ(options_.method, "nerf");
  EXPECT_EQ(options_.reconstruction.loss.patch_weight, 0);
  choose("method", "structnerf");
  EXPECT_EQ(options_.reconstruction.loss.patch_weight,
            QualityPreset("high").loss.patch_weight);
  Find<QDoubleSpinBox>("max_minutes")->setValue(0.01);
  EXPECT_EQ(options_.quality, "low");
  EXPECT_EQ(options_.reconstruction.training.num_steps, 7);
  EXPECT_EQ(options_.reconstruction.training.max_image_size,
            QualityPreset("low").training.max_image_size);
}

TEST_F(SetupPageTest, ABadFolderIsNamedInADialog) {
  OpenDialog();
  Find<QLineEdit>("image_path")->setText("/no/such/folder");
  EXPECT_EQ(Find<QComboBox>("device")->currentText(), "cpu");
  Find<QComboBox>("device")->setCurrentText("auto");
  AnswerMessage(QMessageBox::Ok, "message_bad_folder");
  Click("start");
  EXPECT_EQ(options_.device, "auto");
  ASSERT_TRUE(QTest::qWaitFor([this]() { return !message_.empty(); },
                              kRunMilliseconds));
  EXPECT_THAT(message_, HasSubstr("/no/such/folder"));
  EXPECT_FALSE(fs::exists(WorkspacePath()));

  message_.clear();
  Find<QLineEdit>("workspace_path")->clear();
  AnswerMessage(QMessageBox::Ok, "message_no_workspace");
  Click("start");
  EXPECT_THAT(message_, HasSubstr("workspace"));
}

}  // namespace
}  // namespace structnerf
