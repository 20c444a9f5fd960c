#include "tests/support/primitive.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace structnerf::room {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Faces of the box are numbered -x, +x, -y, +y, -z, +z. The coordinates of a
// face run along the two other axes in cyclic order.
int BoxFace(const int axis, const bool positive) {
  return 2 * axis + (positive ? 1 : 0);
}

Eigen::Vector2d PlaneUv(const Eigen::Vector3d& local,
                        const Eigen::Vector3d& half_size,
                        const int axis_u,
                        const int axis_v) {
  return Eigen::Vector2d(0.5 + 0.5 * local[axis_u] / half_size[axis_u],
                         0.5 + 0.5 * local[axis_v] / half_size[axis_v]);
}

double Azimuth(const Eigen::Vector3d& local) {
  return 0.5 + std::atan2(local.y(), local.x()) / (2 * M_PI);
}

bool IntersectRectangle(const Primitive& primitive,
                        const Ray& ray,
                        const double min_t,
                        const double max_t,
                        SurfacePoint* hit) {
  if (ray.direction.z() == 0) {
    return false;
  }
  hit->t = -ray.origin.z() / ray.direction.z();
  hit->local = ray.origin + hit->t * ray.direction;
  if (!(hit->t > min_t && hit->t < max_t) ||
      std::abs(hit->local.x()) > primitive.half_size.x() ||
      std::abs(hit->local.y()) > primitive.half_size.y()) {
    return false;
  }
  hit->local.z() = 0;
  hit->normal = Eigen::Vector3d(0, 0, ray.direction.z() < 0 ? 1 : -1);
  hit->face = 0;
  hit->uv = PlaneUv(hit->local, primitive.half_size, 0, 1);
  return true;
}

bool IntersectBox(const Primitive& primitive,
                  const Ray& ray,
                  const double min_t,
                  const double max_t,
                  SurfacePoint* hit) {
  double enter = -kInfinity;
  double leave = kInfinity;
  int enter_axis = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double inverse = 1 / ray.direction[axis];
    double near = (-primitive.half_size[axis] - ray.origin[axis]) * inverse;
    double far = (primitive.half_size[axis] - ray.origin[axis]) * inverse;
    if (near > far) {
      std::swap(near, far);
    }
    if (near > enter) {
      enter = near;
      enter_axis = axis;
    }
    leave = std::min(leave, far);
  }
  if (!(enter <= leave && enter > min_t && enter < max_t)) {
    return false;
  }
  const bool positive = ray.direction[enter_axis] < 0;
  hit->t = enter;
  hit->local = ray.origin + enter * ray.direction;
  hit->local[enter_axis] = positive ? primitive.half_size[enter_axis]
                                    : -primitive.half_size[enter_axis];
  hit->normal = Eigen::Vector3d::Zero();
  hit->normal[enter_axis] = positive ? 1 : -1;
  hit->face = BoxFace(enter_axis, positive);
  hit->uv = PlaneUv(hit->local,
                    primitive.half_size,
                    (enter_axis + 1) % 3,
                    (enter_axis + 2) % 3);
  return true;
}

// Smaller root of a t^2 + 2 b t + c; false if there is no real one.
bool FirstRoot(const double a, const double b, const double c, double* t) {
  const double discriminant = b * b - a * c;
  if (a == 0 || discriminant < 0) {
    return false;
  }
  *t = (-b - std::sqrt(discriminant)) / a;
  return true;
}

bool IntersectSphere(const Primitive& primitive,
                     const Ray& ray,
                     const double min_t,
                     const double max_t,
                     SurfacePoint* hit) {
  const double radius = primitive.half_size.x();
  if (!FirstRoot(ray.direction.squaredNorm(),
                 ray.origin.dot(ray.direction),
                 ray.origin.squaredNorm() - radius * radius,
                 &hit->t) ||
      !(hit->t > min_t && hit->t < max_t)) {
    return false;
  }
  hit->local = ray.origin + hit->t * ray.direction;
  hit->normal = hit->local / radius;
  hit->face = 0;
  hit->uv =
      Eigen::Vector2d(Azimuth(hit->local),
                      std::acos(std::clamp(hit->normal.z(), -1.0, 1.0)) / M_PI);
  return true;
}

bool IntersectCylinder(const Primitive& primitive,
                       const Ray& ray,
                       const double min_t,
                       const double max_t,
                       SurfacePoint* hit) {
  const double radius = primitive.half_size.x();
  const double half_height = primitive.half_size.z();
  const Eigen::Vector2d o = ray.origin.head<2>();
  const Eigen::Vector2d d = ray.direction.head<2>();
  if (FirstRoot(d.squaredNorm(),
                o.dot(d),
                o.squaredNorm() - radius * radius,
                &hit->t) &&
      hit->t > min_t && hit->t < max_t) {
    hit->local = ray.origin + hit->t * ray.direction;
    if (std::abs(hit->local.z()) <= half_height) {
      hit->normal = Eigen::Vector3d(hit->local.x(), hit->local.y(), 0) / radius;
      hit->face = 0;
      hit->uv = Eigen::Vector2d(Azimuth(hit->local),
                                0.5 + 0.5 * hit->local.z() / half_height);
      return true;
    }
  }
  if (ray.direction.z() == 0) {
    return false;
  }
  const double side = ray.direction.z() < 0 ? 1 : -1;
  hit->t = (side * half_height - ray.origin.z()) / ray.direction.z();
  hit->local = ray.origin + hit->t * ray.direction;
  if (!(hit->t > min_t && hit->t < max_t) ||
      hit->local.head<2>().squaredNorm() > radius * radius) {
    return false;
  }
  hit->normal = Eigen::Vector3d(0, 0, side);
  hit->face = side > 0 ? 1 : 2;
  hit->uv = 0.5 * (Eigen::Vector2d::Ones() + hit->local.head<2>() / radius);
  return true;
}

}  // namespace

bool Intersect(const Primitive& primitive,
               const Ray& ray,
               const double min_t,
               const double max_t,
               SurfacePoint* hit) {
  const Ray local{
      primitive.room_from_local.transpose() * (ray.origin - primitive.center),
      primitive.room_from_local.transpose() * ray.direction};
  bool is_hit = false;
  switch (primitive.shape) {
    case Primitive::Shape::kRectangle:
      is_hit = IntersectRectangle(primitive, local, min_t, max_t, hit);
      break;
    case Primitive::Shape::kBox:
      is_hit = IntersectBox(primitive, local, min_t, max_t, hit);
      break;
    case Primitive::Shape::kSphere:
      is_hit = IntersectSphere(primitive, local, min_t, max_t, hit);
      break;
    case Primitive::Shape::kCylinder:
      is_hit = IntersectCylinder(primitive, local, min_t, max_t, hit);
      break;
  }
  if (is_hit) {
    hit->normal = primitive.room_from_local * hit->normal;
  }
  return is_hit;
}

int NumFaces(const Primitive& primitive) {
  switch (primitive.shape) {
    case Primitive::Shape::kBox:
      return 6;
    case Primitive::Shape::kCylinder:
      return 3;
    default:
      return 1;
  }
}

Eigen::Vector2d FaceSize(const Primitive& primitive, const int face) {
  const Eigen::Vector3d& half = primitive.half_size;
  switch (primitive.shape) {
    case Primitive::Shape::kRectangle:
      return 2 * half.head<2>();
    case Primitive::Shape::kBox:
      return 2 * Eigen::Vector2d(half[(face / 2 + 1) % 3],
                                 half[(face / 2 + 2) % 3]);
    case Primitive::Shape::kSphere:
      return M_PI * Eigen::Vector2d(2 * half.x(), half.x());
    case Primitive::Shape::kCylinder:
      return face == 0 ? Eigen::Vector2d(2 * M_PI * half.x(), 2 * half.z())
                       : Eigen::Vector2d(2 * half.x(), 2 * half.x());
  }
  return Eigen::Vector2d::Zero();
}

void FacePoint(const Primitive& primitive,
               const int face,
               const Eigen::Vector2d& uv,
               Eigen::Vector3d* position,
               Eigen::Vector3d* normal) {
  const Eigen::Vector3d& half = primitive.half_size;
  const Eigen::Vector2d centered = 2 * uv - Eigen::Vector2d::Ones();
  const double azimuth = M_PI * centered.x();
  Eigen::Vector3d local = Eigen::Vector3d::Zero();
  Eigen::Vector3d local_normal = Eigen::Vector3d::UnitZ();
  if (primitive.shape == Primitive::Shape::kRectangle) {
    local.head<2>() = centered.cwiseProduct(half.head<2>());
  } else if (primitive.shape == Primitive::Shape::kBox) {
    const int axis = face / 2;
    const int axis_u = (axis + 1) % 3;
    const int axis_v = (axis + 2) % 3;
    const double side = face % 2 == 1 ? 1 : -1;
    local[axis] = side * half[axis];
    local[axis_u] = centered.x() * half[axis_u];
    local[axis_v] = centered.y() * half[axis_v];
    local_normal = side * Eigen::Vector3d::Unit(axis);
  } else if (primitive.shape == Primitive::Shape::kSphere) {
    const double polar = M_PI * uv.y();
    local_normal = Eigen::Vector3d(std::sin(polar) * std::cos(azimuth),
                                   std::sin(polar) * std::sin(azimuth),
                                   std::cos(polar));
    local = half.x() * local_normal;
  } else if (face == 0) {
    local_normal = Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0);
    local = half.x() * local_normal;
    local.z() = centered.y() * half.z();
  } else {
    const double side = face == 1 ? 1 : -1;
    local = half.x() * Eigen::Vector3d(centered.x(), centered.y(), 0);
    local.z() = side * half.z();
    local_normal = side * Eigen::Vector3d::UnitZ();
  }
  *position = primitive.center + primitive.room_from_local * local;
  *normal = primitive.room_from_local * local_normal;
}

void BoundingBox(const Primitive& primitive,
                 Eigen::Vector3d* min_corner,
                 Eigen::Vector3d* max_corner) {
  Eigen::Vector3d half = primitive.half_size;
  if (primitive.shape == Primitive::Shape::kRectangle) {
    half.z() = 0;
  } else if (primitive.shape == Primitive::Shape::kSphere) {
    half = Eigen::Vector3d::Constant(half.x());
  } else if (primitive.shape == Primitive::Shape::kCylinder) {
    half.y() = half.x();
  }
  // Rounding must not push a flat rectangle out of its box.
  const Eigen::Vector3d extent =
      (primitive.room_from_local.cwiseAbs() * half).array() + 1e-6;
  *min_corner = primitive.center - extent;
  *max_corner = primitive.center + extent;
}

}  // namespace structnerf::room
