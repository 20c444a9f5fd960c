#include "nerf/train/training_guards.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

namespace structnerf {
namespace {

// Tiles of rays at which the opacity is measured.
constexpr int kNumOpacityTiles = 8;

// False for NaN, too.
bool AreSound(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](const float value) {
    return std::abs(value) <= TrainingGuards::kMaxParameter;
  });
}

}  // namespace

TrainingGuards::TrainingGuards(const TrainingObjective& objective,
                               const ReconstructionOptions& options,
                               RenderEngine* engine)
    : objective_(objective),
      options_(options),
      engine_(engine),
      snapshot_(engine->MasterParameters()),
      patch_counts_(objective.CountPatches()),
      counts_{{"non_finite_gradient", 0},
              {"non_finite_loss", 0},
              {"restored_snapshot", 0},
              {"restarted_dead_field", 0},
              {"step_without_valid_patch", 0}} {}

bool TrainingGuards::EndStep(const int step,
                             const int next_step,
                             const double loss,
                             const bool is_update_finite) {
  counts_["non_finite_gradient"] += !is_update_finite;
  counts_["non_finite_loss"] += !std::isfinite(loss);
  num_bad_steps_ += !is_update_finite || !std::isfinite(loss);
  CountPatches(next_step - step);
  if (num_bad_steps_ >= kMaxBadSteps) {
    Restore("losses or gradients were not finite");
  } else if (next_step / kSnapshotInterval > step / kSnapshotInterval) {
    FieldParameters parameters = engine_->MasterParameters();
    if (AreSound(parameters.grid) && AreSound(parameters.network)) {
      snapshot_ = std::move(parameters);
      num_bad_steps_ = 0;
    } else {
      Restore("parameters of the field exploded");
    }
  }
  if (!IsDead(step, next_step)) {
    return true;
  }
  const int num_restarts = ++counts_["restarted_dead_field"];
  if (num_restarts > kMaxRestarts) {
    throw std::runtime_error(
        "training stopped: the field came out empty " +
        std::to_string(num_restarts) +
        " times, each time from another seed; check that the sparse points "
        "lie in front of the images, or lower grid_learning_rate and "
        "network_learning_rate");
  }
  learning_rate_factor_ *= 0.5;
  BeginAnew(0);
  return false;
}

void TrainingGuards::BeginAnew(const int step) {
  engine_->Restart(options_.training.seed + counts_["restarted_dead_field"]);
  snapshot_ = engine_->MasterParameters();
  num_bad_steps_ = 0;
  first_step_ = step;
}

void TrainingGuards::SaveState(StateWriter* writer) const {
  writer->WriteValue(learning_rate_factor_);
  writer->WriteValue(first_step_);
  writer->WriteArray(snapshot_.grid);
  writer->WriteArray(snapshot_.network);
  writer->WriteValue(num_bad_steps_);
  writer->WriteValue(num_steps_without_patch_);
  writer->WriteValue(num_positions_without_patch_);
  writer->WriteValue(static_cast<uint64_t>(counts_.size()));
  for (const auto& [name, count] : counts_) {
    writer->WriteArray(name);
    writer->WriteValue(count);
  }
}

void TrainingGuards::LoadState(StateReader* reader) {
  learning_rate_factor_ = reader->ReadValue<double>();
  first_step_ = reader->ReadValue<int>();
  FieldParameters snapshot;
  snapshot.grid = reader->ReadArray<std::vector<float>>();
  snapshot.network = reader->ReadArray<std::vector<float>>();
  if (snapshot.grid.size() != snapshot_.grid.size() ||
      snapshot.network.size() != snapshot_.network.size()) {
    throw std::runtime_error("the state is that of a field of another size");
  }
  snapshot_ = std::move(snapshot);
  num_bad_steps_ = reader->ReadValue<int>();
  num_steps_without_patch_ = reader->ReadValue<int>();
  num_positions_without_patch_ = reader->ReadValue<int>();
  const auto num_counts = reader->ReadValue<uint64_t>();
  for (uint64_t i = 0; i < num_counts; ++i) {
    const auto name = reader->ReadArray<std::string>();
    counts_[name] = reader->ReadValue<int>();
  }
  patch_counts_ = objective_.CountPatches();
}

void TrainingGuards::Restore(const std::string& reason) {
  if (++counts_["restored_snapshot"] > kMaxRestores) {
    std::ostringstream message;
    message << "training stopped: " << reason
            << ", although the learning rates were halved " << kMaxRestores
            << " times; lower grid_learning_rate (now "
            << options_.training.grid_learning_rate
            << ") and network_learning_rate (now "
            << options_.training.network_learning_rate
            << "), or the weights of the loss terms";
    throw std::runtime_error(message.str());
  }
  learning_rate_factor_ *= 0.5;
  engine_->Restore(snapshot_);
  num_bad_steps_ = 0;
}

void TrainingGuards::CountPatches(const int num_positions) {
  const PatchCounts counts = objective_.CountPatches();
  const bool has_none = counts.drawn > patch_counts_.drawn &&
                        counts.compared == patch_counts_.compared;
  patch_counts_ = counts;
  counts_["step_without_valid_patch"] += has_none;
  num_steps_without_patch_ = has_none ? num_steps_without_patch_ + 1 : 0;
  num_positions_without_patch_ =
      has_none ? num_positions_without_patch_ + num_positions : 0;
  // Sparse points may have to bring the depths near the truth first.
  if (num_steps_without_patch_ > kMaxStepsWithoutPatch &&
      2 * num_positions_without_patch_ > options_.training.num_steps) {
    throw std::runtime_error(
        "training stopped: in " + std::to_string(num_steps_without_patch_) +
        " steps no image patch was seen by another view; the images are too "
        "small or do not overlap. Check the poses, raise max_image_size, lower "
        "patch_dilation, or set patch_weight to 0 to train without patches");
  }
}

bool TrainingGuards::IsDead(const int step, const int next_step) const {
  if (options_.sampling.num_samples == 1) {
    return false;  // a single interval is opaque whatever the field says
  }
  const double interval = kOpacityInterval * options_.training.num_steps;
  if (static_cast<int>((next_step - first_step_) / interval) ==
      static_cast<int>((step - first_step_) / interval)) {
    return false;
  }
  const std::unique_ptr<TileObjective> rays = objective_.MakeTileObjective();
  std::vector<RayTile> tiles(kNumOpacityTiles);
  for (int tile = 0; tile < kNumOpacityTiles; ++tile) {
    rays->DrawRays(step, tile, &tiles[tile]);
  }
  std::vector<RayOutputs> outputs;
  engine_->Render(tiles, /*with_color=*/false, &outputs);
  double sum = 0;
  int count = 0;
  for (int tile = 0; tile < kNumOpacityTiles; ++tile) {
    for (int ray = 0; ray < tiles[tile].num_rays; ++ray) {
      sum += outputs[tile].opacity[ray];
      ++count;
    }
  }
  return !(sum >= kMinOpacity * count);
}

}  // namespace structnerf
