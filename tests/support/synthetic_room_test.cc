#include "tests/support/synthetic_room.h"

#include "tests/support/image_geometry.h"

#include <cmath>
#include <set>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using room::CameraCenter;
using room::ObservationOf;
using room::PointInCamera;
using room::ProjectPoint;
using testing::HasSubstr;

// Small and quick; the walk is the same.
SyntheticRoomOptions SmallOptions() {
  SyntheticRoomOptions options;
  options.num_views = 6;
  options.width = 128;
  options.height = 96;
  return options;
}

const SyntheticRoom& DefaultRoom() {
  static const SyntheticRoom room = MakeSyntheticRoom({});
  return room;
}

Eigen::Vector3d BackProject(const SyntheticRoom& room,
                            const SyntheticImage& image,
                            const Eigen::Vector2d& xy,
                            const double depth) {
  const Eigen::Vector3d in_cam =
      depth * room.cameras[image.camera_idx].Unproject(xy);
  return image.cam_from_world_rotation.transpose() *
         (in_cam - image.cam_from_world_translation);
}

TEST(SyntheticRoom, WalkHasHandHeldSteps) {
  const SyntheticRoom& room = DefaultRoom();
  ASSERT_EQ(room.images.size(), 20);
  for (size_t i = 1; i < room.images.size(); ++i) {
    const double step =
        (CameraCenter(room.images[i]) - CameraCenter(room.images[i - 1]))
            .norm();
    EXPECT_GT(step, 0.1);
    EXPECT_LT(step, 0.4);
  }
}

TEST(SyntheticRoom, DepthAndNormalsAreThoseOfTheWalls) {
  const SyntheticRoom& room = DefaultRoom();
  std::set<std::string> objects;
  for (int image_idx = 0; image_idx < 20; ++image_idx) {
    const SyntheticImage& image = room.images[image_idx];
    for (const Eigen::Vector2d& xy : {Eigen::Vector2d(160.3, 20),
                                      Eigen::Vector2d(310, 30),
                                      Eigen::Vector2d(15, 40),
                                      Eigen::Vector2d(0, 0),
                                      Eigen::Vector2d(10.7, 230)}) {
      const RoomHit hit = CastIntoRoom(room, image_idx, xy);
      const Eigen::Vector3d xyz = BackProject(room, image, xy, hit.depth);
      const Eigen::Vector3d normal =
          image.cam_from_world_rotation.transpose() * hit.normal;
      EXPECT_TRUE(hit.xyz.isApprox(xyz, 1e-9));
      EXPECT_LT(hit.normal.dot(room.cameras[image.camera_idx].Unproject(xy)),
                0);
      objects.insert(hit.object);
      if (hit.object == "wall_north") {
        EXPECT_NEAR(xyz.y(), 4, 1e-9);
        EXPECT_TRUE(normal.isApprox(Eigen::Vector3d(0, -1, 0), 1e-9));
      } else if (hit.object == "wall_west") {
        EXPECT_NEAR(xyz.x(), 0, 1e-9);
        EXPECT_TRUE(normal.isApprox(Eigen::Vector3d(1, 0, 0), 1e-9));
      } else if (hit.object == "wall_east") {
        EXPECT_NEAR(xyz.x(), 5, 1e-9);
      } else if (hit.object == "floor") {
        EXPECT_NEAR(xyz.z(), 0, 1e-9);
        EXPECT_TRUE(normal.isApprox(Eigen::Vector3d(0, 0, 1), 1e-9));
      }
    }
  }
  EXPECT_THAT(
      objects,
      testing::IsSupersetOf({"wall_north", "wall_west", "wall_east", "floor"}));
}

TEST(SyntheticRoom, TruthIsTakenWhereItSays) {
  const SyntheticRoom& room = DefaultRoom();
  for (const PixelPoint pixel_point :
       {PixelPoint::kInteger, PixelPoint::kCenter}) {
    const double offset = pixel_point == PixelPoint::kCenter ? 0.5 : 0;
    const RoomTruth truth = CastTruth(room, 3, pixel_point);
    ASSERT_EQ(truth.depth.size(), 320 * 240);
    ASSERT_EQ(truth.normal.size(), 3 * 320 * 240);
    for (const int pixel : {0, 12345, 40000, 320 * 240 - 1}) {
      const RoomHit hit = CastIntoRoom(
          room, 3, Eigen::Vector2d(pixel % 320 + offset, pixel / 320 + offset));
      EXPECT_EQ(truth.depth[pixel], static_cast<float>(hit.depth));
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_EQ(truth.normal[axis * 320 * 240 + pixel],
                  static_cast<float>(hit.normal[axis]));
      }
    }
  }
}

TEST(SyntheticRoom, SparseModelHasTheSizeOfARealOne) {
  const SyntheticRoom& room = DefaultRoom();
  EXPECT_GE(room.points.size(), 1500);
  EXPECT_LE(room.points.size(), 3000);
  size_t num_observations = 0;
  for (const SyntheticPoint& point : room.points) {
    EXPECT_GE(point.track.size(), 2);
    num_observations += point.track.size();
  }
  EXPECT_GT(num_observations, 3 * room.points.size());
}

TEST(SyntheticRoom, TracksAndObservationsBelongTogether) {
  const SyntheticRoom& room = DefaultRoom();
  size_t num_elements = 0;
  for (size_t i = 0; i < room.points.size(); ++i) {
    std::set<int> image_idxs;
    for (const SyntheticTrackElement& element : room.points[i].track) {
      EXPECT_EQ(ObservationOf(room, element).point_idx, static_cast<int>(i));
      image_idxs.insert(element.image_idx);
      ++num_elements;
    }
    EXPECT_EQ(image_idxs.size(), room.points[i].track.size());
  }
  for (const SyntheticImage& image : room.images) {
    for (const SyntheticObservation& observation : image.observations) {
      num_elements -= observation.point_idx >= 0;
    }
  }
  EXPECT_EQ(num_elements, 0);
}

TEST(SyntheticRoom, TrackedPointsAreVisibleAndObservedWithTheGivenNoise) {
  const SyntheticRoom& room = DefaultRoom();
  double sum_squares = 0;
  double sum_errors = 0;
  size_t count = 0;
  for (const SyntheticPoint& point : room.points) {
    double mean_error = 0;
    for (const SyntheticTrackElement& element : point.track) {
      const SyntheticImage& image = room.images[element.image_idx];
      const Eigen::Vector2d& observed = ObservationOf(room, element).xy;
      mean_error += (observed - ProjectPoint(room, image, point.xyz)).norm() /
                    point.track.size();
      if (point.is_wrong) {
        continue;
      }
      const Eigen::Vector2d true_xy = ProjectPoint(room, image, point.true_xyz);
      sum_squares += (observed - true_xy).squaredNorm();
      ++count;
      const RoomHit hit = CastIntoRoom(room, element.image_idx, true_xy);
      EXPECT_LT((hit.xyz - point.true_xyz).norm(), 0.02);
    }
    EXPECT_NEAR(point.error, mean_error, 1e-9);
    EXPECT_LT(point.error, 3);
    sum_errors += point.error;
  }
  EXPECT_NEAR(std::sqrt(sum_squares / (2 * count)), 0.5, 0.02);
  const double mean_error = sum_errors / room.points.size();
  EXPECT_GT(mean_error, 0.3);
  EXPECT_LT(mean_error, 0.7);
}

TEST(SyntheticRoom, PointsAreNoisierWhereTheyAreFarther) {
  const SyntheticRoom& room = DefaultRoom();
  double near_error = 0;
  double far_error = 0;
  int num_near = 0;
  int num_far = 0;
  for (const SyntheticPoint& point : room.points) {
    if (point.is_wrong || point.track.size() != 3) {
      continue;
    }
    const SyntheticImage& image = room.images[point.track[0].image_idx];
    const double depth = PointInCamera(image, point.true_xyz).z();
    const double error = (point.xyz - point.true_xyz).norm();
    (depth < 1.8 ? near_error : far_error) += error;
    ++(depth < 1.8 ? num_near : num_far);
  }
  ASSERT_GT(num_near, 20);
  ASSERT_GT(num_far, 20);
  EXPECT_GT(far_error / num_far, 1.5 * near_error / num_near);
  EXPECT_GT(near_error / num_near, 0.001);
  EXPECT_LT(far_error / num_far, 0.2);
}

TEST(SyntheticRoom, BlankSurfacesAreLargeAndHaveNoPoints) {
  const SyntheticRoom& room = DefaultRoom();
  const std::set<std::string> blank = {
      "wall_north", "wall_south", "wall_west", "wall_east", "ceiling"};
  for (const SyntheticPoint& point : room.points) {
    if (!point.is_wrong) {
      const SyntheticTrackElement& first = point.track[0];
      const RoomHit hit = CastIntoRoom(
          room,
          first.image_idx,
          ProjectPoint(room, room.images[first.image_idx], point.true_xyz));
      EXPECT_EQ(blank.count(hit.object), 0) << hit.object;
    }
  }
  int num_blank = 0;
  int num_rays = 0;
  for (int image_idx = 0; image_idx < 20; ++image_idx) {
    for (int y = 0; y < 240; y += 10) {
      for (int x = 0; x < 320; x += 10) {
        const RoomHit hit =
            CastIntoRoom(room, image_idx, Eigen::Vector2d(x, y));
        num_blank += static_cast<int>(blank.count(hit.object));
        ++num_rays;
      }
    }
  }
  EXPECT_GT(num_blank, 0.2 * num_rays);
  EXPECT_LT(num_blank, 0.6 * num_rays);
}

TEST(SyntheticRoom, WrongMatchesHaveTheirShareAndAPlausibleError) {
  const SyntheticRoom& room = DefaultRoom();
  int num_wrong = 0;
  for (const SyntheticPoint& point : room.points) {
    if (point.is_wrong) {
      ++num_wrong;
      const Eigen::Vector3d center =
          CameraCenter(room.images[point.track[0].image_idx]);
      const double factor =
          (point.xyz - center).norm() / (point.true_xyz - center).norm();
      EXPECT_GT(std::abs(std::log(factor)), 0.05);
    }
  }
  EXPECT_NEAR(num_wrong / static_cast<double>(room.points.size()),
              room.options.outlier_ratio,
              0.002);
}

TEST(SyntheticRoom, SameSeedSameRoomOtherSeedOtherRoom) {
  SyntheticRoomOptions options = SmallOptions();
  const SyntheticRoom room = MakeSyntheticRoom(options);
  const SyntheticRoom same = MakeSyntheticRoom(options);
  options.seed = 1;
  const SyntheticRoom other = MakeSyntheticRoom(options);
  ASSERT_EQ(same.points.size(), room.points.size());
  ASSERT_GT(room.points.size(), 20);
  for (size_t i = 0; i < room.points.size(); ++i) {
    EXPECT_EQ(same.points[i].xyz, room.points[i].xyz);
  }
  for (size_t i = 0; i < room.images.size(); ++i) {
    EXPECT_EQ(same.images[i].pixels.data, room.images[i].pixels.data);
    EXPECT_NE(other.images[i].pixels.data, room.images[i].pixels.data);
  }
}

TEST(SyntheticRoom, WorldFrameIsASimilarityOfTheRoom) {
  SyntheticRoomOptions options = SmallOptions();
  const SyntheticRoom room = MakeSyntheticRoom(options);
  options.world_scale = 2.5;
  options.world_rotation =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 0.5).normalized());
  options.world_translation = Eigen::Vector3d(5e5, -4e6, 300);
  const SyntheticRoom moved = MakeSyntheticRoom(options);
  ASSERT_EQ(moved.points.size(), room.points.size());
  for (size_t i = 0; i < room.points.size(); ++i) {
    EXPECT_LT((moved.points[i].xyz -
               (2.5 * (options.world_rotation * room.points[i].xyz) +
                options.world_translation))
                  .norm(),
              1e-8);
    EXPECT_EQ(moved.points[i].error, room.points[i].error);
    const SyntheticTrackElement& first = moved.points[i].track[0];
    EXPECT_LT(
        (ProjectPoint(room, room.images[first.image_idx], room.points[i].xyz) -
         ProjectPoint(
             moved, moved.images[first.image_idx], moved.points[i].xyz))
            .norm(),
        1e-4);
  }
  const RoomHit hit = CastIntoRoom(room, 2, Eigen::Vector2d(40, 70));
  const RoomHit moved_hit = CastIntoRoom(moved, 2, Eigen::Vector2d(40, 70));
  EXPECT_NEAR(moved_hit.depth, 2.5 * hit.depth, 1e-6);
  EXPECT_TRUE(moved_hit.normal.isApprox(hit.normal, 1e-6));
}

TEST(SyntheticRoom, CamerasAndFoldersAlternate) {
  SyntheticRoomOptions options = SmallOptions();
  options.camera_models = {"PINHOLE", "OPENCV_FISHEYE"};
  options.sub_folders = true;
  const SyntheticRoom room = MakeSyntheticRoom(options);
  ASSERT_EQ(room.cameras.size(), 2);
  EXPECT_EQ(room.cameras[1].model, "OPENCV_FISHEYE");
  EXPECT_NE(room.cameras[0].width, room.cameras[1].width);
  EXPECT_EQ(room.images[0].name, "walk_a/frame_0000.png");
  EXPECT_EQ(room.images[3].name, "walk_b/frame_0000.png");
  for (size_t i = 0; i < room.images.size(); ++i) {
    const SyntheticImage& image = room.images[i];
    EXPECT_EQ(image.camera_idx, static_cast<int>(i % 2));
    EXPECT_EQ(image.pixels.width, room.cameras[i % 2].width);
    EXPECT_EQ(image.pixels.height, room.cameras[i % 2].height);
  }
  EXPECT_THROW(MakeScene(room), std::invalid_argument);
}

TEST(SyntheticRoom, SceneHoldsTheSameModel) {
  const SyntheticRoom& room = DefaultRoom();
  const Scene scene = MakeScene(room);
  scene.Check();
  ASSERT_EQ(scene.views.size(), room.images.size());
  ASSERT_EQ(scene.points.size(), room.points.size());
  for (const SparsePoint& point : scene.points) {
    double mean_error = 0;
    for (const Observation& observation : point.track) {
      const View& view = scene.views[observation.view_idx];
      const Eigen::Vector3d in_cam = view.cam_from_world_rotation * point.xyz +
                                     view.cam_from_world_translation;
      const Eigen::Vector2d projected(
          view.camera.fx * in_cam.x() / in_cam.z() + view.camera.cx,
          view.camera.fy * in_cam.y() / in_cam.z() + view.camera.cy);
      mean_error += (projected - observation.xy).norm() / point.track.size();
    }
    EXPECT_NEAR(mean_error, point.error, 1e-9);
  }
  for (const View& view : scene.views) {
    EXPECT_EQ(view.image.data.size(), 3 * 320 * 240);
    EXPECT_TRUE(view.segments.empty());
    EXPECT_TRUE(view.mask.empty());
  }
}

TEST(SyntheticRoomOptions, CheckNamesTheWrongField) {
  const auto error_of = [](const auto& change) {
    SyntheticRoomOptions options;
    change(&options);
    std::string error;
    EXPECT_FALSE(options.Check(&error));
    EXPECT_THROW(MakeSyntheticRoom(options), std::invalid_argument);
    return error;
  };
  EXPECT_THAT(error_of([](auto* o) { o->num_views = 1; }),
              HasSubstr("num_views"));
  EXPECT_THAT(error_of([](auto* o) { o->height = 0; }), HasSubstr("height"));
  EXPECT_THAT(error_of([](auto* o) { o->camera_models = {"FOV"}; }),
              HasSubstr("camera_models"));
  EXPECT_THAT(error_of([](auto* o) { o->camera_models.clear(); }),
              HasSubstr("camera_models"));
  EXPECT_THAT(error_of([](auto* o) { o->outlier_ratio = NAN; }),
              HasSubstr("outlier_ratio"));
  EXPECT_THAT(error_of([](auto* o) { o->noise_sigma = -1; }),
              HasSubstr("noise_sigma"));
  EXPECT_THAT(error_of([](auto* o) { o->world_scale = 0; }),
              HasSubstr("world_scale"));
  EXPECT_THAT(error_of([](auto* o) { o->world_rotation.coeffs() *= 2; }),
              HasSubstr("world_rotation"));
}

}  // namespace
}  // namespace structnerf
