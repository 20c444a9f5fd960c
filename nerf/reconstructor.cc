#include "nerf/reconstructor.h"

#include "nerf/analysis/scene_analysis.h"
#include "nerf/engine/hierarchical_sampling.h"
#include "nerf/engine/scene_engine_options.h"
#include "nerf/extract/consistency.h"
#include "nerf/extract/preview_renderer.h"
#include "nerf/field/field_file.h"
#include "nerf/field/mlp_layout.h"
#include "nerf/planes/plane_completion.h"
#include "nerf/planes/plane_votes.h"
#include "nerf/scene_guards.h"
#include "nerf/train/checkpoint.h"
#include "nerf/train/prior_agreement.h"
#include "nerf/train/trainer.h"
#include "nerf/train/training_objective.h"
#include "nerf/view_mapper.h"
#include "nerf/view_selection.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace structnerf {
namespace {

// Bytes per pixel of a photograph: RGB in the scene; packed colours and grey
// values in TrainingViews; label, mask and pixel list of segments; blankness.
constexpr size_t kBytesPerTrainingPixel = 3 + 4 + 2 + 4 + 1 + 4 + 1;

// Depth prior and deviation, in the scene and packed for training; where they
// bound rays, nearest and farthest depth, twice, too.
constexpr size_t kBytesPerPriorPixel = 4 * sizeof(float);
constexpr size_t kBytesPerBoundPixel = 4 * sizeof(float);

// The same where planes are completed: depth, reliability and label.
constexpr size_t kBytesPerPlanePixel = 4 + 1 + 4;

// The same where the field learns from matches: what it learns; depth while it
// is checked; what planes are looked for with, and labels.
constexpr size_t kBytesPerMatchedPixel = 4 + 4 + kBytesPerPlanePixel + 4;

// Bytes per pixel of the maps of one view: depth, deviation, normal,
// distinctness.
constexpr size_t kBytesPerMapPixel = 6 * sizeof(float);

// Bytes per grid feature: value and two moments, half-precision copy; the last
// snapshot and the next.
constexpr size_t kBytesPerFeature = 4 + 2 * 2 + 2 + 2 * 4;

// Bytes per sample of a step: position and density; at each level 8 corner
// pairs of the gradient and the gradient by the features.
constexpr size_t kBytesPerSample = 4 * sizeof(float);
constexpr size_t kBytesPerSampleAndLevel =
    8 * 3 * sizeof(float) + kGridFeatures * sizeof(float);

// Bytes per pixel of a view whose depth is refined: planes, seed, cost,
// distinctness, and those per used source.
constexpr size_t kBytesPerRefinedPixel = 6 * sizeof(float);
constexpr size_t kBytesPerRefinedPixelAndSource = sizeof(int32_t);

size_t EstimateGridMemory(const ReconstructionOptions& options) {
  const FieldLayout layout(options.field, Eigen::Vector3f::Ones());
  const size_t field =
      layout.num_grid_entries * kGridFeatures * kBytesPerFeature;
  const size_t step =
      static_cast<size_t>(options.training.rays_per_step) *
      (options.sampling.num_samples *
           (kBytesPerSample + layout.levels.size() * kBytesPerSampleAndLevel) +
       // One gradient of the networks per tile.
       layout.num_network_parameters * sizeof(float) / kMaxTileRays);
  const size_t cache =
      static_cast<size_t>(std::pow(options.sampling.cache_resolution, 3.0));
  return field + step + cache;
}

// Field, gradient and two moments of two networks; of a batch of points the
// input, the activation and the gradient of each layer.
size_t EstimateMlpMemory(const ReconstructionOptions& options) {
  const MlpLayout layout(options.field);
  size_t floats_per_point = 0;
  for (const LayerLayout& layer : layout.Layers()) {
    floats_per_point += layer.num_inputs + 2 * layer.num_outputs;
  }
  return sizeof(float) *
         (2 * 4 * layout.num_parameters +
          MlpBatchSize(options.sampling).num_points * floats_per_point);
}

SceneDecision DescribeFarTerm(const TrainingObjective& objective,
                              const LossOptions& loss) {
  if (loss.far_weight == 0) {
    return {"far term", "off", "as told"};
  }
  return {"far term",
          "on",
          std::to_string(std::lround(100 * objective.BlankShare())) +
              " % of the pixels are blank"};
}

}  // namespace

class Reconstructor::Impl {
 public:
  Impl(Scene scene_in,
       const ReconstructionOptions& options_in,
       const EngineFactory& make_engine)
      : scene(std::move(scene_in)), options(options_in) {
    std::string error;
    if (!options.Check(&error)) {
      throw std::invalid_argument(error);
    }
    scene.Check();
    if (options.loss.exposure == "none") {
      for (View& view : scene.views) {
        view.exposure = Exposure();
      }
    }
    const int num_contradictory = RemoveContradictoryPoints(&scene);
    SceneAnalysis analysis = AnalyzeScene(scene, options);
    options = std::move(analysis.options);
    frame = analysis.frame;
    decisions = std::move(analysis.decisions);
    const int test_every = options.training.test_every;
    test_view_idxs = HeldOutViewIdxs(scene.views.size(), test_every);
    train_view_idxs = TrainedViewIdxs(scene.views.size(), test_every);
    if (train_view_idxs.size() < 2) {
      throw std::invalid_argument(
          "test_every leaves fewer than two images to train on");
    }
    options.extraction =
        FitToScene(options.extraction, scene, train_view_idxs.size());
    // Held-out views must not guide others.
    sources =
        SelectSourceViews(scene, options.loss.num_sources, train_view_idxs);
    if (options.AveragesDepth()) {
      averaging_views = SelectSourceViews(
          scene, options.extraction.averaging_num_views, train_view_idxs);
    }
    const std::vector<std::vector<int>> training_sources =
        SelectTrainingSources(sources, options.loss, train_view_idxs);
    findings = InspectScene(scene, sources, num_contradictory);
    PreparePriors();
    objective =
        std::make_unique<TrainingObjective>(scene,
                                            frame,
                                            train_view_idxs,
                                            training_sources,
                                            options.loss,
                                            options.training,
                                            options.sampling.guide_by_prior);
    decisions.push_back(DescribeFarTerm(*objective, options.loss));
    engine = make_engine(MakeEngineOptions(options, frame, scene.views.size()));
    pool = std::make_unique<ThreadPool>(options.training.num_threads);
    mapper = std::make_unique<ViewMapper>(scene,
                                          frame,
                                          objective->Views(),
                                          sources,
                                          options,
                                          engine.get(),
                                          pool.get());
    if (options.CompletesPlanes()) {
      plane_completion =
          std::make_unique<PlaneCompletion>(scene,
                                            frame,
                                            objective->Views(),
                                            train_view_idxs,
                                            sources,
                                            options.stereo.window_radius);
    }
  }

  void PreparePriors() {
    if (!options.NeedsPrior()) {
      return;
    }
    for (const int view_idx : test_view_idxs) {
      // What was made of a held-out photograph must not help to render it.
      scene.views[view_idx].prior_depth.clear();
      scene.views[view_idx].prior_deviation.clear();
    }
    int& num_missing = findings.counts["view_without_prior"];
    for (const int view_idx : train_view_idxs) {
      num_missing += scene.views[view_idx].prior_depth.empty();
    }
    if (num_missing == static_cast<int>(train_view_idxs.size())) {
      throw std::invalid_argument(
          "no image has a depth prior, but dense_prior_weight, guide_by_prior "
          "or bound_by_prior asks for one; give prior_path");
    }
    const PriorCounts counts = EstimatePriorDeviations(sources, &scene);
    findings.counts["prior_behind_camera"] =
        static_cast<int>(counts.num_points_behind);
    findings.counts["prior_unconfirmed"] =
        static_cast<int>(counts.num_unconfirmed);
    if (options.sampling.bound_by_prior) {
      findings.counts["inverted_ray_bounds"] = static_cast<int>(
          BoundRaysByPriors(frame, &scene).num_inverted_ranges);
    }
  }

  Scene scene;
  ReconstructionOptions options;
  std::vector<SceneDecision> decisions;
  SceneFrame frame;
  std::vector<int> train_view_idxs;
  std::vector<int> test_view_idxs;
  std::vector<std::vector<int>> sources;
  std::vector<std::vector<int>> averaging_views;
  SceneFindings findings;
  std::unique_ptr<TrainingObjective> objective;
  std::unique_ptr<RenderEngine> engine;
  std::unique_ptr<ThreadPool> pool;
  std::unique_ptr<ViewMapper> mapper;
  std::unique_ptr<PlaneCompletion> plane_completion;  // null = off
  TrainingSummary summary;
};

size_t Reconstructor::EstimateMemory(const ReconstructionOptions& options,
                                     const size_t num_views,
                                     const PinholeCamera& camera) {
  const PinholeCamera training_camera =
      camera.Reduced(options.training.max_image_size);
  const size_t training_pixels = training_camera.NumPixels();
  const size_t refinement =
      options.MatchesViews()
          ? camera.NumPixels() * kBytesPerMapPixel +
                training_pixels * (kBytesPerRefinedPixel +
                                   kBytesPerRefinedPixelAndSource *
                                       options.stereo.num_used_sources)
          : 0;
  const size_t bytes_per_training_pixel =
      kBytesPerTrainingPixel +
      (options.CompletesPlanes() ? kBytesPerPlanePixel : 0) +
      (options.NeedsPrior() ? kBytesPerPriorPixel : 0) +
      (options.LearnsFromMatches() ? kBytesPerMatchedPixel : 0) +
      (options.sampling.bound_by_prior ? kBytesPerBoundPixel : 0);
  const size_t engine = options.field.type == "mlp"
                            ? EstimateMlpMemory(options)
                            : EstimateGridMemory(options);
  const size_t planes =
      options.CompletesPlanes()
          ? num_views * sizeof(ChosenPlane) *
                PlaneLattice(training_camera.width, training_camera.height)
                    .NumCells()
          : 0;
  return engine + refinement + planes +
         num_views * training_pixels * bytes_per_training_pixel +
         camera.NumPixels() * kBytesPerMapPixel;
}

Reconstructor::Reconstructor(Scene scene,
                             const ReconstructionOptions& options,
                             const EngineFactory& make_engine)
    : impl_(std::make_unique<Impl>(std::move(scene), options, make_engine)) {}

Reconstructor::Reconstructor(Scene scene, const ReconstructionOptions& options)
    : Reconstructor(std::move(scene), options, MakeGridEngine) {}

Reconstructor::~Reconstructor() = default;

const std::vector<std::string>& Reconstructor::Warnings() const {
  return impl_->findings.warnings;
}

const std::vector<SceneDecision>& Reconstructor::Decisions() const {
  return impl_->decisions;
}

const ReconstructionOptions& Reconstructor::Options() const {
  return impl_->options;
}

void Reconstructor::Train(Progress* progress,
                          const CheckpointOptions& checkpoint_options,
                          const double max_seconds) {
  Checkpoints checkpoints(checkpoint_options, impl_->scene);
  MatchFunction match_views;
  if (impl_->options.LearnsFromMatches()) {
    match_views = [this](Progress* match_progress) {
      return impl_->mapper->Match(impl_->train_view_idxs, match_progress);
    };
  }
  Trainer trainer(impl_->objective.get(),
                  impl_->test_view_idxs,
                  impl_->options,
                  impl_->engine.get(),
                  match_views);
  PreviewRenderer previews(
      impl_->scene,
      impl_->frame,
      impl_->objective->Views(),
      SelectAppearances(impl_->scene.views.size(),
                        impl_->test_view_idxs,
                        impl_->options.training.latent_test),
      impl_->engine.get());
  impl_->summary = trainer.Run(progress, &previews, &checkpoints, max_seconds);
  impl_->summary.guard_counts.insert(impl_->findings.counts.begin(),
                                     impl_->findings.counts.end());
  // What is rendered from now on is exactly what SaveField would save, though
  // training may have stopped while levels were coming in.
  impl_->engine->SetParameters(impl_->engine->Parameters());
  impl_->engine->RebuildDensityCache(progress);
}

DenseMaps Reconstructor::RenderView(const size_t view_idx,
                                    Progress* progress,
                                    DenseMaps* field) const {
  return impl_->mapper->MakeMaps(static_cast<int>(view_idx), progress, field);
}

void Reconstructor::AddMaps(const size_t view_idx, const DenseMaps& maps) {
  if (impl_->plane_completion) {
    impl_->plane_completion->AddView(
        static_cast<int>(view_idx), maps, impl_->pool.get());
  }
}

void Reconstructor::FindPlanes(Progress* progress) {
  if (impl_->plane_completion) {
    impl_->plane_completion->FindPlanes(impl_->pool.get(), progress);
  }
}

size_t Reconstructor::CompletePlanes(const size_t view_idx,
                                     DenseMaps* maps) const {
  if (!impl_->plane_completion) {
    return 0;
  }
  return impl_->plane_completion->Complete(
      static_cast<int>(view_idx), impl_->pool.get(), maps);
}

const std::vector<std::vector<int>>& Reconstructor::SourceViews() const {
  return impl_->sources;
}

const std::vector<std::vector<int>>& Reconstructor::AveragingViews() const {
  return impl_->averaging_views;
}

const TrainingSummary& Reconstructor::Summary() const { return impl_->summary; }

void Reconstructor::SaveField(const std::string& path) const {
  WriteField(path,
             impl_->options.field,
             impl_->frame.extent,
             impl_->engine->Parameters());
}

void Reconstructor::LoadField(const std::string& path) {
  impl_->engine->SetParameters(
      ReadField(path, impl_->options.field, impl_->frame.extent));
  Progress silent;
  impl_->engine->RebuildDensityCache(&silent);
}

}  // namespace structnerf
