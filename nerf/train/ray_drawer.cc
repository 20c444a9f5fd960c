#include "nerf/train/ray_drawer.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <stdexcept>

namespace structnerf {
namespace {

// Draws of four pixels until they span a stable triangle.
constexpr int kMaxPlanarDraws = 4;

}  // namespace

RayDrawer::RayDrawer(const Scene& scene,
                     const std::vector<int>& train_view_idxs,
                     const TrainingViews& views,
                     const SceneHints& hints,
                     const LossOptions& loss_options,
                     const int seed,
                     const bool is_guided)
    : views_(views),
      hints_(hints),
      planar_form_(PlanarFormFromName(loss_options.planar_form)),
      has_planar_groups_(loss_options.planar_weight > 0 &&
                         !hints.Segments().empty()),
      has_keypoint_rays_(loss_options.patch_weight > 0 &&
                         !hints.Keypoints().empty()),
      seed_(seed),
      is_guided_(is_guided) {
  CollectPixels(scene, train_view_idxs);
}

void RayDrawer::Draw(const int step,
                     const int tile,
                     const bool with_sparse,
                     RayTile* rays,
                     DrawnRays* drawn) const {
  drawn->tile = rays;
  rays->num_rays = 0;
  rays->is_guided = is_guided_;
  rays->has_appearance = true;
  // Another substream than the one that jitters samples.
  Random random(~static_cast<uint64_t>(seed_), step, tile);
  drawn->num_planar_groups = 0;
  if (has_planar_groups_) {
    for (int i = 0; i < kNumPlanarGroups; ++i) {
      DrawPlanarGroup(&random, drawn);
    }
  }
  drawn->first_sparse_ray = rays->num_rays;
  if (with_sparse) {
    for (int i = 0; i < kNumSparseRays; ++i) {
      DrawSparseRay(&random, drawn);
    }
  }
  drawn->first_keypoint_ray = rays->num_rays;
  if (has_keypoint_rays_) {
    // Half of what is left, for the patches.
    const int num_keypoint_rays = (kMaxTileRays - rays->num_rays) / 2;
    for (int i = 0; i < num_keypoint_rays; ++i) {
      DrawKeypointRay(&random, drawn);
    }
  }
  drawn->first_random_ray = rays->num_rays;
  while (rays->num_rays < kMaxTileRays) {
    DrawRandomRay(&random, drawn);
  }
}

void RayDrawer::CollectPixels(const Scene& scene,
                              const std::vector<int>& train_view_idxs) {
  size_t num_pixels = 0;
  for (const int view_idx : train_view_idxs) {
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

void RayDrawer::DrawPlanarGroup(Random* random, DrawnRays* drawn) const {
  const std::vector<double>& last = hints_.LastSegmentAreas();
  const size_t i =
      std::upper_bound(
          last.begin(), last.end(), random->NextFloat() * last.back()) -
      last.begin();
  const std::vector<SceneHints::Segment>& segments = hints_.Segments();
  const SceneHints::Segment& segment =
      segments[std::min(i, segments.size() - 1)];
  const int width = views_.image(segment.view_idx).width;
  for (int draw = 0; draw < kMaxPlanarDraws; ++draw) {
    float x[4];
    float y[4];
    for (int k = 0; k < 4; ++k) {
      const uint32_t pixel =
          hints_.SegmentPixels()[segment.first_pixel +
                                 random->NextBelow(static_cast<uint32_t>(
                                     segment.num_pixels))];
      x[k] = static_cast<float>(pixel % width) + 0.5f;
      y[k] = static_cast<float>(pixel / width) + 0.5f;
    }
    // Any four pixels will do for the triple product.
    if (planar_form_ == PlanarForm::kTripleProduct ||
        MakePlanarGroup(
            x, y, &drawn->planar_groups[drawn->num_planar_groups])) {
      ++drawn->num_planar_groups;
      for (int k = 0; k < 4; ++k) {
        AddRay(segment.view_idx, x[k], y[k], drawn);
      }
      return;
    }
  }
}

void RayDrawer::DrawSparseRay(Random* random, DrawnRays* drawn) const {
  const std::vector<SceneHints::SparseRay>& rays = hints_.SparseRays();
  const SceneHints::SparseRay& sparse =
      rays[random->NextBelow(static_cast<uint32_t>(rays.size()))];
  drawn->sparse_target[drawn->tile->num_rays] = sparse.target;
  AddRay(sparse.view_idx, sparse.x, sparse.y, drawn);
}

void RayDrawer::DrawKeypointRay(Random* random, DrawnRays* drawn) const {
  const std::vector<SceneHints::Keypoint>& keypoints = hints_.Keypoints();
  const SceneHints::Keypoint& keypoint =
      keypoints[random->NextBelow(static_cast<uint32_t>(keypoints.size()))];
  AddRay(keypoint.view_idx, keypoint.col + 0.5, keypoint.row + 0.5, drawn);
}

// Every unmasked pixel is as likely as any other.
void RayDrawer::DrawRandomRay(Random* random, DrawnRays* drawn) const {
  const size_t pixel =
      random->NextBelow(static_cast<uint32_t>(pixel_rows_.back().last_pixel));
  const auto row = std::upper_bound(
      pixel_rows_.begin(),
      pixel_rows_.end(),
      pixel,
      [](const size_t p, const PixelRow& r) { return p < r.last_pixel; });
  const size_t first_pixel =
      row == pixel_rows_.begin() ? 0 : std::prev(row)->last_pixel;
  const size_t width = views_.image(row->view_idx).width;
  int col = static_cast<int>(pixel - first_pixel);
  if (row->last_pixel - first_pixel < width) {
    int num_to_skip = col;
    col = 0;
    while (views_.IsMasked(row->view_idx, col, row->row) || num_to_skip-- > 0) {
      ++col;
    }
  }
  AddRay(row->view_idx, col + 0.5, row->row + 0.5, drawn);
}

void RayDrawer::AddRay(const int view_idx,
                       const double x,
                       const double y,
                       DrawnRays* drawn) const {
  RayTile* const rays = drawn->tile;
  const int ray = rays->num_rays++;
  const TrainingViews::Image& image = views_.image(view_idx);
  const int col = std::min(static_cast<int>(x), image.width - 1);
  const int row = std::min(static_cast<int>(y), image.height - 1);
  drawn->view_idx[ray] = view_idx;
  drawn->col[ray] = col;
  drawn->row[ray] = row;
  rays->appearance[0][ray] = view_idx;
  rays->appearance[1][ray] = view_idx;
  views_.geometry(view_idx).SetRay(x, y, ray, rays);
  if (is_guided_) {
    const PriorDepth prior = hints_.DensePrior(view_idx, col, row);
    rays->guide_depth[ray] = prior.depth;
    rays->guide_deviation[ray] = prior.deviation;
  }
}

}  // namespace structnerf
