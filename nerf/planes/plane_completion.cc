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

// Views agree on a plane within this relative difference; a reliable pixel this
// much behind it has been seen through it.
constexpr float kAgreeTolerance = 0.02f;
constexpr float kThroughTolerance = 0.03f;

// Lattice cells per image width on which planes are chosen, and half the side
// of the window over which votes are summed, in cells.
constexpr int kCellsPerWidth = 160;
constexpr int kVoteRadius = 2;

// Other views that must agree, on average over the window.
constexpr float kMinVotes = 2.0f;

// Planes with this share of the most votes are equally likely by votes alone.
constexpr float kEqualVotes = 0.9f;

}  // namespace

PlaneCompletion::PlaneCompletion(const Scene& scene,
                                 const SceneFrame& frame,
                                 const TrainingViews& views,
                                 const std::vector<std::vector<int>>& sources,
                                 const int window_radius)
    : scene_(scene),
      frame_(frame),
      views_(views),
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
  if (distinct.empty()) {
    return;
  }
  Random random(view_idx);
  const Eigen::Matrix3f world_from_cam =
      view.cam_from_world_rotation.transpose().cast<float>();
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

void PlaneCompletion::ConfirmReliablePixels(ThreadPool* pool) {
  std::vector<std::vector<uint8_t>> confirmed(plane_views_.size());
  pool->ParallelFor(plane_views_.size(), [&](const size_t v, int) {
    const PlaneView& view = plane_views_[v];
    std::vector<ViewWarp> warps;
    for (const int source : sources_[v]) {
      warps.push_back(MakeWarp(static_cast<int>(v), source));
    }
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
          if (ProjectPixel(warps[i],
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

void PlaneCompletion::FindPlanes(ThreadPool* pool) {
  ConfirmReliablePixels(pool);
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
  hypotheses_.resize(plane_views_.size());
  pool->ParallelFor(plane_views_.size(), [&](const size_t v, int) {
    const int view_idx = static_cast<int>(v);
    const View& view = scene_.views[v];
    if (view.segments.empty()) {
      return;
    }
    std::vector<ViewWarp> warps;
    for (const int source : sources_[v]) {
      warps.push_back(MakeWarp(view_idx, source));
    }
    hypotheses_[v] = FindPlaneHypotheses(
        plane_views_[v],
        view.segments,
        border_,
        view.cam_from_world_rotation.cast<float>() * dominant.direction,
        view_idx,
        warps,
        sources_[v],
        views_);
  });
}

// The plane of each lattice cell of a view; support 0 where there is none.
std::vector<PlaneHypothesis> PlaneCompletion::ChoosePlanes(
    const int view_idx) const {
  const PlaneView& view = plane_views_[view_idx];
  const std::vector<int32_t>& labels = scene_.views[view_idx].segments;
  const auto& planes = hypotheses_[view_idx];
  const int step = std::max(1, view.width / kCellsPerWidth);
  const int num_cols = (view.width + step - 1) / step;
  const int num_rows = (view.height + step - 1) / step;
  size_t max_planes = 0;
  for (const auto& segment_planes : planes) {
    max_planes = std::max(max_planes, segment_planes.size());
  }
  std::vector<PlaneHypothesis> chosen(static_cast<size_t>(num_cols) * num_rows);
  if (max_planes == 0) {
    return chosen;
  }

  struct Votes {
    float agree = 0;
    float through = 0;
  };
  std::vector<Votes> votes(chosen.size() * max_planes);
  const auto pixel_of_cell = [&](const int col, const int row) {
    return view.Index(std::min(col * step + step / 2, view.width - 1),
                      std::min(row * step + step / 2, view.height - 1));
  };
  for (size_t other = 0; other < plane_views_.size(); ++other) {
    if (static_cast<int>(other) == view_idx || hypotheses_[other].empty()) {
      continue;
    }
    const PlaneView& source = plane_views_[other];
    const std::vector<int32_t>& source_labels = scene_.views[other].segments;
    const auto& source_planes = hypotheses_[other];
    const ViewWarp warp = MakeWarp(view_idx, static_cast<int>(other));
    for (int row = 0; row < num_rows; ++row) {
      for (int col = 0; col < num_cols; ++col) {
        const size_t pixel = pixel_of_cell(col, row);
        const int32_t label = labels[pixel];
        if (label < 0) {
          continue;
        }
        const int pixel_col = static_cast<int>(pixel % view.width);
        const int pixel_row = static_cast<int>(pixel / view.width);
        const Eigen::Vector3f ray = view.Ray(pixel_col, pixel_row);
        for (size_t k = 0; k < planes[label].size(); ++k) {
          const float rho = planes[label][k].InverseDepth(ray);
          int source_col;
          int source_row;
          float ratio;
          if (!(rho > 0) || !ProjectPixel(warp,
                                          pixel_col,
                                          pixel_row,
                                          rho,
                                          &source_col,
                                          &source_row,
                                          &ratio)) {
            continue;
          }
          Votes& cell =
              votes[(static_cast<size_t>(row) * num_cols + col) * max_planes +
                    k];
          const float expected = rho / ratio;
          const size_t index = source.Index(source_col, source_row);
          const float tolerance = kAgreeTolerance * expected;
          if (source.is_reliable[index]) {
            cell.agree += std::abs(source.rho[index] - expected) < tolerance;
            cell.through +=
                source.rho[index] < expected * (1 - kThroughTolerance);
          } else if (source_labels[index] >= 0) {
            const Eigen::Vector3f source_ray =
                source.Ray(source_col, source_row);
            const auto& there = source_planes[source_labels[index]];
            cell.agree += std::any_of(
                there.begin(), there.end(), [&](const PlaneHypothesis& plane) {
                  return std::abs(plane.InverseDepth(source_ray) - expected) <
                         tolerance;
                });
          }
        }
      }
    }
  }

  for (int row = 0; row < num_rows; ++row) {
    for (int col = 0; col < num_cols; ++col) {
      const int32_t label = labels[pixel_of_cell(col, row)];
      if (label < 0 || planes[label].empty()) {
        continue;
      }
      std::vector<Votes> sums(planes[label].size());
      float count = 0;
      for (int r = std::max(0, row - kVoteRadius);
           r <= std::min(num_rows - 1, row + kVoteRadius);
           ++r) {
        for (int c = std::max(0, col - kVoteRadius);
             c <= std::min(num_cols - 1, col + kVoteRadius);
             ++c) {
          if (labels[pixel_of_cell(c, r)] != label) {
            continue;
          }
          ++count;
          for (size_t k = 0; k < sums.size(); ++k) {
            const Votes& cell =
                votes[(static_cast<size_t>(r) * num_cols + c) * max_planes + k];
            sums[k].agree += cell.agree;
            sums[k].through += cell.through;
          }
        }
      }
      float most = 0;
      for (const Votes& sum : sums) {
        if (sum.agree >= sum.through) {
          most = std::max(most, sum.agree);
        }
      }
      if (most < kMinVotes * count) {
        continue;
      }
      // Planes close to each other get much the same votes, and the one that
      // more reliable pixels lie on is right.
      for (size_t k = 0; k < sums.size(); ++k) {
        PlaneHypothesis& best =
            chosen[static_cast<size_t>(row) * num_cols + col];
        if (sums[k].agree >= sums[k].through &&
            sums[k].agree >= kEqualVotes * most &&
            planes[label][k].support > best.support) {
          best = planes[label][k];
        }
      }
    }
  }
  return chosen;
}

size_t PlaneCompletion::Complete(const int view_idx,
                                 ThreadPool* pool,
                                 DenseMaps* maps) const {
  if (hypotheses_.empty() || hypotheses_[view_idx].empty()) {
    return 0;
  }
  const PinholeCamera& camera = scene_.views[view_idx].camera;
  const PlaneView& view = plane_views_[view_idx];
  const std::vector<int32_t>& labels = scene_.views[view_idx].segments;
  const std::vector<PlaneHypothesis> chosen = ChoosePlanes(view_idx);
  const int step = std::max(1, view.width / kCellsPerWidth);
  const int num_cols = (view.width + step - 1) / step;
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
      if (labels[pixel] < 0 || view.is_reliable[pixel] ||
          !(maps->depth[index] > 0)) {
        continue;
      }
      // A cell speaks for the pixels of its own segment.
      const int cell_col = col / step;
      const int cell_row = row / step;
      const size_t center =
          view.Index(std::min(cell_col * step + step / 2, view.width - 1),
                     std::min(cell_row * step + step / 2, view.height - 1));
      const PlaneHypothesis& plane =
          chosen[static_cast<size_t>(cell_row) * num_cols + cell_col];
      if (!(plane.support > 0) || labels[center] != labels[pixel]) {
        continue;
      }
      const Eigen::Vector3f ray(
          static_cast<float>((map_col - camera.cx) / camera.fx),
          static_cast<float>((static_cast<double>(map_row) - camera.cy) /
                             camera.fy),
          1.0f);
      const double rho =
          static_cast<double>(plane.InverseDepth(ray)) * frame_.scale;
      if (!(rho > 0)) {
        continue;
      }
      maps->depth[index] = static_cast<float>(1.0 / rho);
      const Eigen::Vector3f normal = -plane.coefficients.normalized();
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
