// Training that is cut into pieces ends with the maps of one in a piece, bit
// for bit, whatever the number of threads.

#include "nerf/reconstructor.h"
#include "tests/support/synthetic_room.h"
#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// Is told to end, and to save, at a step.
class Interruption : public Progress {
 public:
  explicit Interruption(const int step) : step_(step) {}
  bool ShouldAbort() override { return step_-- <= 0; }
  bool ShouldSave() override { return true; }

 private:
  int step_;
};

class ResumeTest : public testing::Test {
 protected:
  ResumeTest() {
    SyntheticRoomOptions options;
    options.num_views = 4;
    options.width = 48;
    options.height = 36;
    scene_ = MakeScene(MakeSyntheticRoom(options));
    options_.field.log2_table_size = 12;
    options_.sampling.cache_resolution = 32;
    options_.training.num_steps = 120;
    options_.training.rays_per_step = 64;
    checkpoints_.folder = folder_.Path();
  }

  Reconstructor Make(const int num_threads) {
    options_.training.num_threads = num_threads;
    return Reconstructor(scene_, options_);
  }

  // Trains to the end, or to a step that it is interrupted at. Returns the
  // field file and the first view's depth.
  std::string Train(const int num_threads,
                    const int num_steps = std::numeric_limits<int>::max()) {
    Reconstructor reconstructor = Make(num_threads);
    Interruption progress(num_steps);
    reconstructor.Train(&progress, checkpoints_);
    num_resumed_steps_ = reconstructor.Summary().num_resumed_steps;
    reconstructor.SaveField(folder_ / "field.bin");
    std::ifstream file(folder_ / "field.bin", std::ios::binary);
    std::string bytes(std::istreambuf_iterator<char>(file), {});
    Progress silent;
    const DenseMaps maps = reconstructor.RenderView(0, &silent);
    return bytes.append(reinterpret_cast<const char*>(maps.depth.data()),
                        maps.depth.size() * sizeof(float));
  }

  TempDir folder_;
  Scene scene_;
  ReconstructionOptions options_;
  CheckpointOptions checkpoints_;
  int num_resumed_steps_ = 0;
};

TEST_F(ResumeTest, PiecesGiveTheSameResult) {
  checkpoints_.folder = "";
  const std::string expected = Train(1);
  checkpoints_.folder = folder_.Path();
  // The first levels come in, the sparse points go, the end is near.
  int num_steps = 0;
  for (const int num_more : {0, 7, 30, 31, 45}) {
    EXPECT_THROW(Train(1 + num_more % 3, num_more), Aborted);
    num_steps += num_more;
    EXPECT_EQ(FindCheckpoint(checkpoints_).num_steps, num_steps);
  }
  EXPECT_TRUE(Train(2) == expected);
  EXPECT_EQ(num_resumed_steps_, num_steps);
  // Once more from the end.
  EXPECT_TRUE(Train(3) == expected);
  EXPECT_EQ(num_resumed_steps_, 120);
}

TEST_F(ResumeTest, TwoRoundsInPiecesGiveTheSameResult) {
  options_.loss.match_weight = 0.02;
  checkpoints_.folder = "";
  const std::string expected = Train(1);
  checkpoints_.folder = folder_.Path();
  // In the first round, while views are matched, and in the second round. How
  // often matching asks whether to abort is certain with one thread only.
  EXPECT_THROW(Train(2, 50), Aborted);
  EXPECT_EQ(FindCheckpoint(checkpoints_).num_steps, 50);
  EXPECT_THROW(Train(1, 15), Aborted);
  EXPECT_EQ(FindCheckpoint(checkpoints_).num_steps, 60);
  int num_asked = 15;
  int num_steps = 60;
  while (num_steps == 60) {
    num_asked += 15;
    EXPECT_THROW(Train(1, num_asked), Aborted);
    num_steps = FindCheckpoint(checkpoints_).num_steps;
  }
  EXPECT_LT(num_steps, 80);
  EXPECT_THROW(Train(1, 10), Aborted);
  EXPECT_TRUE(Train(2) == expected);
  EXPECT_EQ(num_resumed_steps_, num_steps + 10);
}

TEST_F(ResumeTest, SavingOnTheWayChangesNothing) {
  checkpoints_.folder = "";
  const std::string expected = Train(2);
  checkpoints_.folder = folder_.Path();
  checkpoints_.interval_seconds = 0.01;
  EXPECT_TRUE(Train(2) == expected);
}

}  // namespace
}  // namespace structnerf
