#include "tests/support/sparse_model.h"

#include "tests/support/feature_tracks.h"
#include "tests/support/image_geometry.h"
#include "tests/support/point_triangulation.h"
#include "tests/support/room_model.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

namespace structnerf::room {
namespace {

class SparseModelBuilder {
 public:
  explicit SparseModelBuilder(SyntheticRoom* room)
      : room_(*room), random_(room->options.seed + 2) {}

  void Build() {
    const FeatureTracks tracks =
        FindFeatureTracks(room_, room_.options.seed + 3);
    std::vector<int> observation_idxs;
    for (const Feature& feature : tracks.features) {
      observation_idxs.push_back(AddObservation(feature.image_idx, feature.xy));
    }
    std::vector<SyntheticPoint> misplaced;
    for (const std::vector<int>& track : tracks.tracks) {
      SyntheticPoint point;
      point.true_xyz = tracks.features[track[0]].xyz;
      point.xyz = point.true_xyz;
      for (const int feature_idx : track) {
        point.track.push_back({tracks.features[feature_idx].image_idx,
                               observation_idxs[feature_idx]});
      }
      const bool is_misplaced =
          room_.options.fault == RoomFault::kWrongPointCluster &&
          IsFaulty(point);
      (is_misplaced ? misplaced : room_.points).push_back(std::move(point));
    }
    for (size_t i = 0; i < room_.points.size(); ++i) {
      ClaimObservations(static_cast<int>(i));
    }
    AddCluster(misplaced);
    AddWrongMatches();
    for (SyntheticPoint& point : room_.points) {
      point.xyz = TriangulatePoint(room_, point);
      point.error = MeanReprojectionError(room_, point);
      point.color = ColorAt(point.track[0]);
    }
  }

 private:
  int AddObservation(const int image_idx, const Eigen::Vector2d& true_xy) {
    const double sigma = room_.options.observation_sigma;
    const double x = true_xy.x() + sigma * normal_(random_);
    const double y = true_xy.y() + sigma * normal_(random_);
    auto& observations = room_.images[image_idx].observations;
    observations.push_back({Eigen::Vector2d(x, y), -1});
    return static_cast<int>(observations.size()) - 1;
  }

  void ClaimObservations(const int point_idx) {
    for (const auto& element : room_.points[point_idx].track) {
      room_.images[element.image_idx]
          .observations[element.observation_idx]
          .point_idx = point_idx;
    }
  }

  bool IsFaulty(const SyntheticPoint& point) const {
    const Eigen::Vector3d center =
        CameraCenter(room_.images[point.track[0].image_idx]);
    Hit hit;
    return room_.model->Caster().Cast({center, point.true_xyz - center},
                                      &hit) &&
           room_.model->IsFaulty(hit);
  }

  // Adds a point on the sight of an observation at `factor` times its true
  // depth, as if the next `num_more` images had been matched wrongly. Does
  // nothing if it lies outside one of them.
  void AddWrongPoint(const SyntheticTrackElement& first,
                     const Eigen::Vector3d& true_xyz,
                     const double factor,
                     const int num_more) {
    const Eigen::Vector3d center = CameraCenter(room_.images[first.image_idx]);
    SyntheticPoint point;
    point.is_wrong = true;
    point.true_xyz = true_xyz;
    point.xyz = center + factor * (true_xyz - center);
    const int end = first.image_idx + num_more + 1;
    if (end > static_cast<int>(room_.images.size())) {
      return;
    }
    for (int i = first.image_idx; i < end; ++i) {
      if (!IsInView(room_, room_.images[i], point.xyz)) {
        return;
      }
    }
    point.track = {first};
    for (int i = first.image_idx + 1; i < end; ++i) {
      const Eigen::Vector2d xy =
          ProjectPoint(room_, room_.images[i], point.xyz);
      point.track.push_back({i, AddObservation(i, xy)});
    }
    room_.points.push_back(std::move(point));
    ClaimObservations(static_cast<int>(room_.points.size()) - 1);
  }

  // The points of a surface come out too near by the same factor, seen from the
  // image that shows most of them and its two successors, as if a repeated
  // pattern had been matched one period off.
  void AddCluster(const std::vector<SyntheticPoint>& points) {
    constexpr double kFactor = 0.8;
    constexpr int kNumMore = 2;
    std::vector<int> counts(room_.images.size(), 0);
    for (const SyntheticPoint& point : points) {
      for (const SyntheticTrackElement& element : point.track) {
        ++counts[element.image_idx];
      }
    }
    const auto last = counts.end() - std::min<int>(kNumMore, counts.size() - 1);
    const int image_idx =
        std::max_element(counts.begin(), last) - counts.begin();
    for (const SyntheticPoint& point : points) {
      for (const SyntheticTrackElement& element : point.track) {
        if (element.image_idx == image_idx) {
          AddWrongPoint(element, point.true_xyz, kFactor, kNumMore);
        }
      }
    }
  }

  // Features that found no match of their own are matched with something else.
  void AddWrongMatches() {
    const double ratio = room_.options.outlier_ratio;
    const size_t num_wanted = std::lround(room_.points.size() / (1 - ratio));
    std::vector<SyntheticTrackElement> unmatched;
    for (size_t i = 0; i < room_.images.size(); ++i) {
      const auto& observations = room_.images[i].observations;
      for (size_t j = 0; j < observations.size(); ++j) {
        if (observations[j].point_idx < 0) {
          unmatched.push_back({static_cast<int>(i), static_cast<int>(j)});
        }
      }
    }
    std::shuffle(unmatched.begin(), unmatched.end(), random_);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (const SyntheticTrackElement& first : unmatched) {
      if (room_.points.size() >= num_wanted) {
        break;
      }
      // 14 to 40 % too near or 16 to 65 % too far.
      const double error = uniform(random_);
      const double factor = std::exp(std::copysign(0.15, error) + 0.35 * error);
      const int num_more = uniform(random_) < 0 ? 1 : 2;
      const Ray ray = RayThrough(
          room_, room_.images[first.image_idx], ObservationOf(room_, first).xy);
      Hit hit;
      if (room_.model->Caster().Cast(ray, &hit)) {
        AddWrongPoint(first,
                      ray.origin + hit.surface.t * ray.direction,
                      factor,
                      num_more);
      }
    }
  }

  std::array<uint8_t, 3> ColorAt(const SyntheticTrackElement& element) const {
    const RgbImage& image = room_.images[element.image_idx].pixels;
    const Eigen::Vector2d& xy = ObservationOf(room_, element).xy;
    const int col = std::clamp(static_cast<int>(xy.x()), 0, image.width - 1);
    const int row = std::clamp(static_cast<int>(xy.y()), 0, image.height - 1);
    const uint8_t* pixel = &image.data[3 * (row * image.width + col)];
    return {pixel[0], pixel[1], pixel[2]};
  }

  SyntheticRoom& room_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

}  // namespace

void AddSparseModel(SyntheticRoom* room) { SparseModelBuilder(room).Build(); }

}  // namespace structnerf::room
