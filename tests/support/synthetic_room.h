#pragma once

#include "nerf/scene.h"
#include "tests/support/synthetic_camera.h"

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace structnerf {

namespace room {
class RoomModel;
}

// What is wrong with a room, each a known weakness of dense reconstruction.
enum class RoomFault {
  kNone,
  // The fronts of the sideboard are black and mirror the room a little.
  kDarkGlossyFront,
  // The last two views, and only they, look at a blank wall.
  kBlankWallTwoViews,
  // The chair's back and seat are thin slats.
  kChairSlats,
  // A blank board that looks like the wall stands 40 cm in front of it.
  kObjectAndWallOneSegment,
  // The second half of the views is exposed 1.6 times longer.
  kExposureJump,
  // All sparse points of a poster agree on a depth that is a fifth too small.
  kWrongPointCluster,
};

// "none", "dark_glossy_front", ...; the other way round, an unknown name throws
// std::invalid_argument that lists them.
const std::vector<std::string>& RoomFaultNames();
RoomFault RoomFaultFromName(const std::string& name);

struct SyntheticRoomOptions {
  // Photographs along one walk through the room.
  int num_views = 20;

  // Size of the first camera's images, in pixels.
  int width = 320;
  int height = 240;

  // Seed of everything random; the same options give the same room.
  int seed = 0;

  // One camera per entry, see SyntheticCamera. Views take them in turn. The
  // second and later ones have other sizes and focal lengths than the first.
  std::vector<std::string> camera_models = {"PINHOLE"};

  // Whether the images lie in the sub-folders "walk_a" and "walk_b" with equal
  // file names in both.
  bool sub_folders = false;

  // Standard deviation of the logarithm of each view's exposure.
  double exposure_sigma = 0.03;

  // Standard deviation of the sensor's noise, in grey levels of 255.
  double noise_sigma = 1.2;

  // Standard deviation of an observation's x and y, in pixels.
  double observation_sigma = 0.5;

  // Share of the sparse points that are wrong matches.
  double outlier_ratio = 0.025;

  // x_in_world = scale * rotation * x_in_room + translation, where the room is
  // in metres and has z upwards.
  double world_scale = 1;
  Eigen::Quaterniond world_rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d world_translation = Eigen::Vector3d::Zero();

  RoomFault fault = RoomFault::kNone;

  // Returns false and says in `error` which field is wrong and what is allowed.
  bool Check(std::string* error) const;
};

// A found feature of an image.
struct SyntheticObservation {
  Eigen::Vector2d xy;
  int point_idx = -1;  // into SyntheticRoom::points; -1 = not triangulated
};

struct SyntheticImage {
  std::string name;  // path below the image folder
  int camera_idx = 0;
  Eigen::Matrix3d cam_from_world_rotation;
  Eigen::Vector3d cam_from_world_translation;
  double exposure = 1;  // factor on the linear light
  RgbImage pixels;
  std::vector<SyntheticObservation> observations;
};

struct SyntheticTrackElement {
  int image_idx = -1;
  int observation_idx = -1;
};

struct SyntheticPoint {
  Eigen::Vector3d xyz;  // world, triangulated from its observations
  std::array<uint8_t, 3> color = {};
  double error = 0;  // mean reprojection error, pixels
  std::vector<SyntheticTrackElement> track;

  // What no reconstruction knows.
  Eigen::Vector3d true_xyz;  // world; where the feature of the first image is
  bool is_wrong = false;     // a wrong match; xyz is far from true_xyz
};

// A furnished room with photographs of it and the sparse model that
// structure-from-motion would make of them.
struct SyntheticRoom {
  SyntheticRoomOptions options;
  std::vector<SyntheticCamera> cameras;
  std::vector<SyntheticImage> images;
  std::vector<SyntheticPoint> points;
  std::shared_ptr<const room::RoomModel> model;
};

// What an image shows at one of its points.
struct RoomHit {
  double depth = 0;        // z in the camera frame, world units
  Eigen::Vector3d normal;  // unit, camera frame, facing the camera
  Eigen::Vector3d xyz;     // world
  std::string object;      // e.g. "table"
  bool is_faulty = false;  // belongs to what the room's fault is about
};

// RoomHit of every pixel. Layout as in DenseMaps.
struct RoomTruth {
  int width = 0;
  int height = 0;
  std::vector<float> depth;
  std::vector<float> normal;
  std::vector<uint8_t> fault_mask;  // 255 = RoomHit::is_faulty
};

// Where the truth of a pixel (col, row) is taken: at the image point (col,
// row), as in DenseMaps, or at the pixel's centre (col + 0.5, row + 0.5).
enum class PixelPoint { kInteger, kCenter };

// Builds the room and takes the photographs on all cores. Throws
// std::invalid_argument if the options are wrong.
SyntheticRoom MakeSyntheticRoom(const SyntheticRoomOptions& options);

// Exact, for every image point and camera model.
RoomHit CastIntoRoom(const SyntheticRoom& room,
                     int image_idx,
                     const Eigen::Vector2d& image_point);
RoomTruth CastTruth(const SyntheticRoom& room,
                    int image_idx,
                    PixelPoint pixel_point);

// The room as the method sees it, without segments and masks. Throws
// std::invalid_argument if a camera is not a PINHOLE.
Scene MakeScene(const SyntheticRoom& room);

}  // namespace structnerf
