#include "tests/support/image_geometry.h"
#include "tests/support/parallel_for.h"
#include "tests/support/room_model.h"
#include "tests/support/synthetic_room.h"

#include <stdexcept>
#include <string>

namespace structnerf {
namespace {

// A ray through an image point, in the room's frame, with t = z-depth in
// metres.
room::Ray RayInRoom(const SyntheticRoom& room,
                    const SyntheticImage& image,
                    const Eigen::Vector2d& image_point) {
  const SyntheticRoomOptions& options = room.options;
  const Eigen::Matrix3d room_from_world =
      options.world_rotation.toRotationMatrix().transpose();
  const room::Ray ray = room::RayThrough(room, image, image_point);
  return {room_from_world * (ray.origin - options.world_translation) /
              options.world_scale,
          room_from_world * ray.direction};
}

}  // namespace

RoomHit CastIntoRoom(const SyntheticRoom& room,
                     const int image_idx,
                     const Eigen::Vector2d& image_point) {
  const SyntheticRoomOptions& options = room.options;
  const SyntheticImage& image = room.images[image_idx];
  const room::Ray ray = RayInRoom(room, image, image_point);
  room::Hit hit;
  if (!room.model->Caster().Cast(ray, &hit)) {
    throw std::logic_error("A ray from image " + image.name +
                           " left the closed room.");
  }
  const Eigen::Matrix3d world_from_room =
      options.world_rotation.toRotationMatrix();
  RoomHit result;
  result.depth = options.world_scale * hit.surface.t;
  result.normal =
      image.cam_from_world_rotation * (world_from_room * hit.surface.normal);
  result.xyz =
      options.world_scale *
          (world_from_room * (ray.origin + hit.surface.t * ray.direction)) +
      options.world_translation;
  result.object = room.model->ObjectName(hit);
  result.is_faulty = room.model->IsFaulty(hit);
  return result;
}

RoomTruth CastTruth(const SyntheticRoom& room,
                    const int image_idx,
                    const PixelPoint pixel_point) {
  const SyntheticCamera& camera =
      room.cameras[room.images[image_idx].camera_idx];
  const double offset = pixel_point == PixelPoint::kCenter ? 0.5 : 0.0;
  RoomTruth truth;
  truth.width = camera.width;
  truth.height = camera.height;
  const size_t num_pixels = static_cast<size_t>(camera.width) * camera.height;
  truth.depth.resize(num_pixels);
  truth.normal.resize(3 * num_pixels);
  truth.fault_mask.resize(num_pixels);
  room::ParallelFor(camera.height, [&](const int row) {
    for (int col = 0; col < camera.width; ++col) {
      const RoomHit hit = CastIntoRoom(
          room, image_idx, Eigen::Vector2d(col + offset, row + offset));
      const size_t pixel = static_cast<size_t>(row) * camera.width + col;
      truth.depth[pixel] = static_cast<float>(hit.depth);
      for (int axis = 0; axis < 3; ++axis) {
        truth.normal[axis * num_pixels + pixel] =
            static_cast<float>(hit.normal[axis]);
      }
      truth.fault_mask[pixel] = hit.is_faulty ? 255 : 0;
    }
  });
  return truth;
}

}  // namespace structnerf
