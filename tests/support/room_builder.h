#pragma once

#include "tests/support/primitive.h"

#include <string>
#include <vector>

#include <Eigen/Core>

namespace structnerf::room {

// Collects primitives, grouped into named objects that stand on the floor.
// Lengths in metres; x east, y north, z up.
class RoomBuilder {
 public:
  // Starts an object. What is added after it is given in the object's frame,
  // whose origin is (x, y, 0) and which is turned by `yaw` radians around z.
  void BeginObject(const std::string& name, double x, double y, double yaw);

  void AddBox(const Eigen::Vector3d& min_corner,
              const Eigen::Vector3d& max_corner,
              const Material& material);

  // Upright, standing on `base`.
  void AddCylinder(const Eigen::Vector3d& base,
                   double radius,
                   double height,
                   const Material& material);

  // Four upright square posts at the corners of a rectangle around the origin.
  void AddLegs(double half_x,
               double half_y,
               double thickness,
               double height,
               const Material& material);

  void AddSphere(const Eigen::Vector3d& center,
                 double radius,
                 const Material& material);

  // A board whose front is at `center` and looks along `normal`; its local axes
  // are right and up in the board and its normal. Without thickness it is a
  // rectangle.
  void AddBoard(const Eigen::Vector3d& center,
                const Eigen::Vector3d& normal,
                const Eigen::Vector3d& up,
                double width,
                double height,
                double thickness,
                const Material& material);

  const std::vector<Primitive>& Primitives() const { return primitives_; }
  const std::vector<std::string>& Objects() const { return objects_; }

 private:
  void Add(Primitive primitive);

  std::vector<Primitive> primitives_;
  std::vector<std::string> objects_;
  Eigen::Matrix3d room_from_object_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d object_origin_ = Eigen::Vector3d::Zero();
};

}  // namespace structnerf::room
