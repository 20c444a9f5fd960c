#include "nerf/train/training_objective.h"

#include "nerf/losses/far_push.h"
#include "nerf/losses/planar_loss.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace structnerf {
namespace {

// Distance of pixels whose colour is held out.
constexpr int kHeldOutStride = 16;

// Relative deviation of matched depth, from which on rays are pulled.
constexpr float kMatchDeviation = 0.02f;

PatchLoss::Options MakePatchOptions(const LossOptions& options) {
  PatchLoss::Options patch_options;
  patch_options.radius = options.patch_radius;
  patch_options.dilation = options.patch_dilation;
  patch_options.ssim_share = static_cast<float>(options.patch_ssim_share);
  patch_options.num_best = options.num_best_sources;
  return patch_options;
}

}  // namespace

// One thread's tile: the rays that were drawn and what they are compared with.
class TrainingObjective::Tile : public TileObjective {
 public:
  explicit Tile(const TrainingObjective& objective) : objective_(objective) {}

  void DrawRays(const int step, const int tile, RayTile* rays) override {
    step_ = step;
    const bool with_sparse = objective_.SparseWeight(step) > 0;
    objective_.drawer_.Draw(step, tile, with_sparse, rays, &drawn_);
  }

  LossValues Evaluate(const RayOutputs& outputs,
                      RayGradients* gradients) override {
    LossValues losses = {};
    AddColorLoss(outputs, gradients, &losses);
    AddPatchLoss(outputs, gradients, &losses);
    AddPlanarLoss(outputs, gradients, &losses);
    AddSparseLoss(outputs, gradients, &losses);
    AddPriorLoss(outputs, gradients, &losses);
    AddDensePriorLoss(outputs, gradients, &losses);
    AddMatchedDepthLoss(outputs, gradients, &losses);
    AddFarLoss(outputs, gradients, &losses);
    return losses;
  }

  bool UsesSamples() const override {
    return objective_.sparse_form_ == SparseForm::kRayTermination &&
           drawn_.first_keypoint_ray > drawn_.first_sparse_ray;
  }

  LossValues EvaluateSamples(const RaySamples& samples,
                             float* d_weight) override {
    LossValues losses = {};
    for (int ray = drawn_.first_sparse_ray; ray < drawn_.first_keypoint_ray;
         ++ray) {
      losses[static_cast<size_t>(LossTerm::kSparse)] +=
          EvaluateRayTermination(WeightedTarget(ray), samples, ray, d_weight);
    }
    return losses;
  }

 private:
  void AddColorLoss(const RayOutputs& outputs,
                    RayGradients* gradients,
                    LossValues* losses) const {
    const float weight =
        static_cast<float>(objective_.loss_options_.color_weight) /
        objective_.NumRays();
    double sum = 0;
    for (int ray = 0; ray < drawn_.tile->num_rays; ++ray) {
      if (objective_.IsHeldOut(drawn_.col[ray], drawn_.row[ray])) {
        continue;
      }
      const Eigen::Vector3f target = objective_.views_.Color(
          drawn_.view_idx[ray], drawn_.col[ray], drawn_.row[ray]);
      const Exposure& exposure =
          objective_.views_.exposure(drawn_.view_idx[ray]);
      const Eigen::Vector3f difference =
          exposure.Apply(outputs.Color(ray)) - target;
      sum += difference.squaredNorm();
      for (int c = 0; c < 3; ++c) {
        gradients->d_color[c][ray] +=
            2 * weight * exposure.gain[c] * difference[c];
      }
    }
    (*losses)[static_cast<size_t>(LossTerm::kColor)] += weight * sum;
  }

  void AddPatchLoss(const RayOutputs& outputs,
                    RayGradients* gradients,
                    LossValues* losses) const {
    if (objective_.loss_options_.patch_weight == 0) {
      return;
    }
    // All rays, or those through keypoints.
    const bool is_dense = objective_.loss_options_.patch_sampling == "dense";
    const int begin = is_dense ? 0 : drawn_.first_keypoint_ray;
    const int end = is_dense ? drawn_.tile->num_rays : drawn_.first_random_ray;
    if (begin == end) {
      return;  // no image has keypoints
    }
    const float weight =
        static_cast<float>(objective_.loss_options_.patch_weight) /
        (is_dense ? objective_.NumRays()
                  : (end - begin) * objective_.num_tiles_);
    PerRay<float> loss;
    PerRay<float> d_depth;
    PerRay<int> num_valid;
    objective_.patch_loss_.Evaluate(end - begin,
                                    drawn_.view_idx.data() + begin,
                                    drawn_.col.data() + begin,
                                    drawn_.row.data() + begin,
                                    outputs.depth.data() + begin,
                                    loss.data() + begin,
                                    d_depth.data() + begin,
                                    num_valid.data() + begin);
    double sum = 0;
    size_t num_compared = 0;
    for (int ray = begin; ray < end; ++ray) {
      if (num_valid[ray] > 0) {
        sum += loss[ray];
        gradients->d_depth[ray] += weight * d_depth[ray];
        ++num_compared;
      }
    }
    objective_.num_drawn_patches_ += end - begin;
    objective_.num_compared_patches_ += num_compared;
    (*losses)[static_cast<size_t>(LossTerm::kPatch)] += weight * sum;
  }

  void AddPlanarLoss(const RayOutputs& outputs,
                     RayGradients* gradients,
                     LossValues* losses) const {
    const float weight =
        static_cast<float>(objective_.loss_options_.planar_weight) /
        (kNumPlanarGroups * objective_.num_tiles_);
    double sum = 0;
    for (int group = 0; group < drawn_.num_planar_groups; ++group) {
      float d_depth[4];
      const float* const depth = outputs.depth.data() + 4 * group;
      sum +=
          objective_.planar_form_ == PlanarForm::kTripleProduct
              ? TripleProductLoss(4 * group, depth, d_depth)
              : EvaluatePlanarLoss(drawn_.planar_groups[group], depth, d_depth);
      for (int k = 0; k < 4; ++k) {
        gradients->d_depth[4 * group + k] += weight * d_depth[k];
      }
    }
    (*losses)[static_cast<size_t>(LossTerm::kPlanar)] += weight * sum;
  }

  // The triple product in units of the scene's typical depth.
  float TripleProductLoss(const int first_ray,
                          const float* depth,
                          float* d_depth) const {
    const float per_unit = 1.0f / objective_.length_unit_;
    Eigen::Vector3f directions[4];
    for (int k = 0; k < 4; ++k) {
      for (int axis = 0; axis < 3; ++axis) {
        directions[k][axis] =
            per_unit * drawn_.tile->direction[axis][first_ray + k];
      }
    }
    return EvaluateTripleProduct(directions, depth, d_depth);
  }

  SparseTarget WeightedTarget(const int ray) const {
    SparseTarget target = drawn_.sparse_target[ray];
    target.weight *= objective_.SparseWeight(step_) /
                     (kNumSparseRays * objective_.num_tiles_);
    return target;
  }

  void AddSparseLoss(const RayOutputs& outputs,
                     RayGradients* gradients,
                     LossValues* losses) const {
    if (objective_.sparse_form_ == SparseForm::kRayTermination) {
      return;  // needs samples
    }
    double sum = 0;
    for (int ray = drawn_.first_sparse_ray; ray < drawn_.first_keypoint_ray;
         ++ray) {
      const SparseTarget target = WeightedTarget(ray);
      sum +=
          objective_.sparse_form_ == SparseForm::kLineOfSight
              ? EvaluateLineOfSight(target, outputs, ray, gradients)
              : EvaluateSquaredDepth(
                    target, objective_.length_unit_, outputs, ray, gradients);
    }
    (*losses)[static_cast<size_t>(LossTerm::kSparse)] += sum;
  }

  void AddFarLoss(const RayOutputs& outputs,
                  RayGradients* gradients,
                  LossValues* losses) const {
    if (objective_.blankness_.empty()) {
      return;
    }
    const float weight =
        static_cast<float>(objective_.loss_options_.far_weight) /
        objective_.NumRays();
    double sum = 0;
    for (int ray = 0; ray < drawn_.tile->num_rays; ++ray) {
      const size_t pixel =
          static_cast<size_t>(drawn_.row[ray]) *
              objective_.views_.image(drawn_.view_idx[ray]).width +
          drawn_.col[ray];
      float d_depth;
      sum += EvaluateFarPush(objective_.blankness_[drawn_.view_idx[ray]][pixel],
                             outputs.depth[ray],
                             &d_depth);
      gradients->d_depth[ray] += weight * d_depth;
    }
    (*losses)[static_cast<size_t>(LossTerm::kFar)] += weight * sum;
  }

  // Where no sparse point is, the interpolated depth pulls at the ray.
  void AddPriorLoss(const RayOutputs& outputs,
                    RayGradients* gradients,
                    LossValues* losses) const {
    SparseTarget target;
    target.weight = objective_.PriorWeight(step_) / objective_.NumRays();
    if (target.weight == 0) {
      return;
    }
    double sum = 0;
    for (int ray = 0; ray < drawn_.tile->num_rays; ++ray) {
      target.depth = objective_.hints_.InterpolatedDepth(
          drawn_.view_idx[ray], drawn_.col[ray], drawn_.row[ray]);
      if (!drawn_.IsSparse(ray) && target.depth > 0) {
        sum += EvaluateLineOfSight(target, outputs, ray, gradients);
      }
    }
    (*losses)[static_cast<size_t>(LossTerm::kPrior)] += sum;
  }

  void AddDensePriorLoss(const RayOutputs& outputs,
                         RayGradients* gradients,
                         LossValues* losses) const {
    const double weight = objective_.loss_options_.dense_prior_weight;
    if (weight == 0) {
      return;
    }
    (*losses)[static_cast<size_t>(LossTerm::kDensePrior)] += SumLikelihoods(
        weight,
        [this](const int ray) {
          return objective_.hints_.DensePrior(
              drawn_.view_idx[ray], drawn_.col[ray], drawn_.row[ray]);
        },
        outputs,
        gradients);
  }

  void AddMatchedDepthLoss(const RayOutputs& outputs,
                           RayGradients* gradients,
                           LossValues* losses) const {
    if (objective_.matched_depth_ == nullptr) {
      return;
    }
    (*losses)[static_cast<size_t>(LossTerm::kMatchedDepth)] += SumLikelihoods(
        objective_.loss_options_.match_weight,
        [this](const int ray) {
          const int view_idx = drawn_.view_idx[ray];
          const size_t width = objective_.views_.image(view_idx).width;
          const float depth =
              (*objective_.matched_depth_)[view_idx][drawn_.row[ray] * width +
                                                     drawn_.col[ray]];
          return PriorDepth{depth, kMatchDeviation * depth};
        },
        outputs,
        gradients);
  }

  // Of the depth that `prior_of(ray)` gives rays that are not through a sparse
  // point, which knows better.
  template <typename PriorOf>
  double SumLikelihoods(const double weight,
                        const PriorOf& prior_of,
                        const RayOutputs& outputs,
                        RayGradients* gradients) const {
    const float ray_weight = static_cast<float>(weight / objective_.NumRays());
    double sum = 0;
    for (int ray = 0; ray < drawn_.tile->num_rays; ++ray) {
      const PriorDepth prior = prior_of(ray);
      if (prior.depth > 0 && !drawn_.IsSparse(ray)) {
        sum += EvaluateDepthLikelihood(prior,
                                       ray_weight,
                                       objective_.length_unit_,
                                       outputs,
                                       ray,
                                       gradients);
      }
    }
    return sum;
  }

  const TrainingObjective& objective_;
  int step_ = 0;
  DrawnRays drawn_;  // of the current tile
};

TrainingObjective::TrainingObjective(
    const Scene& scene,
    const SceneFrame& frame,
    const std::vector<int>& train_view_idxs,
    const std::vector<std::vector<int>>& sources,
    const LossOptions& loss_options,
    const TrainingOptions& training_options,
    const bool is_guided)
    : loss_options_(loss_options),
      training_options_(training_options),
      holds_out_views_(train_view_idxs.size() < scene.views.size()),
      num_tiles_((training_options.rays_per_step + kMaxTileRays - 1) /
                 kMaxTileRays),
      length_unit_(static_cast<float>(frame.median_depth)),
      sparse_form_(SparseFormFromName(loss_options.sparse_form)),
      planar_form_(PlanarFormFromName(loss_options.planar_form)),
      views_(scene, frame),
      patch_loss_(
          scene, frame, views_, sources, MakePatchOptions(loss_options)),
      hints_(scene, frame, train_view_idxs, views_, loss_options),
      drawer_(scene,
              train_view_idxs,
              views_,
              hints_,
              loss_options,
              training_options.seed,
              is_guided) {
  if (loss_options.far_weight > 0) {
    for (size_t v = 0; v < scene.views.size(); ++v) {
      blankness_.push_back(MeasureBlankness(views_, static_cast<int>(v)));
    }
  }
}

TrainingObjective::~TrainingObjective() = default;

bool TrainingObjective::IsHeldOut(const int col, const int row) const {
  return !holds_out_views_ && col % kHeldOutStride == kHeldOutStride / 2 &&
         row % kHeldOutStride == kHeldOutStride / 2;
}

std::unique_ptr<TileObjective> TrainingObjective::MakeTileObjective() const {
  return std::make_unique<Tile>(*this);
}

double TrainingObjective::BlankShare() const {
  size_t sum = 0;
  size_t num_pixels = 0;
  for (const std::vector<uint8_t>& blankness : blankness_) {
    sum = std::accumulate(blankness.begin(), blankness.end(), sum);
    num_pixels += blankness.size();
  }
  return static_cast<double>(sum) /
         (255.0 * static_cast<double>(std::max<size_t>(1, num_pixels)));
}

PatchCounts TrainingObjective::CountPatches() const {
  return {num_drawn_patches_, num_compared_patches_};
}

float TrainingObjective::SparseWeight(const int step) const {
  const bool is_on =
      step < loss_options_.sparse_fraction * training_options_.num_steps;
  return is_on && !hints_.SparseRays().empty()
             ? static_cast<float>(loss_options_.sparse_weight)
             : 0.0f;
}

float TrainingObjective::PriorWeight(const int step) const {
  const double end = loss_options_.prior_fraction * training_options_.num_steps;
  return step < end ? static_cast<float>(loss_options_.prior_weight *
                                         (1.0 - step / end))
                    : 0.0f;
}

}  // namespace structnerf
