#include "nerf/train/trainer.h"

#include "nerf/train/training_guards.h"
#include "nerf/train/training_schedule.h"
#include "nerf/util/random.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

namespace structnerf {
namespace {

// Steps between two reports.
constexpr int kReportInterval = 10;

// Shares of the training between two PSNR measurements.
constexpr double kPsnrInterval = 0.1;
constexpr double kConvergenceInterval = 0.05;
constexpr size_t kMaxTestPixels = 8192;

// Steps of the schedule that one step stands for once training has converged:
// learning rates still fall, which settles what is left.
constexpr int kConvergedPace = 8;

// Share of the training over which one level fades in.
constexpr double kLevelFade = 0.02;

// Evaluations of the field. NeRF's fine network sees the coarse one's points
// again.
size_t SamplesPerRay(const ReconstructionOptions& options) {
  const SamplingOptions& sampling = options.sampling;
  const bool has_fine =
      options.field.type == "mlp" && sampling.num_fine_samples > 0;
  return has_fine ? 2 * sampling.num_samples + sampling.num_fine_samples
                  : sampling.num_samples;
}

double Seconds(const std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin)
      .count();
}

}  // namespace

Trainer::Trainer(TrainingObjective* objective,
                 const std::vector<int>& test_view_idxs,
                 const ReconstructionOptions& options,
                 RenderEngine* engine,
                 MatchFunction match_views)
    : objective_(*objective),
      options_(options),
      appearances_(SelectAppearances(objective->Views().size(),
                                     test_view_idxs,
                                     options.training.latent_test)),
      engine_(engine),
      match_views_(std::move(match_views)),
      second_round_(match_views_ == nullptr
                        ? 0
                        : static_cast<int>(options.loss.match_fraction *
                                           options.training.num_steps)) {
  ChooseTestPixels(test_view_idxs);
}

double Trainer::ShareOfRound(const int step) const {
  const bool is_second = step >= second_round_;
  const int begin = is_second ? second_round_ : 0;
  const int end = is_second ? options_.training.num_steps : second_round_;
  return static_cast<double>(step - begin) / (end - begin);
}

StepParameters Trainer::MakeStep(const int step) const {
  StepParameters parameters;
  parameters.step = step;
  parameters.num_tiles = objective_.NumTiles();
  const double time = ShareOfRound(step);
  const int num_levels = options_.field.num_levels;
  for (int level = 0; level < num_levels; ++level) {
    const double begin = num_levels > 1
                             ? options_.training.coarse_to_fine_fraction *
                                   level / (num_levels - 1)
                             : 0.0;
    const double weight = level == 0 ? 1.0 : (time - begin) / kLevelFade;
    parameters.level_weights.push_back(
        static_cast<float>(std::min(std::max(weight, 0.0), 1.0)));
  }
  return parameters;
}

bool Trainer::WaitsForMatches(const TrainingState& state) const {
  return match_views_ != nullptr && state.matched_depth == nullptr;
}

bool Trainer::HasAllLevels(const int step) const {
  return ShareOfRound(step) >=
         options_.training.coarse_to_fine_fraction + kLevelFade;
}

void Trainer::MatchViews(Progress* progress,
                         TrainingGuards* guards,
                         TrainingState* state) {
  FieldParameters first_round = engine_->Parameters();
  // As at the end of a training (Reconstructor::Train).
  engine_->SetParameters(first_round);
  engine_->RebuildDensityCache(progress);
  state->matched_depth = match_views_(progress);
  if (state->matched_depth == nullptr) {
    return;  // asked to stop: the field is used as it is
  }
  state->summary.confirmed_share = ConfirmedShare(*state->matched_depth);
  objective_.SetMatchedDepth(state->matched_depth);
  state->first_round = std::move(first_round);
  guards->BeginAnew(state->step);
}

void Trainer::ForgetMatches(TrainingState* state) {
  state->matched_depth = nullptr;
  state->first_round = FieldParameters();
  objective_.SetMatchedDepth(nullptr);
}

TrainingSummary Trainer::Run(Progress* progress,
                             PreviewRenderer* previews,
                             Checkpoints* checkpoints,
                             const double max_seconds) {
  const TrainingOptions& training = options_.training;
  std::vector<std::unique_ptr<TileObjective>> tile_objectives;
  for (int i = 0; i < engine_->NumThreads(); ++i) {
    tile_objectives.push_back(objective_.MakeTileObjective());
  }

  TrainingState state;
  const double measurement_interval =
      training.stop_when_converged ? kConvergenceInterval : kPsnrInterval;
  state.next_psnr = measurement_interval;
  TrainingGuards guards(objective_, options_, engine_);
  checkpoints->Load(engine_, &guards, &state);
  objective_.SetMatchedDepth(state.matched_depth);
  TrainingSummary& summary = state.summary;
  summary.num_parameters = engine_->NumParameters();
  summary.num_resumed_steps = summary.num_steps;
  const double resumed_seconds = summary.seconds;
  auto begin = std::chrono::steady_clock::now();
  const auto trained_seconds = [&]() {
    return resumed_seconds + Seconds(begin);
  };
  TrainingSchedule schedule(training.num_steps, max_seconds, resumed_seconds);
  if (summary.num_steps_to_converge >= 0) {
    schedule.SetPace(kConvergedPace);
  }
  double& mean_loss = state.mean_loss;
  int& step = state.step;
  while (step < training.num_steps && !state.is_complete) {
    summary.seconds = trained_seconds();
    try {
      begin += PauseOrAbort(progress);
      if (WaitsForMatches(state) && step >= second_round_) {
        const auto match_begin = std::chrono::steady_clock::now();
        MatchViews(progress, &guards, &state);
        begin += std::chrono::steady_clock::now() - match_begin;
      }
    } catch (const Aborted&) {
      if (progress->ShouldSave()) {
        checkpoints->Save(*engine_, guards, state);
      }
      throw;
    }
    if (state.matched_depth != nullptr && HasAllLevels(step)) {
      state.first_round = FieldParameters();
    }
    if (progress->ShouldStop()) {
      summary.stopped_early = true;
      if (!state.first_round.network.empty()) {
        engine_->Restore(state.first_round);
      }
      break;
    }
    checkpoints->SaveIfDue(*engine_, guards, state);
    if (summary.num_steps % kReportInterval == 0) {
      ProgressUpdate update;
      update.stage = "Training";
      update.fraction = static_cast<double>(step) / training.num_steps;
      update.seconds_left = schedule.SecondsLeft(step, summary.seconds);
      if (update.fraction >= state.next_psnr) {
        const Measurement measurement = MeasureTestPixels();
        state.held_out_psnr = measurement.Psnr();
        state.next_psnr += measurement_interval;
        if (training.stop_when_converged && !test_pixels_.empty() &&
            !WaitsForMatches(state) && HasAllLevels(step) &&
            summary.num_steps_to_converge < 0 &&
            state.convergence.Measure(measurement.squared_error,
                                      measurement.depths)) {
          summary.num_steps_to_converge = summary.num_steps;
          schedule.SetPace(kConvergedPace);
        }
      }
      update.loss = mean_loss;
      update.held_out_psnr = state.held_out_psnr;
      progress->Report(update);
    }

    if (previews != nullptr) {
      previews->RenderIfWanted(Seconds(begin), progress);
    }
    const LossValues losses =
        engine_->Accumulate(MakeStep(step), tile_objectives);
    double loss = 0;
    for (const double value : losses) {
      loss += value;
    }
    if (std::isfinite(loss)) {
      mean_loss = std::isnan(mean_loss) ? loss : 0.98 * mean_loss + 0.02 * loss;
    }
    const double decay =
        guards.LearningRateFactor() *
        std::pow(training.final_learning_rate_factor, ShareOfRound(step));
    const bool is_finite = engine_->Update(
        static_cast<float>(decay * training.grid_learning_rate),
        static_cast<float>(decay * training.network_learning_rate));
    if (++summary.num_steps % options_.sampling.cache_interval == 0) {
      engine_->RefreshDensityCache(
          static_cast<float>(options_.sampling.cache_decay));
    }
    const int next_step = schedule.Next(step, trained_seconds());
    if (guards.EndStep(step, next_step, loss, is_finite)) {
      step = next_step;
    } else {
      step = 0;
      mean_loss = std::numeric_limits<double>::quiet_NaN();
      state.next_psnr = measurement_interval;
      state.convergence = ConvergenceMonitor();
      ForgetMatches(&state);
      summary.num_steps_to_converge = -1;
      schedule.SetPace(1);
    }
  }
  ForgetMatches(&state);
  if (!state.is_complete) {
    summary.seconds = trained_seconds();
    state.is_complete = true;
    checkpoints->Save(*engine_, guards, state);
  }
  summary.guard_counts = guards.Counts();
  summary.final_loss = mean_loss;
  summary.held_out_psnr = MeasureTestPixels().Psnr();
  summary.num_rays =
      static_cast<size_t>(summary.num_steps) * objective_.NumRays();
  summary.num_samples = summary.num_rays * SamplesPerRay(options_);
  ProgressUpdate update;
  update.stage = "Training";
  update.fraction = 1;
  update.seconds_left = 0;
  update.loss = summary.final_loss;
  update.held_out_psnr = summary.held_out_psnr;
  progress->Report(update);
  return summary;
}

void Trainer::ChooseTestPixels(const std::vector<int>& test_view_idxs) {
  const TrainingViews& views = objective_.Views();
  const bool has_test_views = !test_view_idxs.empty();
  // A random choice among candidates that are too many to be listed.
  Random random(options_.training.seed);
  size_t num_candidates = 0;
  for (size_t v = 0; v < views.size(); ++v) {
    const int view_idx = static_cast<int>(v);
    const bool is_test =
        std::count(test_view_idxs.begin(), test_view_idxs.end(), view_idx) > 0;
    if (has_test_views && !is_test) {
      continue;
    }
    for (int row = 0; row < views.image(view_idx).height; ++row) {
      for (int col = 0; col < views.image(view_idx).width; ++col) {
        if (!(is_test || objective_.IsHeldOut(col, row)) ||
            views.IsMasked(view_idx, col, row)) {
          continue;
        }
        ++num_candidates;
        if (test_pixels_.size() < kMaxTestPixels) {
          test_pixels_.push_back({view_idx, col, row});
          continue;
        }
        const uint32_t place =
            random.NextBelow(static_cast<uint32_t>(num_candidates));
        if (place < kMaxTestPixels) {
          test_pixels_[place] = {view_idx, col, row};
        }
      }
    }
  }
}

double Trainer::Measurement::Psnr() const {
  return depths.empty() ? -1
                        : -10.0 * std::log10(std::max(squared_error, 1e-12));
}

Trainer::Measurement Trainer::MeasureTestPixels() const {
  Measurement measurement;
  if (test_pixels_.empty()) {
    return measurement;
  }
  const TrainingViews& views = objective_.Views();
  std::vector<RayTile> tiles((test_pixels_.size() + kMaxTileRays - 1) /
                             kMaxTileRays);
  for (size_t i = 0; i < test_pixels_.size(); ++i) {
    const TestPixel& pixel = test_pixels_[i];
    RayTile& tile = tiles[i / kMaxTileRays];
    tile.has_appearance = true;
    for (int k = 0; k < 2; ++k) {
      tile.appearance[k][tile.num_rays] = appearances_[pixel.view_idx][k];
    }
    views.geometry(pixel.view_idx)
        .SetRay(pixel.col + 0.5, pixel.row + 0.5, tile.num_rays++, &tile);
  }
  std::vector<RayOutputs> outputs;
  engine_->Render(tiles, /*with_color=*/true, &outputs);
  double sum = 0;
  for (size_t i = 0; i < test_pixels_.size(); ++i) {
    const TestPixel& pixel = test_pixels_[i];
    const RayOutputs& tile = outputs[i / kMaxTileRays];
    const size_t ray = i % kMaxTileRays;
    const Eigen::Vector3f target =
        views.Color(pixel.view_idx, pixel.col, pixel.row);
    sum += (views.exposure(pixel.view_idx).Apply(tile.Color(ray)) - target)
               .squaredNorm();
    measurement.depths.push_back(tile.depth[ray]);
  }
  measurement.squared_error =
      sum / (3.0 * static_cast<double>(test_pixels_.size()));
  return measurement;
}

}  // namespace structnerf
