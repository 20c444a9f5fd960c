#include "nerf/view_selection.h"

#include "nerf/scene_frame.h"
#include "nerf/util/median.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>

namespace structnerf {
namespace {

constexpr double kBestAngle = 5.0 * M_PI / 180.0;
constexpr double kAngleFalloff = 15.0 * M_PI / 180.0;

// Score of a view that shares no point is below that of any that does.
constexpr double kProximityScale = 1e-3;

// Cameras closer together than this share of the typical depth stand in one
// place: not even poses at geo-referenced offsets tell them apart for sure, and
// they say nothing about depth.
constexpr double kMinBaseline = 1e-3;

// Cameras that look further apart than this do not fill up.
constexpr double kMinCosAngle = 0.7;

double AngleWeight(const double angle) {
  if (angle < kBestAngle) {
    const double ratio = angle / kBestAngle;
    return ratio * ratio;
  }
  const double excess = (angle - kBestAngle) / kAngleFalloff;
  return std::exp(-0.5 * excess * excess);
}

// Median depth of the sparse points in their views.
double TypicalDepth(const Scene& scene) {
  std::vector<double> depths;
  for (const SparsePoint& point : scene.points) {
    for (const Observation& observation : point.track) {
      depths.push_back(
          DepthInView(scene.views[observation.view_idx], point.xyz));
    }
  }
  return depths.empty() ? 1.0 : std::max(Median(&depths), 1e-12);
}

std::vector<std::vector<int>> SelectNeighborViews(
    const size_t num_views,
    const std::vector<int>& candidates,
    const int num_sources) {
  std::vector<std::vector<int>> sources(num_views);
  const int num_candidates = static_cast<int>(candidates.size());
  for (int v = 0; v < static_cast<int>(num_views); ++v) {
    const auto [first, last] =
        std::equal_range(candidates.begin(), candidates.end(), v);
    const int before = static_cast<int>(first - candidates.begin()) - 1;
    const int after = static_cast<int>(last - candidates.begin());
    for (int i = 0; i < num_sources / 2; ++i) {
      if (before - i >= 0) {
        sources[v].push_back(candidates[before - i]);
      }
      if (after + i < num_candidates) {
        sources[v].push_back(candidates[after + i]);
      }
    }
  }
  return sources;
}

std::vector<int> ViewIdxsThatAre(const bool held_out,
                                 const size_t num_views,
                                 const int test_every) {
  std::vector<int> view_idxs;
  for (size_t v = 0; v < num_views; ++v) {
    if (IsHeldOut(v, test_every) == held_out) {
      view_idxs.push_back(static_cast<int>(v));
    }
  }
  return view_idxs;
}

}  // namespace

double TriangulationAngle(const Eigen::Vector3d& center1,
                          const Eigen::Vector3d& center2,
                          const Eigen::Vector3d& xyz) {
  const Eigen::Vector3d ray1 = center1 - xyz;
  const Eigen::Vector3d ray2 = center2 - xyz;
  return std::atan2(ray1.cross(ray2).norm(), ray1.dot(ray2));
}

std::vector<std::vector<int>> SelectSourceViews(
    const Scene& scene,
    const int num_sources,
    const std::vector<int>& candidates) {
  const size_t num_views = scene.views.size();
  std::vector<Eigen::Vector3d> centers(num_views);
  for (size_t i = 0; i < num_views; ++i) {
    centers[i] = scene.views[i].ProjectionCenter();
  }

  std::vector<double> scores(num_views * num_views, 0.0);
  for (const SparsePoint& point : scene.points) {
    for (size_t i = 0; i < point.track.size(); ++i) {
      for (size_t j = i + 1; j < point.track.size(); ++j) {
        const int view1 = point.track[i].view_idx;
        const int view2 = point.track[j].view_idx;
        if (view1 == view2) {
          continue;
        }
        const double weight = AngleWeight(
            TriangulationAngle(centers[view1], centers[view2], point.xyz));
        scores[view1 * num_views + view2] += weight;
        scores[view2 * num_views + view1] += weight;
      }
    }
  }

  const double typical_depth = TypicalDepth(scene);
  std::vector<std::vector<int>> sources(num_views);
  for (size_t i = 0; i < num_views; ++i) {
    double* const row = scores.data() + i * num_views;
    for (size_t j = 0; j < num_views; ++j) {
      const double distance = (centers[i] - centers[j]).norm();
      const double cos_angle =
          scene.views[i].cam_from_world_rotation.row(2).dot(
              scene.views[j].cam_from_world_rotation.row(2));
      if (distance < kMinBaseline * typical_depth) {
        row[j] = 0;
      } else if (cos_angle > kMinCosAngle) {
        row[j] +=
            kProximityScale * cos_angle / (1.0 + distance / typical_depth);
      }
    }
    std::vector<int> order = candidates;
    if (candidates.empty()) {
      order.resize(num_views);
      std::iota(order.begin(), order.end(), 0);
    }
    std::stable_sort(order.begin(), order.end(), [&](const int a, const int b) {
      return row[a] > row[b];
    });
    for (const int j : order) {
      if (row[j] <= 0 || static_cast<int>(sources[i].size()) == num_sources) {
        break;
      }
      sources[i].push_back(j);
    }
  }
  return sources;
}

std::vector<std::vector<int>> SelectTrainingSources(
    const std::vector<std::vector<int>>& sources,
    const LossOptions& options,
    const std::vector<int>& train_view_idxs) {
  if (options.source_selection == "neighbors") {
    return SelectNeighborViews(
        sources.size(), train_view_idxs, options.num_sources);
  }
  return sources;
}

bool IsHeldOut(const size_t view_idx, const int test_every) {
  return test_every > 0 && (view_idx + 1) % test_every == 0;
}

std::vector<int> HeldOutViewIdxs(const size_t num_views, const int test_every) {
  return ViewIdxsThatAre(/*held_out=*/true, num_views, test_every);
}

std::vector<int> TrainedViewIdxs(const size_t num_views, const int test_every) {
  return ViewIdxsThatAre(/*held_out=*/false, num_views, test_every);
}

std::vector<Appearance> SelectAppearances(
    const size_t num_views,
    const std::vector<int>& test_view_idxs,
    const std::string& latent_test) {
  std::vector<bool> is_trained(num_views, true);
  for (const int view_idx : test_view_idxs) {
    is_trained.at(view_idx) = false;
  }
  std::vector<Appearance> appearances;
  for (int v = 0; v < static_cast<int>(num_views); ++v) {
    Appearance views = {v, v};
    if (!is_trained[v]) {
      views = kNoAppearance;
      if (latent_test == "neighbors") {
        int before = v - 1;
        while (before >= 0 && !is_trained[before]) {
          --before;
        }
        int after = v + 1;
        while (after < static_cast<int>(num_views) && !is_trained[after]) {
          ++after;
        }
        const bool has_after = after < static_cast<int>(num_views);
        views = {before >= 0 ? before : after, has_after ? after : before};
      }
    }
    appearances.push_back(views);
  }
  return appearances;
}

}  // namespace structnerf
