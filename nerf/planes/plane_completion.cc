#include "nerf/planes/plane_completion.h"

#include "nerf/planes/dominant_direction.h"
#include "nerf/planes/view_projection.h"
#include "nerf/stereo/depth_refinement.h"
#include "nerf/util/random.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace structnerf {
namespace {

// Matches are distinct if they are that much worse a little nearer or farther
// (PlaneMaps::distinctness), and reliable if so many source views have the same
// depth within this relative difference.
constexpr float kMinDistinctness = 0.2f;
constexpr int kMinConfirmations = 2;
constexpr float kConfirmTolerance = 0.01f;

// Normals kept of each view, and the least share that must face the dominant
// direction for level and upright to mean something.
constexpr int kNormalsPerView = 2000;
constexpr float kMinDominantShare = 0.05f;

// Calls body(view_idx) for all views; may pause or throw Aborted in
// between.
template <typename Body>
void ForEachView(const size_t num_views,
                 ThreadPool* pool,
                 Progress* progress,
                 const Body& body) {
  const size_t batch = pool->NumThreads();
  for (size_t begin = 0; begin < num_views; begin += batch) {
    PauseOrAbort(progress);
    pool->ParallelFor(std::min(batch, num_views - begin),
                      [&](const size_t item, int) { body(begin + item); });
  }
}

}  // namespace

PlaneCompletion::PlaneCompletion(const Scene& scene,
                                 const SceneFrame& frame,
                                 const TrainingViews& views,
                                 const std::vector<int>& voter_idxs,
                                 const std::vector<std::vector<int>>& sources,
                                 const int window_radius)
    : scene_(scene),
      frame_(frame),
      views_(views),
      voter_idxs_(voter_idxs),
      sources_(sources),
      border_(window_radius + 1),
      plane_views_(scene.views.size()) {}

void PlaneCompletion::AddView(const int view_idx,
                              const DenseMaps& maps,
                              ThreadPool* pool) {
  const View& view = scene_.views[view_idx];
  const PlaneMaps planes =
      PlanesOfMaps(view, frame_, views_.image(view_idx), pool, maps);
  PlaneView& plane_view = plane_views_[view_idx];
  plane_view.width = planes.width;
  plane_view.height = planes.height;
  plane_view.camera = view.camera.Resized(planes.width, planes.height);
  plane_view.rho = planes.rho;
  plane_view.segments = view.segments;
  if (!view.segments.empty() && !view.mask.empty()) {
    for (size_t i = 0; i < view.mask.size(); ++i) {
      if (view.mask[i] == 0) {
        plane_view.segments[i] = -1;
      }
    }
  }
  plane_view.is_reliable.assign(planes.rho.size(), 0);
  std::vector<uint32_t> distinct;
  for (int row = 0; row < planes.height; ++row) {
    const size_t map_row =
        (2 * static_cast<size_t>(row) + 1) * maps.height / (2 * planes.height);
    for (int col = 0; col < planes.width; ++col) {
      const size_t map_col =
          (2 * static_cast<size_t>(col) + 1) * maps.width / (2 * planes.width);
      const size_t index = plane_view.Index(col, row);
      if (planes.rho[index] > 0 &&
          maps.distinctness[map_row * maps.width + map_col] >
              kMinDistinctness) {
        plane_view.is_reliable[index] = 1;
        distinct.push_back(static_cast<uint32_t>(index));
      }
    }
  }
  if (std::binary_search(voter_idxs_.begin(), voter_idxs_.end(), view_idx)) {
    SampleNormals(view_idx, planes, distinct);
  }
}

void PlaneCompletion::SampleNormals(const int view_idx,
                                    const PlaneMaps& planes,
                                    const std::vector<uint32_t>& distinct) {
  if (distinct.empty()) {
    return;
  }
  Random random(view_idx);
  const PlaneView& plane_view = plane_views_[view_idx];
  const Eigen::Matrix3f world_from_cam =
      scene_.views[view_idx].cam_from_world_rotation.transpose().cast<float>();
  for (int i = 0; i < kNormalsPerView; ++i) {
    const uint32_t pixel =
        distinct[random.NextBelow(static_cast<uint32_t>(distinct.size()))];
    const Eigen::Vector3f ray =
        plane_view.Ray(static_cast<int>(pixel % planes.width),
                       static_cast<int>(pixel / planes.width));
    // rho = by_x ray_x + by_y ray_y + constant.
    const float by_x =
        planes.rho_x[pixel] * static_cast<float>(plane_view.camera.fx);
    const float by_y =
        planes.rho_y[pixel] * static_cast<float>(plane_view.camera.fy);
    const Eigen::Vector3f normal(
        by_x, by_y, planes.rho[pixel] - by_x * ray.x() - by_y * ray.y());
    if (normal.norm() > 0) {
      normal_samples_.push_back(
          {view_idx, pixel, world_from_cam * normal.normalized()});
    }
  }
}

ViewWarp PlaneCompletion::MakeWarp(const int view_idx,
                                   const int source_idx) const {
  return MakeViewWarp(scene_.views[view_idx],
                      scene_.views[source_idx],
                      views_.image(view_idx),
                      views_.image(source_idx),
                      frame_.scale);
}

std::vector<ViewWarp> PlaneCompletion::MakeWarps(const int view_idx) const {
  std::vector<ViewWarp> warps;
  for (const int source : sources_[view_idx]) {
    warps.push_back(MakeWarp(view_idx, source));
  }
  return warps;
}

void PlaneCompletion::ConfirmReliablePixels(ThreadPool* pool,
                                            Progress* progress) {
  std::vector<std::vector<uint8_t>> confirmed(plane_views_.size());
  ForEachView(plane_views_.size(), pool, progress, [&](const size_t v) {
    const PlaneView& view = plane_views_[v];
    const std::vector<ViewWarp> warps = MakeWarps(static_cast<int>(v));
    confirmed[v] = view.is_reliable;
    for (int row = 0; row < view.height; ++row) {
      for (int col = 0; col < view.width; ++col) {
        const size_t index = view.Index(col, row);
        if (!view.is_reliable[index]) {
          continue;
        }
        int count = 0;
        for (size_t i = 0; i < warps.size(); ++i) {
          const PlaneView& source = plane_views_[sources_[v][i]];
          int source_col;
          int source_row;
          float ratio;
          if (!source.rho.empty() && ProjectPixel(warps[i],
                                                  col,
                                                  row,
                                                  view.rho[index],
                                                  &source_col,
                                                  &source_row,
                                                  &ratio)) {
            const float there =
                source.rho[source.Index(source_col, source_row)];
            count += std::abs(view.rho[index] / ratio - there) <
                     kConfirmTolerance * there;
          }
        }
        confirmed[v][index] = count >= kMinConfirmations;
      }
    }
  });
  for (size_t v = 0; v < plane_views_.size(); ++v) {
    plane_views_[v].is_reliable = std::move(confirmed[v]);
  }
}

void PlaneCompletion::FindPlanes(ThreadPool* pool, Progress* progress) {
  ConfirmReliablePixels(pool, progress);
  std::vector<Eigen::Vector3f> normals;
  for (const NormalSample& sample : normal_samples_) {
    if (plane_views_[sample.view_idx].is_reliable[sample.pixel]) {
      normals.push_back(sample.normal);
    }
  }
  const DominantDirection dominant = FindDominantDirection(normals);
  if (dominant.share < kMinDominantShare) {
    return;
  }
  std::vector<std::vector<std::vector<PlaneHypothesis>>> hypotheses(
      plane_views_.size());
  ForEachView(plane_views_.size(), pool, progress, [&](const size_t v) {
    const int view_idx = static_cast<int>(v);
    if (plane_views_[v].segments.empty()) {
      return;
    }
    hypotheses[v] = FindPlaneHypotheses(
        plane_views_[v],
        border_,
        scene_.views[v].cam_from_world_rotation.cast<float>() *
            dominant.direction,
        view_idx,
        MakeWarps(view_idx),
        sources_[v],
        views_);
  });
  chosen_.resize(plane_views_.size());
  ForEachView(plane_views_.size(), pool, progress, [&](const size_t v) {
    if (!hypotheses[v].empty()) {
      chosen_[v] = ChoosePlanes(static_cast<int>(v), hypotheses);
    }
  });
}

std::vector<ChosenPlane> PlaneCompletion::ChoosePlanes(
    const int view_idx,
    const std::vector<std::vector<std::vector<PlaneHypothesis>>>& hypotheses)
    const {
  PlaneVotes votes(plane_views_[view_idx], hypotheses[view_idx]);
  for (const int other : SelectVoters(view_idx, voter_idxs_, sources_)) {
    if (!hypotheses[other].empty()) {
      votes.Count(
          MakeWarp(view_idx, other), plane_views_[other], hypotheses[other]);
    }
  }
  return votes.Choose();
}

size_t PlaneCompletion::Complete(const int view_idx,
                                 ThreadPool* pool,
                                 DenseMaps* maps) const {
  if (chosen_.empty() || chosen_[view_idx].empty()) {
    return 0;
  }
  const PinholeCamera& camera = scene_.views[view_idx].camera;
  const PlaneView& view = plane_views_[view_idx];
  const std::vector<ChosenPlane>& chosen = chosen_[view_idx];
  const PlaneLattice lattice(view.width, view.height);
  const size_t num_pixels = maps->depth.size();
  std::vector<size_t> num_completed(maps->height, 0);
  pool->ParallelFor(maps->height, [&](const size_t map_row, int) {
    const int row =
        std::min(static_cast<int>(map_row * view.height / maps->height),
                 view.height - 1);
    for (int map_col = 0; map_col < maps->width; ++map_col) {
      const int col =
          std::min(map_col * view.width / maps->width, view.width - 1);
      const size_t pixel = view.Index(col, row);
      const size_t index = map_row * maps->width + map_col;
      const ChosenPlane& choice = chosen[lattice.IndexOfPixel(col, row)];
      if (choice.segment < 0 || choice.segment != view.segments[pixel] ||
          view.is_reliable[pixel] || !(maps->depth[index] > 0)) {
        continue;
      }
      const Eigen::Vector3f ray(
          static_cast<float>((map_col - camera.cx) / camera.fx),
          static_cast<float>((static_cast<double>(map_row) - camera.cy) /
                             camera.fy),
          1.0f);
      const double rho =
          static_cast<double>(choice.plane.InverseDepth(ray)) * frame_.scale;
      if (!(rho > 0)) {
        continue;
      }
      maps->depth[index] = static_cast<float>(1.0 / rho);
      const Eigen::Vector3f normal = -choice.plane.coefficients.normalized();
      for (int i = 0; i < 3; ++i) {
        maps->normal[i * num_pixels + index] = normal[i];
      }
      ++num_completed[map_row];
    }
  });
  size_t sum = 0;
  for (const size_t count : num_completed) {
    sum += count;
  }
  return sum;
}

}  // namespace structnerf
