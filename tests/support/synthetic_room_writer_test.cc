#include "tests/support/synthetic_room_writer.h"

#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

SyntheticRoom SmallRoom() {
  SyntheticRoomOptions options;
  options.num_views = 4;
  options.width = 120;
  options.height = 80;
  options.camera_models = {"SIMPLE_RADIAL", "OPENCV"};
  options.sub_folders = true;
  options.world_scale = 3;
  options.fault = RoomFault::kDarkGlossyFront;
  return MakeSyntheticRoom(options);
}

std::vector<std::string> DataLines(const std::string& path) {
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] != '#') {
      lines.push_back(line);
    }
  }
  return lines;
}

TEST(SyntheticRoomWriter, TextModelReadsBack) {
  const SyntheticRoom room = SmallRoom();
  const TempDir dir;
  WriteSyntheticRoom(room, dir / "room");

  const auto cameras = DataLines(dir / "room/sparse/0/cameras.txt");
  ASSERT_EQ(cameras.size(), room.cameras.size());
  for (size_t i = 0; i < cameras.size(); ++i) {
    std::istringstream line(cameras[i]);
    size_t id;
    SyntheticCamera camera;
    line >> id >> camera.model >> camera.width >> camera.height;
    for (double param; line >> param;) {
      camera.params.push_back(param);
    }
    EXPECT_EQ(id, i + 1);
    EXPECT_EQ(camera.model, room.cameras[i].model);
    EXPECT_EQ(camera.width, room.cameras[i].width);
    EXPECT_EQ(camera.height, room.cameras[i].height);
    EXPECT_EQ(camera.params, room.cameras[i].params);
  }

  const auto images = DataLines(dir / "room/sparse/0/images.txt");
  ASSERT_EQ(images.size(), 2 * room.images.size());
  for (size_t i = 0; i < room.images.size(); ++i) {
    const SyntheticImage& image = room.images[i];
    std::istringstream head(images[2 * i]);
    int id;
    int camera_id;
    Eigen::Quaterniond q;
    Eigen::Vector3d t;
    std::string name;
    head >> id >> q.w() >> q.x() >> q.y() >> q.z() >> t.x() >> t.y() >> t.z() >>
        camera_id >> name;
    EXPECT_EQ(id, static_cast<int>(i) + 1);
    EXPECT_EQ(camera_id, image.camera_idx + 1);
    EXPECT_EQ(name, image.name);
    EXPECT_TRUE(
        q.toRotationMatrix().isApprox(image.cam_from_world_rotation, 1e-12));
    EXPECT_EQ(t, image.cam_from_world_translation);

    std::istringstream tail(images[2 * i + 1]);
    for (const SyntheticObservation& observation : image.observations) {
      Eigen::Vector2d xy;
      int point_id;
      ASSERT_TRUE(tail >> xy.x() >> xy.y() >> point_id);
      EXPECT_EQ(xy, observation.xy);
      EXPECT_EQ(point_id,
                observation.point_idx < 0 ? -1 : observation.point_idx + 1);
    }
    std::string rest;
    EXPECT_FALSE(tail >> rest);
  }

  const auto points = DataLines(dir / "room/sparse/0/points3D.txt");
  ASSERT_EQ(points.size(), room.points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const SyntheticPoint& point = room.points[i];
    std::istringstream line(points[i]);
    size_t id;
    Eigen::Vector3d xyz;
    int r, g, b;
    double error;
    line >> id >> xyz.x() >> xyz.y() >> xyz.z() >> r >> g >> b >> error;
    EXPECT_EQ(id, i + 1);
    EXPECT_EQ(xyz, point.xyz);
    EXPECT_EQ(g, point.color[1]);
    EXPECT_EQ(error, point.error);
    for (const SyntheticTrackElement& element : point.track) {
      int image_id;
      int observation_idx;
      ASSERT_TRUE(line >> image_id >> observation_idx);
      EXPECT_EQ(image_id, element.image_idx + 1);
      EXPECT_EQ(observation_idx, element.observation_idx);
    }
  }
}

TEST(SyntheticRoomWriter, PicturesHoldWhatTheRoomHolds) {
  const SyntheticRoom room = SmallRoom();
  const TempDir dir;
  WriteSyntheticRoom(room, dir / "room");
  int num_faulty = 0;
  for (size_t i = 0; i < room.images.size(); ++i) {
    const SyntheticImage& image = room.images[i];
    const auto read = [&](const std::string& kind) {
      return cv::imread(dir / ("room/" + kind + "/" + image.name),
                        cv::IMREAD_UNCHANGED);
    };
    const cv::Mat color = read("images");
    const cv::Mat depth = read("depth");
    const cv::Mat normal = read("normal");
    const cv::Mat fault = read("fault");
    ASSERT_EQ(color.type(), CV_8UC3);
    ASSERT_EQ(depth.type(), CV_16U);
    ASSERT_EQ(normal.type(), CV_16UC3);
    ASSERT_EQ(fault.type(), CV_8U);
    for (const cv::Mat& picture : {color, depth, normal, fault}) {
      ASSERT_EQ(picture.cols, image.pixels.width);
      ASSERT_EQ(picture.rows, image.pixels.height);
    }
    for (int row = 0; row < color.rows; row += 7) {
      for (int col = 0; col < color.cols; col += 7) {
        const uint8_t* rgb = &image.pixels.data[3 * (row * color.cols + col)];
        EXPECT_EQ(color.at<cv::Vec3b>(row, col),
                  cv::Vec3b(rgb[2], rgb[1], rgb[0]));
        const RoomHit hit = CastIntoRoom(
            room, static_cast<int>(i), Eigen::Vector2d(col + 0.5, row + 0.5));
        // Millimetres of the room, whatever the world's unit.
        EXPECT_NEAR(depth.at<uint16_t>(row, col), 1000 * hit.depth / 3, 0.51);
        const cv::Vec3w bgr = normal.at<cv::Vec3w>(row, col);
        EXPECT_NEAR(bgr[2] / 32767.5 - 1, hit.normal.x(), 2e-5);
        EXPECT_NEAR(bgr[1] / 32767.5 - 1, hit.normal.y(), 2e-5);
        EXPECT_NEAR(bgr[0] / 32767.5 - 1, hit.normal.z(), 2e-5);
        EXPECT_EQ(fault.at<uint8_t>(row, col), hit.is_faulty ? 255 : 0);
        num_faulty += hit.is_faulty;
      }
    }
  }
  EXPECT_GT(num_faulty, 0);
}

TEST(SyntheticRoomWriter, LeavesAnExistingFolderAlone) {
  const SyntheticRoom room = SmallRoom();
  const TempDir dir;
  std::ofstream(dir / "precious") << "text";
  EXPECT_THROW(WriteSyntheticRoom(room, dir.Path().string()),
               std::runtime_error);
  EXPECT_THROW(WriteSyntheticRoom(room, dir / "precious"), std::runtime_error);
  EXPECT_THROW(WriteSyntheticRoom(room, dir / "precious/below"),
               std::runtime_error);
  EXPECT_EQ(std::distance(fs::directory_iterator(dir.Path()),
                          fs::directory_iterator()),
            1);
  // An empty one will do.
  fs::create_directory(dir / "empty");
  CheckRoomFolder(dir / "empty");
  WriteSyntheticRoom(room, dir / "empty/");
  EXPECT_TRUE(fs::exists(dir / "empty/sparse/0/points3D.txt"));
}

}  // namespace
}  // namespace structnerf
