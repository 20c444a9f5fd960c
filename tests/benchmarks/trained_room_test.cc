#include "tests/benchmarks/trained_room.h"

#include "nerf/engine/torch_engine.h"
#include "nerf/util/cpu_time.h"
#include "tests/benchmarks/sphere_room.h"

#include <cmath>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

double MeanDepthError(TrainedRoom* room) {
  const std::vector<RayTile> tiles = SphereRoomView(32, 24);
  std::vector<RayOutputs> outputs;
  room->Engine().Render(tiles, /*with_color=*/false, &outputs);
  double sum = 0;
  int num_rays = 0;
  for (size_t i = 0; i < tiles.size(); ++i) {
    for (int ray = 0; ray < tiles[i].num_rays; ++ray) {
      sum += std::abs(outputs[i].depth[ray] - SphereRoomDepth(tiles[i], ray));
      ++num_rays;
    }
  }
  EXPECT_EQ(num_rays, 32 * 24);
  return sum / num_rays;
}

TEST(TrainedRoom, LearnsTheWall) {
  TrainedRoom room(MakeFusedEngine(PresetEngineOptions("low", 1)), 512);
  const double error_before = MeanDepthError(&room);
  const double loss_before = room.Train(1);
  const double loss = room.Train(120);
  EXPECT_EQ(room.NumSteps(), 121);
  EXPECT_LT(loss, 0.3 * loss_before);
  EXPECT_LT(MeanDepthError(&room), 0.2 * error_before);
}

TEST(TrainedRoom, CountsWork) {
  TrainedRoom room(MakeFusedEngine(PresetEngineOptions("low", 1)), 64);
  room.Train(3);
  const WorkCounts work = room.Engine().Work();
  EXPECT_EQ(work.num_rays, 3u * 64);
  EXPECT_EQ(work.num_samples, 3u * 64 * 16);
  EXPECT_GT(work.num_color_samples, 0u);
  EXPECT_LE(work.num_color_samples, work.num_samples);
  EXPECT_GT(work.num_gradient_samples, 0u);
  EXPECT_LE(work.num_gradient_samples, work.num_samples);
  const size_t num_touched = room.CountTouchedEntries();
  EXPECT_GT(num_touched, 64u);
  EXPECT_LE(num_touched, 64u * 16 * 8 * 4);
}

// The fused engine is some tens of times faster. A tenth of that still means
// that its kernels run.
TEST(TrainedRoom, TrainsFasterThanTheOracle) {
  const EngineOptions options = PresetEngineOptions("low", 1);
  TrainedRoom fused(MakeFusedEngine(options), 256);
  TrainedRoom oracle(MakeTorchEngine(options, TorchPrecision::kFloat), 256);
  fused.Train(2);
  oracle.Train(1);
  double seconds[2] = {};
  for (int round = 0; round < 3; ++round) {
    double begin = ProcessCpuSeconds();
    fused.Train(4);
    seconds[0] += (ProcessCpuSeconds() - begin) / 4;
    begin = ProcessCpuSeconds();
    oracle.Train(1);
    seconds[1] += ProcessCpuSeconds() - begin;
  }
  EXPECT_GT(seconds[1], 4 * seconds[0]);
}

}  // namespace
}  // namespace structnerf
