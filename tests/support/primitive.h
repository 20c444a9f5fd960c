#pragma once

#include "tests/support/material.h"

#include <Eigen/Core>

namespace structnerf::room {

// Half-line origin + t * direction, t > 0. The direction need not be unit.
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
};

// A simple solid or surface, seen from outside. Local axes are those of
// `room_from_local` (a rotation), with the origin at `center`.
//   kRectangle  half sizes x, y; at local z = 0, seen from both sides
//   kBox        half sizes x, y, z
//   kSphere     radius half_size.x
//   kCylinder   radius half_size.x, along local z with half height half_size.z,
//               with caps
struct Primitive {
  enum class Shape { kRectangle, kBox, kSphere, kCylinder };

  Shape shape = Shape::kBox;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Matrix3d room_from_local = Eigen::Matrix3d::Identity();
  Eigen::Vector3d half_size = Eigen::Vector3d::Ones();
  Material material;
  int object_idx = 0;  // into RoomModel::objects
};

// Where a ray meets a primitive. Every face of a primitive has coordinates
// (u, v) in [0, 1] x [0, 1].
struct SurfacePoint {
  double t = 0;
  Eigen::Vector3d local;   // position in the local frame
  Eigen::Vector3d normal;  // unit, room frame, against the ray
  int face = 0;
  Eigen::Vector2d uv;
};

// The first hit with t in (min_t, max_t); false if there is none.
bool Intersect(const Primitive& primitive,
               const Ray& ray,
               double min_t,
               double max_t,
               SurfacePoint* hit);

// Rectangle and sphere have one face, the box 6, the cylinder 3.
int NumFaces(const Primitive& primitive);

// Width and height of a face in metres, along u and v.
Eigen::Vector2d FaceSize(const Primitive& primitive, int face);

// Position and outward normal (room frame) at (u, v) of a face.
void FacePoint(const Primitive& primitive,
               int face,
               const Eigen::Vector2d& uv,
               Eigen::Vector3d* position,
               Eigen::Vector3d* normal);

// Corners of the axis-aligned box around a primitive, in the room frame.
void BoundingBox(const Primitive& primitive,
                 Eigen::Vector3d* min_corner,
                 Eigen::Vector3d* max_corner);

}  // namespace structnerf::room
