#include "tests/support/image_geometry.h"

namespace structnerf::room {

Eigen::Vector3d CameraCenter(const SyntheticImage& image) {
  return -image.cam_from_world_rotation.transpose() *
         image.cam_from_world_translation;
}

Eigen::Vector3d PointInCamera(const SyntheticImage& image,
                              const Eigen::Vector3d& xyz) {
  return image.cam_from_world_rotation * xyz + image.cam_from_world_translation;
}

Eigen::Vector2d ProjectPoint(const SyntheticRoom& room,
                             const SyntheticImage& image,
                             const Eigen::Vector3d& xyz) {
  return room.cameras[image.camera_idx].Project(PointInCamera(image, xyz));
}

bool IsInView(const SyntheticRoom& room,
              const SyntheticImage& image,
              const Eigen::Vector3d& xyz) {
  constexpr double kMinDepth = 0.1;  // metres
  if (PointInCamera(image, xyz).z() < kMinDepth) {
    return false;
  }
  const SyntheticCamera& camera = room.cameras[image.camera_idx];
  const Eigen::Vector2d xy = ProjectPoint(room, image, xyz);
  return xy.x() > 0 && xy.y() > 0 && xy.x() < camera.width &&
         xy.y() < camera.height;
}

const SyntheticObservation& ObservationOf(
    const SyntheticRoom& room, const SyntheticTrackElement& element) {
  return room.images[element.image_idx].observations[element.observation_idx];
}

Ray RayThrough(const SyntheticRoom& room,
               const SyntheticImage& image,
               const Eigen::Vector2d& image_point) {
  return {CameraCenter(image),
          image.cam_from_world_rotation.transpose() *
              room.cameras[image.camera_idx].Unproject(image_point)};
}

}  // namespace structnerf::room
