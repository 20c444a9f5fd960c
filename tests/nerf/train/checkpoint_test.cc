#include "nerf/train/checkpoint.h"

#include "tests/nerf/fake_engine.h"
#include "tests/nerf/plane_scene.h"
#include "tests/nerf/train/objective_scene.h"
#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

class CheckpointTest : public testing::Test {
 protected:
  CheckpointTest()
      : objective_(objective_scene_.MakeObjective()),
        guards_(objective_, ReconstructionOptions(), &engine_),
        newest_(folder_ / "checkpoint.bin"),
        older_(folder_ / "checkpoint.older.bin") {
    options_.folder = folder_.Path();
    options_.run = {{"num_steps", "200"}, {"seed", "0"}};
    for (int v = 0; v < 2; ++v) {
      scene_.views.push_back(
          MakeView("view", MakeCamera(16, 12, 12), {0.2 * v, 0, 0}));
      scene_.views.back().image = PlainImage(16, 12, 128);
    }
    scene_.points = {MakePoint(scene_, {0, 0, 4}, {0, 1})};
    state_.step = 121;
    state_.mean_loss = 0.125;
    state_.held_out_psnr = 20.5;
    state_.next_psnr = 0.6;
    state_.summary.num_steps = 120;
    state_.summary.stopped_early = true;
    state_.summary.seconds = 77;
  }

  Checkpoints Make() const { return Checkpoints(options_, scene_); }

  void Save(const int step) {
    state_.step = step;
    engine_.grid_learning_rates.resize(step);
    Make().Save(engine_, guards_, state_);
  }

  // Steps of the checkpoint that is loaded; -1 if none.
  int Load() {
    TrainingState state;
    const bool loaded = Make().Load(&engine_, &guards_, &state);
    if (loaded) {
      EXPECT_EQ(engine_.num_loaded_updates, static_cast<size_t>(state.step));
    }
    EXPECT_EQ(FindCheckpoint(options_).num_steps, loaded ? state.step : -1);
    return loaded ? state.step : -1;
  }

  void ExpectRefused(const std::string& name) {
    TrainingState state;
    EXPECT_THAT([&]() { Make().Load(&engine_, &guards_, &state); },
                ThrowsMessage<CheckpointMismatch>(HasSubstr(name)));
  }

  FakeEngine engine_;
  ObjectiveScene objective_scene_;
  TrainingObjective objective_;
  TrainingGuards guards_;
  TempDir folder_;
  const std::string newest_;
  const std::string older_;
  CheckpointOptions options_;
  Scene scene_;
  TrainingState state_;
};

TEST_F(CheckpointTest, GivesBackTheWholeState) {
  state_.is_complete = true;
  EXPECT_TRUE(guards_.EndStep(0, 1, 1.0, /*is_update_finite=*/false));
  Save(121);
  EXPECT_TRUE(guards_.EndStep(1, 2, 1.0, /*is_update_finite=*/false));
  TrainingState state;
  ASSERT_TRUE(Make().Load(&engine_, &guards_, &state));
  EXPECT_EQ(state.step, 121);
  EXPECT_TRUE(state.is_complete);
  EXPECT_EQ(state.mean_loss, 0.125);
  EXPECT_EQ(state.held_out_psnr, 20.5);
  EXPECT_EQ(state.next_psnr, 0.6);
  EXPECT_EQ(state.summary.num_steps, 120);
  EXPECT_TRUE(state.summary.stopped_early);
  EXPECT_EQ(state.summary.seconds, 77);
  EXPECT_EQ(guards_.Counts().at("non_finite_gradient"), 1);
  const CheckpointInfo info = FindCheckpoint(options_);
  EXPECT_EQ(info.num_steps, 121);
  EXPECT_TRUE(info.is_complete);
  EXPECT_EQ(info.warning, "");
}

TEST_F(CheckpointTest, NoneIsNoError) {
  EXPECT_EQ(Load(), -1);
  options_.folder = "";
  EXPECT_FALSE(Make().IsEnabled());
  Save(1);
  EXPECT_TRUE(fs::is_empty(folder_.Path()));
}

TEST_F(CheckpointTest, KeepsTwo) {
  Save(10);
  EXPECT_FALSE(fs::exists(older_));
  Save(20);
  Save(30);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.Path()), {}), 2);
  EXPECT_EQ(Load(), 30);
  fs::remove(newest_);
  EXPECT_EQ(Load(), 20);
}

// What was damaged is named, and the one before it is used.
TEST_F(CheckpointTest, DamagedOnesArePassedOver) {
  const auto damage = [](const std::string& path,
                         const std::function<void(std::fstream*)>& change) {
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    change(&file);
  };
  for (const size_t position : {0, 8, 30, 100, 200}) {
    Save(10);
    Save(20);
    damage(newest_, [&](std::fstream* file) {
      file->seekg(static_cast<std::streamoff>(position));
      const char byte = static_cast<char>(file->get());
      file->seekp(static_cast<std::streamoff>(position));
      file->put(static_cast<char>(byte ^ 4));
    });
    EXPECT_EQ(Load(), 10) << position;
    if (position != 8) {  // the format's version
      EXPECT_THAT(FindCheckpoint(options_).warning, HasSubstr(newest_));
    }
  }
  Save(10);
  Save(20);
  fs::resize_file(newest_, fs::file_size(newest_) - 1);
  EXPECT_EQ(Load(), 10);
  fs::resize_file(older_, 0);
  EXPECT_EQ(Load(), -1);
  EXPECT_THAT(FindCheckpoint(options_).warning,
              AllOf(HasSubstr(newest_), HasSubstr(older_)));
}

TEST_F(CheckpointTest, AnotherVersionIsRefused) {
  Save(10);
  std::fstream file(newest_, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(8);
  file.put(77);
  file.close();
  ExpectRefused("version 77");
}

TEST_F(CheckpointTest, AnotherRunIsRefusedAndTheDifferenceNamed) {
  Save(10);
  const CheckpointOptions options = options_;
  options_.run["num_steps"] = "300";
  ExpectRefused("num_steps is 200 there and 300 now");
  EXPECT_THAT([&]() { FindCheckpoint(options_); },
              ThrowsMessage<CheckpointMismatch>(
                  AllOf(HasSubstr("num_steps"), Not(HasSubstr("seed")))));
  options_ = options;
  options_.run["new option"] = "1";
  ExpectRefused("new option is none there and 1 now");
  options_ = options;
  EXPECT_EQ(Load(), 10);
}

TEST_F(CheckpointTest, AnotherSceneIsRefusedAndTheDifferenceNamed) {
  Save(10);
  const Scene scene = scene_;
  const auto expect_refused = [&](const std::function<void()>& change,
                                  const std::string& name) {
    change();
    ExpectRefused(name);
    scene_ = scene;
  };
  expect_refused([&]() { scene_.views[1].image.data[5] = 7; }, "photographs");
  expect_refused([&]() { scene_.views[1].exposure.gain[2] = 1.5f; },
                 "photographs");
  expect_refused([&]() { scene_.views[1].segments.assign(16 * 12, 3); },
                 "photographs");
  expect_refused([&]() { scene_.views[1].mask.assign(16 * 12, 255); }, "masks");
  expect_refused([&]() { scene_.views[0].prior_depth.assign(16 * 12, 3.0f); },
                 "depth priors");
  expect_refused([&]() { scene_.views[1].camera.fx += 1e-9; }, "cameras");
  expect_refused([&]() { scene_.views[0].name = "other"; }, "cameras");
  expect_refused(
      [&]() { scene_.views[0].cam_from_world_rotation(1, 2) += 1e-9; },
      "poses");
  expect_refused([&]() { scene_.views.pop_back(); }, "number of images");
  expect_refused([&]() { scene_.points[0].xyz.z() += 1e-9; }, "sparse points");
  expect_refused([&]() { scene_.points.push_back(scene_.points[0]); },
                 "number of sparse points is 1 there and 2 now");
  EXPECT_EQ(Load(), 10);
}

TEST_F(CheckpointTest, AFailedWriteLeavesTheOlderOnes) {
  Save(10);
  Save(20);
  fs::create_directory(newest_ + ".partial");
  EXPECT_THAT([&]() { Save(30); },
              ThrowsMessage<std::runtime_error>(HasSubstr("checkpoint.bin")));
  EXPECT_EQ(Load(), 20);
  fs::remove(newest_);
  EXPECT_EQ(Load(), 10);
}

}  // namespace
}  // namespace structnerf
