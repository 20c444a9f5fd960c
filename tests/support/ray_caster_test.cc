#include "tests/support/ray_caster.h"

#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace structnerf::room {
namespace {

using Eigen::Vector3d;

Primitive MakePrimitive(const Primitive::Shape shape,
                        const Vector3d& center,
                        const Vector3d& half_size) {
  Primitive primitive;
  primitive.shape = shape;
  primitive.center = center;
  primitive.half_size = half_size;
  return primitive;
}

SurfacePoint HitOrFail(const Primitive& primitive, const Ray& ray) {
  Hit hit;
  EXPECT_TRUE(RayCaster({primitive}).Cast(ray, &hit));
  return hit.surface;
}

bool Misses(const Primitive& primitive, const Ray& ray) {
  Hit hit;
  return !RayCaster({primitive}).Cast(ray, &hit);
}

TEST(RayCaster, Rectangle) {
  Primitive rectangle = MakePrimitive(
      Primitive::Shape::kRectangle, Vector3d(1, 2, 3), Vector3d(2, 1, 0));
  // Its normal turns from z to -x.
  rectangle.room_from_local =
      Eigen::AngleAxisd(-M_PI / 2, Vector3d::UnitY()).toRotationMatrix();

  const SurfacePoint front =
      HitOrFail(rectangle, {Vector3d(-3, 2.5, 4), Vector3d(2, 0, 0)});
  EXPECT_NEAR(front.t, 2, 1e-12);
  EXPECT_TRUE(front.normal.isApprox(Vector3d(-1, 0, 0)));
  EXPECT_NEAR(front.local.y(), 0.5, 1e-12);
  const SurfacePoint back =
      HitOrFail(rectangle, {Vector3d(5, 2, 3), Vector3d(-1, 0, 0)});
  EXPECT_NEAR(back.t, 4, 1e-12);
  EXPECT_TRUE(back.normal.isApprox(Vector3d(1, 0, 0)));
  EXPECT_TRUE(Misses(rectangle, {Vector3d(-3, 3.01, 3), Vector3d(1, 0, 0)}));
  EXPECT_TRUE(Misses(rectangle, {Vector3d(2, 2, 3), Vector3d(1, 0, 0)}));
  EXPECT_TRUE(Misses(rectangle, {Vector3d(0, 2, 3), Vector3d(0, 1, 0)}));
}

TEST(RayCaster, TurnedBox) {
  Primitive box = MakePrimitive(
      Primitive::Shape::kBox, Vector3d(0, 5, 0), Vector3d(1, 1, 2));
  box.room_from_local =
      Eigen::AngleAxisd(M_PI / 4, Vector3d::UnitZ()).toRotationMatrix();
  // Just beside the edge that looks at the viewer.
  const SurfacePoint hit =
      HitOrFail(box, {Vector3d(0.1, 0, 0.5), Vector3d(0, 1, 0)});
  EXPECT_NEAR(hit.t, 5 - std::sqrt(2.0) + 0.1, 1e-12);
  EXPECT_TRUE(hit.normal.isApprox(Vector3d(1, -1, 0).normalized()));
  EXPECT_TRUE(Misses(box, {Vector3d(1.42, 0, 0), Vector3d(0, 1, 0)}));
  EXPECT_TRUE(Misses(box, {Vector3d(0, 0, 2.01), Vector3d(0, 1, 0)}));
}

TEST(RayCaster, Sphere) {
  const Primitive sphere = MakePrimitive(
      Primitive::Shape::kSphere, Vector3d(0, 0, 10), Vector3d(2, 0, 0));
  // The legs of a 3-4-5 triangle, scaled: sqrt(2^2 - 1.2^2) = 1.6.
  const SurfacePoint hit =
      HitOrFail(sphere, {Vector3d(1.2, 0, 0), Vector3d(0, 0, 4)});
  EXPECT_NEAR(hit.t, (10 - 1.6) / 4, 1e-12);
  EXPECT_TRUE(hit.normal.isApprox(Vector3d(0.6, 0, -0.8)));
  EXPECT_TRUE(Misses(sphere, {Vector3d(2.01, 0, 0), Vector3d(0, 0, 1)}));
  EXPECT_TRUE(Misses(sphere, {Vector3d(0, 0, 13), Vector3d(0, 0, 1)}));
}

TEST(RayCaster, CylinderSideAndCaps) {
  const Primitive cylinder = MakePrimitive(
      Primitive::Shape::kCylinder, Vector3d(0, 0, 1), Vector3d(0.5, 0.5, 1));
  const SurfacePoint side =
      HitOrFail(cylinder, {Vector3d(-3, 0.3, 1.5), Vector3d(1, 0, 0)});
  EXPECT_NEAR(side.t, 3 - 0.4, 1e-12);
  EXPECT_TRUE(side.normal.isApprox(Vector3d(-0.8, 0.6, 0)));
  const SurfacePoint top =
      HitOrFail(cylinder, {Vector3d(0.4, 0, 5), Vector3d(0, 0, -1)});
  EXPECT_NEAR(top.t, 3, 1e-12);
  EXPECT_TRUE(top.normal.isApprox(Vector3d(0, 0, 1)));
  // Passes the side's infinite extension above the top, then meets the top.
  const SurfacePoint slanted =
      HitOrFail(cylinder, {Vector3d(-1, 0, 3), Vector3d(1, 0, -1)});
  EXPECT_NEAR(slanted.t, 1, 1e-12);
  EXPECT_TRUE(slanted.normal.isApprox(Vector3d(0, 0, 1)));
  EXPECT_TRUE(Misses(cylinder, {Vector3d(-3, 0, 2.1), Vector3d(1, 0, 0)}));
}

TEST(RayCaster, IsOccludedIgnoresBothEnds) {
  const RayCaster caster({MakePrimitive(
      Primitive::Shape::kRectangle, Vector3d::Zero(), Vector3d(1, 1, 0))});
  const Vector3d above(0, 0, 1);
  EXPECT_TRUE(caster.IsOccluded(above, Vector3d(0, 0, -1), 1e-3));
  EXPECT_FALSE(caster.IsOccluded(above, Vector3d(0, 0, 0), 1e-3));
  EXPECT_FALSE(caster.IsOccluded(Vector3d(0, 0, 0), above, 1e-3));
  EXPECT_FALSE(caster.IsOccluded(above, Vector3d(3, 0, -1), 1e-3));
}

TEST(RayCaster, NeedsAPrimitive) {
  EXPECT_THROW(RayCaster({}), std::invalid_argument);
}

// The tree of boxes finds what testing every primitive finds.
TEST(RayCaster, AgreesWithTestingAllPrimitives) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&](const double scale) {
    const double x = uniform(random);
    const double y = uniform(random);
    return Vector3d(scale * Vector3d(x, y, uniform(random)));
  };
  std::vector<Primitive> primitives;
  for (int i = 0; i < 120; ++i) {
    Primitive primitive =
        MakePrimitive(static_cast<Primitive::Shape>(i % 4),
                      vector(5),
                      vector(1.2).cwiseAbs() + Vector3d::Constant(0.01));
    const Vector3d turn = vector(3);
    primitive.room_from_local =
        Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    primitives.push_back(primitive);
  }
  const RayCaster caster(primitives);
  int num_hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const Ray ray{vector(6), vector(1)};
    int expected = -1;
    double nearest = std::numeric_limits<double>::infinity();
    for (size_t j = 0; j < primitives.size(); ++j) {
      SurfacePoint candidate;
      if (Intersect(primitives[j], ray, 1e-9, nearest, &candidate)) {
        nearest = candidate.t;
        expected = static_cast<int>(j);
      }
    }
    Hit hit;
    EXPECT_EQ(caster.Cast(ray, &hit), expected >= 0);
    EXPECT_EQ(hit.primitive_idx, expected);
    num_hits += expected >= 0;
  }
  EXPECT_GT(num_hits, 500);
}

// The light map relies on (u, v) meaning the same in both directions.
TEST(Primitive, FacePointsAreHitAtTheirCoordinates) {
  for (int shape = 0; shape < 4; ++shape) {
    Primitive primitive = MakePrimitive(static_cast<Primitive::Shape>(shape),
                                        Vector3d(0.3, -0.2, 0.7),
                                        Vector3d(0.4, 0.4, 0.6));
    primitive.room_from_local =
        Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized())
            .toRotationMatrix();
    for (int face = 0; face < NumFaces(primitive); ++face) {
      const Eigen::Vector2d uv(0.35, 0.6);
      Vector3d position;
      Vector3d normal;
      FacePoint(primitive, face, uv, &position, &normal);
      const SurfacePoint hit =
          HitOrFail(primitive, {position + 2 * normal, -normal});
      EXPECT_NEAR(hit.t, 2, 1e-9);
      EXPECT_EQ(hit.face, face);
      EXPECT_TRUE(hit.uv.isApprox(uv, 1e-9)) << shape << " " << face;
      EXPECT_TRUE(hit.normal.isApprox(normal, 1e-9));
    }
  }
}

}  // namespace
}  // namespace structnerf::room
