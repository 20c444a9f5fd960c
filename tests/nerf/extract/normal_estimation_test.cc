#include "nerf/extract/normal_estimation.h"

#include "nerf/extract/map_resolution.h"
#include "tests/nerf/aborting_progress.h"
#include "tests/nerf/plane_scene.h"
#include "tests/nerf/simd_targets.h"

#include <cmath>
#include <functional>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

constexpr int kWidth = 41;
constexpr int kHeight = 31;

PinholeCamera TestCamera() { return {kWidth, kHeight, 45, 50, 19, 17}; }

// Depth maps and nothing else.
DenseMaps MakeMaps(const std::function<double(int col, int row)>& depth) {
  DenseMaps maps;
  maps.width = kWidth;
  maps.height = kHeight;
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 0; col < kWidth; ++col) {
      maps.depth.push_back(static_cast<float>(depth(col, row)));
    }
  }
  return maps;
}

Eigen::Vector3d Normal(const DenseMaps& maps, const int col, const int row) {
  const size_t pixel = static_cast<size_t>(row) * kWidth + col;
  const size_t plane = static_cast<size_t>(kWidth) * kHeight;
  return Eigen::Vector3f(maps.normal[pixel],
                         maps.normal[plane + pixel],
                         maps.normal[2 * plane + pixel])
      .cast<double>();
}

double AngleInDegrees(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / M_PI;
}

Eigen::Vector3d Ray(const int col, const int row) {
  const PinholeCamera camera = TestCamera();
  return {(col - camera.cx) / camera.fx, (row - camera.cy) / camera.fy, 1};
}

void ExpectUnitAndFacing(const DenseMaps& maps) {
  ASSERT_EQ(maps.normal.size(), 3 * maps.depth.size());
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 0; col < kWidth; ++col) {
      const Eigen::Vector3d normal = Normal(maps, col, row);
      if (maps.depth[row * kWidth + col] > 0) {
        ASSERT_NEAR(normal.norm(), 1, 1e-5) << col << " " << row;
        ASSERT_LT(normal.dot(Ray(col, row)), 0) << col << " " << row;
      } else {
        ASSERT_EQ(normal.norm(), 0) << col << " " << row;
      }
    }
  }
}

class EstimateNormalsTest : public SimdTargetTest {};

// The plane n . X = -distance seen by the camera at the origin.
double PlaneDepth(const Eigen::Vector3d& normal,
                  const double distance,
                  const int col,
                  const int row) {
  return -distance / normal.dot(Ray(col, row));
}

TEST_P(EstimateNormalsTest, PlanesAtAnyScale) {
  const std::vector<Eigen::Vector3d> normals = {{0, 0, -1},
                                                {0.5, 0, -1},
                                                {0, -0.7, -1},
                                                {-0.4, 0.8, -1},
                                                {-0.8, 0.3, -0.9}};
  for (const double scale : {1e-6, 1.0, 1e6}) {
    for (const Eigen::Vector3d& direction : normals) {
      const Eigen::Vector3d normal = direction.normalized();
      DenseMaps maps = MakeMaps([&](const int col, const int row) {
        return PlaneDepth(normal, 3 * scale, col, row);
      });
      EstimateNormals(TestCamera(), &maps);
      ExpectUnitAndFacing(maps);
      for (int row = 0; row < kHeight; ++row) {
        for (int col = 0; col < kWidth; ++col) {
          ASSERT_LT(AngleInDegrees(Normal(maps, col, row), normal), 1)
              << "normal " << normal.transpose() << " at " << col << " " << row;
        }
      }
    }
  }
}

// A floor seen from 1.5 m above, five to nine metres away: neighbouring rows
// differ by up to 2.5 % in depth although they are one plane.
TEST_P(EstimateNormalsTest, GrazingPlane) {
  const PinholeCamera camera{kWidth, kHeight, 250, 250, 20, -40};
  const Eigen::Vector3d normal = Eigen::Vector3d(0.05, -1, 0).normalized();
  DenseMaps maps = MakeMaps([&](const int col, const int row) {
    const Eigen::Vector3d ray(
        (col - camera.cx) / camera.fx, (row - camera.cy) / camera.fy, 1);
    return -1.5 / normal.dot(ray);
  });
  EstimateNormals(camera, &maps);
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 0; col < kWidth; ++col) {
      EXPECT_LT(AngleInDegrees(Normal(maps, col, row), normal), 1.0)
          << col << " " << row;
    }
  }
}

// Two walls with a gap of a fifth in depth: each keeps its normal up to the
// edge.
TEST_P(EstimateNormalsTest, StepEdgesStaySharp) {
  const Eigen::Vector3d left = Eigen::Vector3d(0.3, 0.1, -1).normalized();
  const Eigen::Vector3d right = Eigen::Vector3d(-0.4, 0.2, -1).normalized();
  const double left_distance = -3 * left.dot(Ray(20, 15));
  const double right_distance = -3.6 * right.dot(Ray(21, 15));
  DenseMaps maps = MakeMaps([&](const int col, const int row) {
    return col <= 20 ? PlaneDepth(left, left_distance, col, row)
                     : PlaneDepth(right, right_distance, col, row);
  });
  EstimateNormals(TestCamera(), &maps);
  ExpectUnitAndFacing(maps);
  for (int row = 10; row < 20; ++row) {
    for (int col = 0; col < kWidth; ++col) {
      EXPECT_LT(
          AngleInDegrees(Normal(maps, col, row), col <= 20 ? left : right), 3)
          << col << " " << row;
    }
  }
}

TEST_P(EstimateNormalsTest, IsolatedPixelFacesTheCamera) {
  DenseMaps maps = MakeMaps([](const int col, const int row) {
    return col == 30 && row == 5 ? 2.0 : 0.0;
  });
  EstimateNormals(TestCamera(), &maps);
  ExpectUnitAndFacing(maps);
  EXPECT_LT(AngleInDegrees(Normal(maps, 30, 5), {0, 0, -1}), 20);
}

TEST_P(EstimateNormalsTest, PixelsAroundHolesKeepTheirNormal) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.4, -0.3, -1).normalized();
  DenseMaps maps = MakeMaps([&](const int col, const int row) {
    const bool is_hole = (col * 7 + row * 5) % 3 == 0 || std::abs(col - 20) < 3;
    return is_hole ? 0 : PlaneDepth(normal, 3, col, row);
  });
  EstimateNormals(TestCamera(), &maps);
  ExpectUnitAndFacing(maps);
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 0; col < kWidth; ++col) {
      if (maps.depth[row * kWidth + col] > 0) {
        ASSERT_LT(AngleInDegrees(Normal(maps, col, row), normal), 0.5)
            << col << " " << row;
      }
    }
  }
}

TEST_P(EstimateNormalsTest, NoisyDepthIsSmoothed) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.2, -0.3, -1).normalized();
  // 0.2 % of noise between neighbours, which would tilt a difference of two
  // pixels by up to 15 degrees.
  DenseMaps maps = MakeMaps([&](const int col, const int row) {
    const double noise = 0.002 * std::sin(12.9 * col + 78.2 * row);
    return PlaneDepth(normal, 3, col, row) * (1 + noise);
  });
  EstimateNormals(TestCamera(), &maps);
  for (int row = 8; row < kHeight - 8; ++row) {
    for (int col = 8; col < kWidth - 8; ++col) {
      EXPECT_LT(AngleInDegrees(Normal(maps, col, row), normal), 3);
    }
  }
}

// Blocks of pixels that share their depth, as coarse maps have when they are
// enlarged.
TEST_P(EstimateNormalsTest, LargeMapsAreLookedAtFromFarther) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.2, 0, -1).normalized();
  const PinholeCamera camera = {6 * kReferenceMapSize, 60, 3000, 3000, 0, 30};
  constexpr int kBlock = 6;
  DenseMaps maps;
  maps.width = camera.width;
  maps.height = camera.height;
  for (int row = 0; row < maps.height; ++row) {
    for (int col = 0; col < maps.width; ++col) {
      const double x = kBlock * (col / kBlock) + 0.5 * (kBlock - 1);
      maps.depth.push_back(static_cast<float>(
          -3 / normal.dot(Eigen::Vector3d(x / camera.fx, 0, 1))));
    }
  }
  EstimateNormals(camera, &maps);
  const size_t plane = maps.depth.size();
  for (int col = 50; col < 500; ++col) {
    const size_t pixel = 30 * static_cast<size_t>(maps.width) + col;
    const Eigen::Vector3d found(maps.normal[pixel],
                                maps.normal[plane + pixel],
                                maps.normal[2 * plane + pixel]);
    EXPECT_LT(AngleInDegrees(found, normal), 2) << col;
  }
}

// Values that come from a field that has gone wrong.
TEST_P(EstimateNormalsTest, WildDepthsGiveUnitNormals) {
  DenseMaps maps = MakeMaps([](const int col, const int row) {
    return std::pow(10.0, (7 * col + 11 * row) % 13 - 6);
  });
  EstimateNormals(TestCamera(), &maps);
  ExpectUnitAndFacing(maps);
}

TEST_P(EstimateNormalsTest, AreTheSameOnAnyNumberOfThreads) {
  DenseMaps maps = MakeMaps([](const int col, const int row) {
    return 2 + 0.01 * ((col * 7919 + row * 104729) % 97);
  });
  DenseMaps others = maps;
  EstimateNormals(TestCamera(), &maps);
  ThreadPool pool(3);
  Progress progress;
  EstimateNormals(TestCamera(), &pool, &progress, &others);
  EXPECT_EQ(others.normal, maps.normal);
}

TEST_P(EstimateNormalsTest, EndsWhenToldTo) {
  DenseMaps maps = MakeMaps([](int, int) { return 2.0; });
  ThreadPool pool(2);
  AbortingProgress progress;
  EXPECT_THROW(EstimateNormals(TestCamera(), &pool, &progress, &maps), Aborted);
}

TEST_P(EstimateNormalsTest, OnePixel) {
  DenseMaps maps;
  maps.width = 1;
  maps.height = 1;
  maps.depth = {2.0f};
  EstimateNormals({1, 1, 5, 5, 0.5, 0.5}, &maps);
  ASSERT_EQ(maps.normal.size(), 3u);
  EXPECT_LT(maps.normal[2], -0.9f);
}

STRUCTNERF_FOR_EACH_SIMD_TARGET(EstimateNormalsTest);

}  // namespace
}  // namespace structnerf
