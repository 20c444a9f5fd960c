#include "tests/support/room_builder.h"

#include <utility>

#include <Eigen/Geometry>

namespace structnerf::room {

void RoomBuilder::BeginObject(const std::string& name,
                              const double x,
                              const double y,
                              const double yaw) {
  objects_.push_back(name);
  object_origin_ = Eigen::Vector3d(x, y, 0);
  room_from_object_ =
      Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

void RoomBuilder::AddBox(const Eigen::Vector3d& min_corner,
                         const Eigen::Vector3d& max_corner,
                         const Material& material) {
  Primitive box;
  box.shape = Primitive::Shape::kBox;
  box.center = 0.5 * (min_corner + max_corner);
  box.half_size = 0.5 * (max_corner - min_corner);
  box.material = material;
  Add(std::move(box));
}

void RoomBuilder::AddCylinder(const Eigen::Vector3d& base,
                              const double radius,
                              const double height,
                              const Material& material) {
  Primitive cylinder;
  cylinder.shape = Primitive::Shape::kCylinder;
  cylinder.center = base + 0.5 * height * Eigen::Vector3d::UnitZ();
  cylinder.half_size = Eigen::Vector3d(radius, radius, 0.5 * height);
  cylinder.material = material;
  Add(std::move(cylinder));
}

void RoomBuilder::AddLegs(const double half_x,
                          const double half_y,
                          const double thickness,
                          const double height,
                          const Material& material) {
  for (const double x : {-half_x, half_x - thickness}) {
    for (const double y : {-half_y, half_y - thickness}) {
      AddBox(Eigen::Vector3d(x, y, 0),
             Eigen::Vector3d(x + thickness, y + thickness, height),
             material);
    }
  }
}

void RoomBuilder::AddSphere(const Eigen::Vector3d& center,
                            const double radius,
                            const Material& material) {
  Primitive sphere;
  sphere.shape = Primitive::Shape::kSphere;
  sphere.center = center;
  sphere.half_size = Eigen::Vector3d::Constant(radius);
  sphere.material = material;
  Add(std::move(sphere));
}

void RoomBuilder::AddBoard(const Eigen::Vector3d& center,
                           const Eigen::Vector3d& normal,
                           const Eigen::Vector3d& up,
                           const double width,
                           const double height,
                           const double thickness,
                           const Material& material) {
  Primitive board;
  board.shape =
      thickness > 0 ? Primitive::Shape::kBox : Primitive::Shape::kRectangle;
  board.room_from_local.col(2) = normal.normalized();
  board.room_from_local.col(0) = up.cross(normal).normalized();
  board.room_from_local.col(1) =
      board.room_from_local.col(2).cross(board.room_from_local.col(0));
  board.center = center - 0.5 * thickness * board.room_from_local.col(2);
  board.half_size = 0.5 * Eigen::Vector3d(width, height, thickness);
  board.material = material;
  Add(std::move(board));
}

void RoomBuilder::Add(Primitive primitive) {
  primitive.center = object_origin_ + room_from_object_ * primitive.center;
  primitive.room_from_local = room_from_object_ * primitive.room_from_local;
  primitive.object_idx = static_cast<int>(objects_.size()) - 1;
  primitives_.push_back(std::move(primitive));
}

}  // namespace structnerf::room
