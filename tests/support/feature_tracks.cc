#include "tests/support/feature_tracks.h"

#include "tests/support/corner_detector.h"
#include "tests/support/image_geometry.h"
#include "tests/support/parallel_for.h"
#include "tests/support/room_model.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <Eigen/Geometry>

namespace structnerf::room {
namespace {

// Well above what the sensor's noise reaches on a blank surface.
constexpr double kMinResponse = 4;         // squared grey levels per pixel
constexpr int kCornerRadius = 2;           // pixels
constexpr double kMatchRadius = 2;         // pixels
constexpr double kFlatRadius = 2;          // pixels
constexpr double kMaxRelativeStep = 0.01;  // off the plane, by distance
constexpr double kMatchProbability = 0.9;
constexpr double kMaxViewAngle = 0.7;  // radians, between two sights
constexpr double kMinSlope = 0.25;     // cosine to the surface's normal
constexpr double kMinTriangulationAngle = 0.03;  // radians
constexpr double kOcclusionTolerance = 0.005;    // metres

Eigen::Vector3d HitPosition(const RoomModel& model, const Hit& hit) {
  const Primitive& primitive = model.Caster().Primitives()[hit.primitive_idx];
  return primitive.center + primitive.room_from_local * hit.surface.local;
}

// A corner that several views see in the same place lies on one surface, not
// where an outline crosses something behind.
bool MakeFeature(const SyntheticRoom& room,
                 const int image_idx,
                 const Eigen::Vector2d& xy,
                 Feature* feature) {
  const SyntheticImage& image = room.images[image_idx];
  const RoomModel& model = *room.model;
  Hit hit;
  if (!model.Caster().Cast(RayThrough(room, image, xy), &hit) ||
      !model.IsMatchable(hit)) {
    return false;
  }
  const Eigen::Vector3d center = CameraCenter(image);
  feature->image_idx = image_idx;
  feature->xy = xy;
  feature->xyz = HitPosition(model, hit);
  feature->normal = hit.surface.normal;
  const double max_step = kMaxRelativeStep * (center - feature->xyz).norm();
  for (const double angle : {0.25, 0.75, 1.25, 1.75}) {
    const Eigen::Vector2d offset(std::cos(M_PI * angle),
                                 std::sin(M_PI * angle));
    Hit neighbor;
    if (!model.Caster().Cast(RayThrough(room, image, xy + kFlatRadius * offset),
                             &neighbor) ||
        std::abs(feature->normal.dot(HitPosition(model, neighbor) -
                                     feature->xyz)) > max_step) {
      return false;
    }
  }
  return feature->normal.dot((center - feature->xyz).normalized()) > kMinSlope;
}

double Angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// Image point of `feature` in another image, if the image shows it well enough
// to be recognised.
bool SeesAgain(const SyntheticRoom& room,
               const Feature& feature,
               const int image_idx,
               Eigen::Vector2d* xy) {
  const SyntheticImage& image = room.images[image_idx];
  if (!IsInView(room, image, feature.xyz)) {
    return false;
  }
  *xy = ProjectPoint(room, image, feature.xyz);
  const Eigen::Vector3d center = CameraCenter(image);
  const Eigen::Vector3d sight = center - feature.xyz;
  const Eigen::Vector3d first_sight =
      CameraCenter(room.images[feature.image_idx]) - feature.xyz;
  return feature.normal.dot(sight.normalized()) > kMinSlope &&
         Angle(sight, first_sight) < kMaxViewAngle &&
         !room.model->Caster().IsOccluded(
             center, feature.xyz, kOcclusionTolerance);
}

// Features of one image by position.
class FeatureGrid {
 public:
  FeatureGrid(const SyntheticCamera& camera)
      : width_(camera.width),
        height_(camera.height),
        cells_(width_ * height_, -1) {}

  void Insert(const Eigen::Vector2d& xy, const int feature_idx) {
    cells_[static_cast<int>(xy.y()) * width_ + static_cast<int>(xy.x())] =
        feature_idx;
  }

  // The nearest feature that belongs to no track yet, -1 if there is none.
  int FindFree(const Eigen::Vector2d& xy,
               const std::vector<Feature>& features) const {
    constexpr int kReach = 3;
    const int col = static_cast<int>(xy.x());
    const int row = static_cast<int>(xy.y());
    int best = -1;
    double best_distance = kMatchRadius;
    for (int r = std::max(0, row - kReach);
         r <= std::min(height_ - 1, row + kReach);
         ++r) {
      for (int c = std::max(0, col - kReach);
           c <= std::min(width_ - 1, col + kReach);
           ++c) {
        const int feature_idx = cells_[r * width_ + c];
        if (feature_idx < 0 || features[feature_idx].track_idx >= 0) {
          continue;
        }
        const double distance = (features[feature_idx].xy - xy).norm();
        if (distance < best_distance) {
          best_distance = distance;
          best = feature_idx;
        }
      }
    }
    return best;
  }

 private:
  int width_;
  int height_;
  std::vector<int> cells_;  // by pixel; -1 = no feature
};

bool IsWellConditioned(const SyntheticRoom& room,
                       const std::vector<Feature>& features,
                       const std::vector<int>& track) {
  const Eigen::Vector3d& xyz = features[track[0]].xyz;
  for (size_t i = 0; i < track.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const auto& image_i = room.images[features[track[i]].image_idx];
      const auto& image_j = room.images[features[track[j]].image_idx];
      if (Angle(CameraCenter(image_i) - xyz, CameraCenter(image_j) - xyz) >
          kMinTriangulationAngle) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace

FeatureTracks FindFeatureTracks(const SyntheticRoom& room, const int seed) {
  const int num_images = static_cast<int>(room.images.size());
  std::vector<std::vector<Feature>> features_by_image(num_images);
  ParallelFor(num_images, [&](const int image_idx) {
    const std::vector<Eigen::Vector2d> corners = DetectCorners(
        room.images[image_idx].pixels, kMinResponse, kCornerRadius);
    for (const Eigen::Vector2d& xy : corners) {
      Feature feature;
      if (MakeFeature(room, image_idx, xy, &feature)) {
        features_by_image[image_idx].push_back(feature);
      }
    }
  });

  FeatureTracks result;
  std::vector<Feature>& features = result.features;
  std::vector<FeatureGrid> grids;
  for (int image_idx = 0; image_idx < num_images; ++image_idx) {
    grids.emplace_back(room.cameras[room.images[image_idx].camera_idx]);
    for (const Feature& feature : features_by_image[image_idx]) {
      grids.back().Insert(feature.xy, static_cast<int>(features.size()));
      features.push_back(feature);
    }
  }

  std::mt19937_64 random(seed);
  std::bernoulli_distribution is_matched(kMatchProbability);
  for (size_t i = 0; i < features.size(); ++i) {
    if (features[i].track_idx >= 0) {
      continue;
    }
    std::vector<int> track = {static_cast<int>(i)};
    std::vector<Eigen::Vector2d> image_points = {features[i].xy};
    for (int image_idx = 0; image_idx < num_images; ++image_idx) {
      Eigen::Vector2d xy;
      if (image_idx == features[i].image_idx ||
          !SeesAgain(room, features[i], image_idx, &xy) ||
          !is_matched(random)) {
        continue;
      }
      const int match = grids[image_idx].FindFree(xy, features);
      if (match >= 0) {
        track.push_back(match);
        image_points.push_back(xy);
      }
    }
    if (track.size() < 2 || !IsWellConditioned(room, features, track)) {
      continue;
    }
    for (size_t j = 0; j < track.size(); ++j) {
      features[track[j]].track_idx = static_cast<int>(result.tracks.size());
      features[track[j]].xy = image_points[j];
      features[track[j]].xyz = features[i].xyz;
    }
    result.tracks.push_back(std::move(track));
  }
  return result;
}

}  // namespace structnerf::room
