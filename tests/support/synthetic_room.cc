#include "tests/support/synthetic_room.h"

#include "tests/support/camera_path.h"
#include "tests/support/photographer.h"
#include "tests/support/room_model.h"
#include "tests/support/sparse_model.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <random>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace structnerf {
namespace {

bool Fail(const std::string& message, std::string* error) {
  *error = message;
  return false;
}

SyntheticCamera MakeCamera(const SyntheticRoomOptions& options,
                           const int camera_idx) {
  // Three quarters of the size for every second camera.
  const int quarters = camera_idx % 2 == 0 ? 4 : 3;
  return SyntheticCamera::Make(options.camera_models[camera_idx],
                               options.width * quarters / 4,
                               options.height * quarters / 4,
                               1 + 0.1 * (camera_idx % 3));
}

std::string ImageName(const SyntheticRoomOptions& options,
                      const int image_idx) {
  const int half = (options.num_views + 1) / 2;
  const bool is_second = options.sub_folders && image_idx >= half;
  std::ostringstream name;
  if (options.sub_folders) {
    name << (is_second ? "walk_b/" : "walk_a/");
  }
  name << "frame_" << std::setfill('0') << std::setw(4)
       << (is_second ? image_idx - half : image_idx) << ".png";
  return name.str();
}

std::vector<SyntheticImage> MakeImages(const SyntheticRoomOptions& options) {
  constexpr double kMeanExposure = 1.12;
  constexpr double kExposureJump = 1.6;
  const std::vector<room::CameraPose> poses =
      room::WalkThroughRoom(options.num_views,
                            options.fault == RoomFault::kBlankWallTwoViews,
                            options.seed);
  std::mt19937_64 random(options.seed);
  std::normal_distribution<double> normal;
  std::vector<SyntheticImage> images(options.num_views);
  for (int i = 0; i < options.num_views; ++i) {
    SyntheticImage& image = images[i];
    image.name = ImageName(options, i);
    image.camera_idx = i % static_cast<int>(options.camera_models.size());
    image.cam_from_world_rotation = poses[i].cam_from_room;
    image.cam_from_world_translation =
        -poses[i].cam_from_room * poses[i].center;
    image.exposure =
        kMeanExposure * std::exp(options.exposure_sigma * normal(random));
    if (options.fault == RoomFault::kExposureJump &&
        i >= options.num_views / 2) {
      image.exposure *= kExposureJump;
    }
  }
  return images;
}

void TakePhotographs(SyntheticRoom* room) {
  const SyntheticRoomOptions& options = room->options;
  for (size_t camera_idx = 0; camera_idx < room->cameras.size(); ++camera_idx) {
    const room::Photographer photographer(*room->model,
                                          room->cameras[camera_idx]);
    for (size_t i = 0; i < room->images.size(); ++i) {
      SyntheticImage& image = room->images[i];
      if (image.camera_idx == static_cast<int>(camera_idx)) {
        const Eigen::Matrix3d& rotation = image.cam_from_world_rotation;
        image.pixels = photographer.TakePhotograph(
            {-rotation.transpose() * image.cam_from_world_translation,
             rotation},
            image.exposure,
            options.noise_sigma,
            1000 * options.seed + static_cast<int>(i));
      }
    }
  }
}

// Moves images and points from the room's frame to the world's.
void MoveToWorld(SyntheticRoom* room) {
  const double scale = room->options.world_scale;
  const Eigen::Matrix3d rotation =
      room->options.world_rotation.toRotationMatrix();
  const Eigen::Vector3d& translation = room->options.world_translation;
  for (SyntheticImage& image : room->images) {
    image.cam_from_world_rotation *= rotation.transpose();
    image.cam_from_world_translation =
        scale * image.cam_from_world_translation -
        image.cam_from_world_rotation * translation;
  }
  for (SyntheticPoint& point : room->points) {
    point.xyz = scale * (rotation * point.xyz) + translation;
    point.true_xyz = scale * (rotation * point.true_xyz) + translation;
  }
}

}  // namespace

const std::vector<std::string>& RoomFaultNames() {
  static const std::vector<std::string> names = {"none",
                                                 "dark_glossy_front",
                                                 "blank_wall_two_views",
                                                 "chair_slats",
                                                 "object_and_wall_one_segment",
                                                 "exposure_jump",
                                                 "wrong_point_cluster"};
  return names;
}

RoomFault RoomFaultFromName(const std::string& name) {
  const std::vector<std::string>& names = RoomFaultNames();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    std::string message = "Unknown fault " + name + "; use one of";
    for (const std::string& known : names) {
      message += " " + known;
    }
    throw std::invalid_argument(message + ".");
  }
  return static_cast<RoomFault>(found - names.begin());
}

bool SyntheticRoomOptions::Check(std::string* error) const {
  if (num_views < 4 || num_views > 1000) {
    return Fail("num_views must be 4 to 1000.", error);
  }
  if (width < 32 || width > 4096 || height < 32 || height > 4096) {
    return Fail("width and height must be 32 to 4096.", error);
  }
  if (seed < 0 || seed > 1000000) {
    return Fail("seed must be 0 to 1000000.", error);
  }
  if (camera_models.empty()) {
    return Fail("camera_models must name at least one camera model.", error);
  }
  for (const std::string& model : camera_models) {
    const std::vector<std::string>& known = SyntheticCameraModels();
    if (std::find(known.begin(), known.end(), model) == known.end()) {
      return Fail(
          "camera_models must be among PINHOLE, SIMPLE_RADIAL, OPENCV "
          "and OPENCV_FISHEYE.",
          error);
    }
  }
  if (!(exposure_sigma >= 0 && exposure_sigma <= 1)) {
    return Fail("exposure_sigma must be 0 to 1.", error);
  }
  if (!(noise_sigma >= 0 && noise_sigma <= 100)) {
    return Fail("noise_sigma must be 0 to 100.", error);
  }
  if (!(observation_sigma >= 0 && observation_sigma <= 10)) {
    return Fail("observation_sigma must be 0 to 10.", error);
  }
  if (!(outlier_ratio >= 0 && outlier_ratio <= 0.5)) {
    return Fail("outlier_ratio must be 0 to 0.5.", error);
  }
  if (!(world_scale > 0 && std::isfinite(world_scale))) {
    return Fail("world_scale must be above 0.", error);
  }
  if (!(std::abs(world_rotation.norm() - 1) < 1e-6)) {
    return Fail("world_rotation must be a unit quaternion.", error);
  }
  if (!world_translation.allFinite()) {
    return Fail("world_translation must be finite.", error);
  }
  return true;
}

SyntheticRoom MakeSyntheticRoom(const SyntheticRoomOptions& options) {
  std::string error;
  if (!options.Check(&error)) {
    throw std::invalid_argument("SyntheticRoomOptions: " + error);
  }
  SyntheticRoom room;
  room.options = options;
  room.model = std::make_shared<room::RoomModel>(options.fault, options.seed);
  for (size_t i = 0; i < options.camera_models.size(); ++i) {
    room.cameras.push_back(MakeCamera(options, static_cast<int>(i)));
  }
  room.images = MakeImages(options);
  TakePhotographs(&room);
  room::AddSparseModel(&room);
  MoveToWorld(&room);
  return room;
}

Scene MakeScene(const SyntheticRoom& room) {
  Scene scene;
  for (const SyntheticImage& image : room.images) {
    const SyntheticCamera& camera = room.cameras[image.camera_idx];
    if (camera.model != "PINHOLE") {
      throw std::invalid_argument("Image " + image.name + " has a " +
                                  camera.model +
                                  " camera; a scene needs PINHOLE cameras.");
    }
    View view;
    view.name = image.name;
    view.camera = {camera.width,
                   camera.height,
                   camera.params[0],
                   camera.params[1],
                   camera.params[2],
                   camera.params[3]};
    view.cam_from_world_rotation = image.cam_from_world_rotation;
    view.cam_from_world_translation = image.cam_from_world_translation;
    view.image = image.pixels;
    scene.views.push_back(std::move(view));
  }
  for (const SyntheticPoint& point : room.points) {
    SparsePoint sparse_point;
    sparse_point.xyz = point.xyz;
    sparse_point.error = point.error;
    for (const SyntheticTrackElement& element : point.track) {
      sparse_point.track.push_back({element.image_idx,
                                    room.images[element.image_idx]
                                        .observations[element.observation_idx]
                                        .xy});
    }
    scene.points.push_back(std::move(sparse_point));
  }
  return scene;
}

}  // namespace structnerf
