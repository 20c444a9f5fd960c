#include "nerf/train/training_objective.h"

#include "nerf/losses/far_push.h"
#include "nerf/losses/planar_loss.h"
#include "nerf/util/random.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>

namespace structnerf {
namespace {

// How the rays of a tile are drawn: groups of four planar pixels first, then
// rays through sparse points, the rest through random pixels.
constexpr int kNumPlanarGroups = 2;
constexpr int kNumSparseRays = 4;

// Distance of pixels whose colour is held out.
constexpr int kHeldOutStride = 16;

// Of the push of a blank pixel, by how many other views see what it shows:
// none, one, more. A second view agrees to any depth; but where views are few,
// the push is what holds against sparse points that are too near.
constexpr float kFarShares[] = {0.0f, 0.25f, 1.0f};

// Draws of four pixels until they span a stable triangle.
constexpr int kMaxPlanarDraws = 4;

PatchLoss::Options MakePatchOptions(const LossOptions& options) {
  PatchLoss::Options patch_options;
  patch_options.radius = options.patch_radius;
  patch_options.dilation = options.patch_dilation;
  patch_options.ssim_share = static_cast<float>(options.patch_ssim_share);
  patch_options.num_best = options.num_best_sources;
  return patch_options;
}

}  // namespace

// One thread's tile: which pixels were drawn and what they are compared with.
class TrainingObjective::Tile : public TileObjective {
 public:
  explicit Tile(const TrainingObjective& objective) : objective_(objective) {}

  void DrawRays(const int step, const int tile, RayTile* rays) override {
    step_ = step;
    rays_ = rays;
    rays->num_rays = 0;
    rays->is_guided = objective_.is_guided_;
    rays->has_appearance = true;
    // Another substream than the one that jitters samples.
    Random random(
        ~static_cast<uint64_t>(objective_.training_options_.seed), step, tile);
    num_groups_ = 0;
    if (objective_.loss_options_.planar_weight > 0 &&
        !objective_.hints_.Segments().empty()) {
      for (int i = 0; i < kNumPlanarGroups; ++i) {
        DrawPlanarGroup(&random);
      }
    }
    first_sparse_ray_ = rays->num_rays;
    if (objective_.SparseWeight(step) > 0) {
      for (int i = 0; i < kNumSparseRays; ++i) {
        DrawSparseRay(&random);
      }
    }
    first_random_ray_ = rays->num_rays;
    if (objective_.loss_options_.patch_weight > 0 &&
        !objective_.hints_.Keypoints().empty()) {
      // Half of the random rays, for the patches.
      const int num_keypoint_rays = (kMaxTileRays - rays->num_rays) / 2;
      for (int i = 0; i < num_keypoint_rays; ++i) {
        DrawKeypointRay(&random);
      }
    }
    end_keypoint_ray_ = rays->num_rays;
    while (rays->num_rays < kMaxTileRays) {
      DrawRandomRay(&random);
    }
  }

  LossValues Evaluate(const RayOutputs& outputs,
                      RayGradients* gradients) override {
    LossValues losses = {};
    ComparePatches(outputs);
    AddColorLoss(outputs, gradients, &losses);
    AddPatchLoss(gradients, &losses);
    AddPlanarLoss(outputs, gradients, &losses);
    AddSparseLoss(outputs, gradients, &losses);
    AddPriorLoss(outputs, gradients, &losses);
    AddDensePriorLoss(outputs, gradients, &losses);
    AddFarLoss(outputs, gradients, &losses);
    return losses;
  }

  bool UsesSamples() const override {
    return objective_.sparse_form_ == SparseForm::kRayTermination &&
           first_random_ray_ > first_sparse_ray_;
  }

  LossValues EvaluateSamples(const RaySamples& samples,
                             float* d_weight) override {
    LossValues losses = {};
    for (int ray = first_sparse_ray_; ray < first_random_ray_; ++ray) {
      losses[static_cast<size_t>(LossTerm::kSparse)] +=
          EvaluateRayTermination(WeightedTarget(ray), samples, ray, d_weight);
    }
    return losses;
  }

 private:
  // Every ray goes through a pixel's centre, except those through sparse
  // points.
  void AddRay(const int view_idx, const double x, const double y) {
    const int ray = rays_->num_rays++;
    const TrainingViews::Image& image = objective_.views_.image(view_idx);
    view_idx_[ray] = view_idx;
    col_[ray] = std::min(static_cast<int>(x), image.width - 1);
    row_[ray] = std::min(static_cast<int>(y), image.height - 1);
    rays_->appearance[0][ray] = view_idx;
    rays_->appearance[1][ray] = view_idx;
    objective_.views_.geometry(view_idx).SetRay(x, y, ray, rays_);
    if (objective_.is_guided_) {
      const PriorDepth prior = DensePrior(ray);
      rays_->guide_depth[ray] = prior.depth;
      rays_->guide_deviation[ray] = prior.deviation;
    }
  }

  // Every unmasked pixel is as likely as any other.
  void DrawRandomRay(Random* random) {
    const std::vector<PixelRow>& rows = objective_.pixel_rows_;
    const size_t pixel =
        random->NextBelow(static_cast<uint32_t>(rows.back().last_pixel));
    const auto row = std::upper_bound(
        rows.begin(), rows.end(), pixel, [](const size_t p, const PixelRow& r) {
          return p < r.last_pixel;
        });
    const size_t first_pixel =
        row == rows.begin() ? 0 : std::prev(row)->last_pixel;
    const size_t width = objective_.views_.image(row->view_idx).width;
    int col = static_cast<int>(pixel - first_pixel);
    if (row->last_pixel - first_pixel < width) {
      int num_to_skip = col;
      col = 0;
      while (objective_.views_.IsMasked(row->view_idx, col, row->row) ||
             num_to_skip-- > 0) {
        ++col;
      }
    }
    AddRay(row->view_idx, col + 0.5, row->row + 0.5);
  }

  void DrawSparseRay(Random* random) {
    const std::vector<SceneHints::SparseRay>& rays =
        objective_.hints_.SparseRays();
    const SceneHints::SparseRay& sparse =
        rays[random->NextBelow(static_cast<uint32_t>(rays.size()))];
    sparse_target_[rays_->num_rays] = sparse.target;
    AddRay(sparse.view_idx, sparse.x, sparse.y);
  }

  void DrawKeypointRay(Random* random) {
    const std::vector<SceneHints::Keypoint>& keypoints =
        objective_.hints_.Keypoints();
    const SceneHints::Keypoint& keypoint =
        keypoints[random->NextBelow(static_cast<uint32_t>(keypoints.size()))];
    AddRay(keypoint.view_idx, keypoint.col + 0.5, keypoint.row + 0.5);
  }

  void DrawPlanarGroup(Random* random) {
    const std::vector<double>& last = objective_.hints_.LastSegmentAreas();
    const size_t i =
        std::upper_bound(
            last.begin(), last.end(), random->NextFloat() * last.back()) -
        last.begin();
    const std::vector<SceneHints::Segment>& segments =
        objective_.hints_.Segments();
    const SceneHints::Segment& segment =
        segments[std::min(i, segments.size() - 1)];
    const int width = objective_.views_.image(segment.view_idx).width;
    for (int draw = 0; draw < kMaxPlanarDraws; ++draw) {
      float x[4];
      float y[4];
      for (int k = 0; k < 4; ++k) {
        const uint32_t pixel =
            objective_.hints_
                .SegmentPixels()[segment.first_pixel +
                                 random->NextBelow(static_cast<uint32_t>(
                                     segment.num_pixels))];
        x[k] = static_cast<float>(pixel % width) + 0.5f;
        y[k] = static_cast<float>(pixel / width) + 0.5f;
      }
      // Any four pixels will do for the triple product.
      if (objective_.planar_form_ == PlanarForm::kTripleProduct ||
          MakePlanarGroup(x, y, &groups_[num_groups_])) {
        ++num_groups_;
        for (int k = 0; k < 4; ++k) {
          AddRay(segment.view_idx, x[k], y[k]);
        }
        return;
      }
    }
  }

  void ComparePatches(const RayOutputs& outputs) {
    const LossOptions& options = objective_.loss_options_;
    if (options.patch_weight == 0 && options.far_weight == 0) {
      return;
    }
    objective_.patch_loss_.Evaluate(rays_->num_rays,
                                    view_idx_.data(),
                                    col_.data(),
                                    row_.data(),
                                    outputs.depth.data(),
                                    patch_loss_.data(),
                                    d_patch_loss_.data(),
                                    num_sources_.data());
  }

  void AddColorLoss(const RayOutputs& outputs,
                    RayGradients* gradients,
                    LossValues* losses) const {
    const float weight =
        static_cast<float>(objective_.loss_options_.color_weight) /
        objective_.training_options_.rays_per_step;
    double sum = 0;
    for (int ray = 0; ray < rays_->num_rays; ++ray) {
      if (objective_.IsHeldOut(col_[ray], row_[ray])) {
        continue;
      }
      const Eigen::Vector3f target =
          objective_.views_.Color(view_idx_[ray], col_[ray], row_[ray]);
      const Exposure& exposure = objective_.views_.exposure(view_idx_[ray]);
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

  void AddPatchLoss(RayGradients* gradients, LossValues* losses) const {
    if (objective_.loss_options_.patch_weight == 0) {
      return;
    }
    // All rays, or those through keypoints.
    const bool is_dense = objective_.loss_options_.patch_sampling == "dense";
    const int begin = is_dense ? 0 : first_random_ray_;
    const int end = is_dense ? rays_->num_rays : end_keypoint_ray_;
    if (begin == end) {
      return;  // no image has keypoints
    }
    const float weight =
        static_cast<float>(objective_.loss_options_.patch_weight) /
        (is_dense ? objective_.training_options_.rays_per_step
                  : (end - begin) * objective_.num_tiles_);
    double sum = 0;
    size_t num_compared = 0;
    for (int ray = begin; ray < end; ++ray) {
      if (num_sources_[ray] > 0) {
        sum += patch_loss_[ray];
        gradients->d_depth[ray] += weight * d_patch_loss_[ray];
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
    for (int group = 0; group < num_groups_; ++group) {
      float d_depth[4];
      const float* const depth = outputs.depth.data() + 4 * group;
      sum += objective_.planar_form_ == PlanarForm::kTripleProduct
                 ? TripleProductLoss(4 * group, depth, d_depth)
                 : EvaluatePlanarLoss(groups_[group], depth, d_depth);
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
        directions[k][axis] = per_unit * rays_->direction[axis][first_ray + k];
      }
    }
    return EvaluateTripleProduct(directions, depth, d_depth);
  }

  SparseTarget WeightedTarget(const int ray) const {
    SparseTarget target = sparse_target_[ray];
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
    for (int ray = first_sparse_ray_; ray < first_random_ray_; ++ray) {
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
        objective_.training_options_.rays_per_step;
    double sum = 0;
    for (int ray = 0; ray < rays_->num_rays; ++ray) {
      const float share = kFarShares[std::min(num_sources_[ray], 2)];
      const size_t pixel = static_cast<size_t>(row_[ray]) *
                               objective_.views_.image(view_idx_[ray]).width +
                           col_[ray];
      float d_depth;
      sum +=
          share * EvaluateFarPush(objective_.blankness_[view_idx_[ray]][pixel],
                                  outputs.depth[ray],
                                  &d_depth);
      gradients->d_depth[ray] += weight * share * d_depth;
    }
    (*losses)[static_cast<size_t>(LossTerm::kFar)] += weight * sum;
  }

  // Where no sparse point is, the interpolated depth pulls at the ray.
  void AddPriorLoss(const RayOutputs& outputs,
                    RayGradients* gradients,
                    LossValues* losses) const {
    SparseTarget target;
    target.weight = objective_.PriorWeight(step_) /
                    objective_.training_options_.rays_per_step;
    if (target.weight == 0) {
      return;
    }
    double sum = 0;
    for (int ray = 0; ray < rays_->num_rays; ++ray) {
      target.depth = objective_.hints_.InterpolatedDepth(
          view_idx_[ray], col_[ray], row_[ray]);
      if (!IsSparse(ray) && target.depth > 0) {
        sum += EvaluateLineOfSight(target, outputs, ray, gradients);
      }
    }
    (*losses)[static_cast<size_t>(LossTerm::kPrior)] += sum;
  }

  // Sparse points know better.
  void AddDensePriorLoss(const RayOutputs& outputs,
                         RayGradients* gradients,
                         LossValues* losses) const {
    const float weight =
        static_cast<float>(objective_.loss_options_.dense_prior_weight) /
        objective_.training_options_.rays_per_step;
    if (weight == 0) {
      return;
    }
    double sum = 0;
    for (int ray = 0; ray < rays_->num_rays; ++ray) {
      const PriorDepth prior = DensePrior(ray);
      if (prior.depth > 0 && !IsSparse(ray)) {
        sum += EvaluateDepthLikelihood(
            prior, weight, objective_.length_unit_, outputs, ray, gradients);
      }
    }
    (*losses)[static_cast<size_t>(LossTerm::kDensePrior)] += sum;
  }

  // Whether a ray goes through a sparse point.
  bool IsSparse(const int ray) const {
    return ray >= first_sparse_ray_ && ray < first_random_ray_;
  }

  PriorDepth DensePrior(const int ray) const {
    return objective_.hints_.DensePrior(view_idx_[ray], col_[ray], row_[ray]);
  }

  const TrainingObjective& objective_;
  int step_ = 0;
  RayTile* rays_ = nullptr;  // of the current tile
  PerRay<int> view_idx_;
  PerRay<int> col_;
  PerRay<int> row_;
  int num_groups_ = 0;
  PlanarGroup groups_[kNumPlanarGroups];
  int first_sparse_ray_ = 0;
  int first_random_ray_ = 0;
  int end_keypoint_ray_ = 0;
  PerRay<SparseTarget> sparse_target_;

  // What ComparePatches() says about each ray, see PatchLoss::Evaluate.
  PerRay<float> patch_loss_;
  PerRay<float> d_patch_loss_;
  PerRay<int> num_sources_;
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
      train_view_idxs_(train_view_idxs),
      num_tiles_((training_options.rays_per_step + kMaxTileRays - 1) /
                 kMaxTileRays),
      length_unit_(static_cast<float>(frame.median_depth)),
      is_guided_(is_guided),
      sparse_form_(SparseFormFromName(loss_options.sparse_form)),
      planar_form_(PlanarFormFromName(loss_options.planar_form)),
      views_(scene, frame),
      patch_loss_(
          scene, frame, views_, sources, MakePatchOptions(loss_options)),
      hints_(scene, frame, train_view_idxs, views_, loss_options) {
  CollectPixels(scene);
  if (loss_options.far_weight > 0) {
    for (size_t v = 0; v < scene.views.size(); ++v) {
      blankness_.push_back(MeasureBlankness(views_, static_cast<int>(v)));
    }
  }
}

TrainingObjective::~TrainingObjective() = default;

bool TrainingObjective::IsHeldOut(const int col, const int row) const {
  return training_options_.test_every == 0 &&
         col % kHeldOutStride == kHeldOutStride / 2 &&
         row % kHeldOutStride == kHeldOutStride / 2;
}

std::unique_ptr<TileObjective> TrainingObjective::MakeTileObjective() const {
  return std::make_unique<Tile>(*this);
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

void TrainingObjective::CollectPixels(const Scene& scene) {
  size_t num_pixels = 0;
  for (const int view_idx : train_view_idxs_) {
    const View& view = scene.views[view_idx];
    const int width = view.image.width;
    for (int row = 0; row < view.image.height; ++row) {
      num_pixels += width;
      if (!view.mask.empty()) {
        const auto begin =
            view.mask.begin() + static_cast<ptrdiff_t>(row) * width;
        num_pixels -= std::count(begin, begin + width, 0);
      }
      pixel_rows_.push_back({view_idx, row, num_pixels});
    }
  }
  if (num_pixels == 0) {
    throw std::invalid_argument(
        "the masks leave no pixel to train on; black means ignored");
  }
}

}  // namespace structnerf
