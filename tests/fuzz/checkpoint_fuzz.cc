// The reader of checkpoints. The checksum is made right where the first byte is
// odd, so that what lies behind it is reached.

#include "nerf/engine/grid_engine.h"
#include "nerf/train/checkpoint.h"
#include "nerf/util/checksummed_file.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/nerf/train/objective_scene.h"
#include "tests/support/temp_dir.h"

#include <cstring>
#include <exception>
#include <memory>
#include <string>
#include <vector>

namespace structnerf {
namespace {

const TempDir& Folder() {
  static const TempDir folder;
  return folder;
}

// A training with the smallest field there is.
class Training {
 public:
  Training() : objective_(scene_.MakeObjective()) {
    EngineOptions options;
    options.field.num_levels = 1;
    options.field.log2_table_size = 10;
    options.field.min_resolution = 2;
    options.field.max_resolution = 2;
    options.field.hidden_width = 16;
    options.sampling.cache_resolution = 8;
    options.sampling.num_samples = 1;
    options.num_threads = 1;
    engine = MakeFusedEngine(options);
    guards = std::make_unique<TrainingGuards>(
        objective_, ReconstructionOptions(), engine.get());
    CheckpointOptions checkpoint_options;
    checkpoint_options.folder = Folder().Path().string();
    checkpoint_options.run = {{"option", "value"}};
    checkpoints =
        std::make_unique<Checkpoints>(checkpoint_options, scene_.scene);
  }

 private:
  ObjectiveScene scene_;
  TrainingObjective objective_;

 public:
  std::unique_ptr<RenderEngine> engine;
  std::unique_ptr<TrainingGuards> guards;
  std::unique_ptr<Checkpoints> checkpoints;
};

Training& TheTraining() {
  static Training training;
  return training;
}

std::string NewestPath() { return Folder() / "checkpoint.bin"; }

}  // namespace

std::vector<std::string> FuzzSeeds() {
  Training& training = TheTraining();
  TrainingState state;
  state.step = 7;
  training.checkpoints->Save(*training.engine, *training.guards, state);
  const std::string file = ReadFuzzFile(NewestPath());
  return {std::string(1, '\0') + file, std::string(1, '\1') + file};
}

}  // namespace structnerf

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, const size_t size) {
  using namespace structnerf;
  if (size == 0) {
    return 0;
  }
  std::vector<uint8_t> file(data + 1, data + size);
  if (data[0] % 2 == 1 && file.size() >= sizeof(uint64_t)) {
    Checksum checksum;
    const size_t num_bytes = file.size() - sizeof(uint64_t);
    checksum.Add(file.data(), num_bytes);
    const uint64_t value = checksum.Value();
    std::memcpy(file.data() + num_bytes, &value, sizeof(value));
  }
  Training& training = TheTraining();
  WriteFuzzFile(NewestPath(), file.data(), file.size());
  try {
    TrainingState state;
    training.checkpoints->Load(
        training.engine.get(), training.guards.get(), &state);
  } catch (const std::exception&) {
  }
  // Whatever it has read, it must still be able to render.
  RayTile rays;
  std::vector<RayOutputs> outputs;
  rays.num_rays = 1;
  for (int axis = 0; axis < 3; ++axis) {
    rays.origin[axis].fill(0.5f);
    rays.direction[axis].fill(axis == 2 ? 1.0f : 0.0f);
  }
  rays.direction_norm.fill(1.0f);
  rays.near.fill(0.1f);
  rays.far.fill(0.5f);
  training.engine->Render({rays}, /*with_color=*/true, &outputs);
  return 0;
}
