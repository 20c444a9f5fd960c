#include "tests/support/synthetic_room_writer.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <stdexcept>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

void WritePng(const fs::path& path, const cv::Mat& image) {
  fs::create_directories(path.parent_path());
  if (!cv::imwrite(path.string(), image)) {
    throw std::runtime_error("Cannot write " + path.string() + ".");
  }
}

std::ofstream OpenText(const fs::path& path) {
  std::ofstream file(path);
  file.precision(std::numeric_limits<double>::max_digits10);
  return file;
}

void CloseText(const fs::path& path, std::ofstream* file) {
  file->close();
  if (!*file) {
    throw std::runtime_error("Cannot write " + path.string() + ".");
  }
}

void WriteCameras(const SyntheticRoom& room, const fs::path& path) {
  std::ofstream file = OpenText(path);
  file << "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  for (size_t i = 0; i < room.cameras.size(); ++i) {
    const SyntheticCamera& camera = room.cameras[i];
    file << i + 1 << " " << camera.model << " " << camera.width << " "
         << camera.height;
    for (const double param : camera.params) {
      file << " " << param;
    }
    file << "\n";
  }
  CloseText(path, &file);
}

void WriteImages(const SyntheticRoom& room, const fs::path& path) {
  std::ofstream file = OpenText(path);
  file << "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
       << "# POINTS2D[] as (X, Y, POINT3D_ID)\n";
  for (size_t i = 0; i < room.images.size(); ++i) {
    const SyntheticImage& image = room.images[i];
    const Eigen::Quaterniond q(image.cam_from_world_rotation);
    const Eigen::Vector3d& t = image.cam_from_world_translation;
    file << i + 1 << " " << q.w() << " " << q.x() << " " << q.y() << " "
         << q.z() << " " << t.x() << " " << t.y() << " " << t.z() << " "
         << image.camera_idx + 1 << " " << image.name << "\n";
    const char* separator = "";
    for (const SyntheticObservation& observation : image.observations) {
      file << separator << observation.xy.x() << " " << observation.xy.y()
           << " ";
      if (observation.point_idx < 0) {
        file << "-1";
      } else {
        file << observation.point_idx + 1;
      }
      separator = " ";
    }
    file << "\n";
  }
  CloseText(path, &file);
}

void WritePoints(const SyntheticRoom& room, const fs::path& path) {
  std::ofstream file = OpenText(path);
  file << "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, "
          "POINT2D_IDX)\n";
  for (size_t i = 0; i < room.points.size(); ++i) {
    const SyntheticPoint& point = room.points[i];
    file << i + 1 << " " << point.xyz.x() << " " << point.xyz.y() << " "
         << point.xyz.z() << " " << int{point.color[0]} << " "
         << int{point.color[1]} << " " << int{point.color[2]} << " "
         << point.error;
    for (const SyntheticTrackElement& element : point.track) {
      file << " " << element.image_idx + 1 << " " << element.observation_idx;
    }
    file << "\n";
  }
  CloseText(path, &file);
}

cv::Mat DepthImage(const RoomTruth& truth, const double world_scale) {
  cv::Mat image(truth.height, truth.width, CV_16U);
  for (int row = 0; row < truth.height; ++row) {
    for (int col = 0; col < truth.width; ++col) {
      const double depth = truth.depth[row * truth.width + col] / world_scale;
      image.at<uint16_t>(row, col) =
          static_cast<uint16_t>(std::lround(1000 * depth));
    }
  }
  return image;
}

cv::Mat NormalImage(const RoomTruth& truth) {
  const size_t num_pixels = truth.depth.size();
  cv::Mat image(truth.height, truth.width, CV_16UC3);
  for (int row = 0; row < truth.height; ++row) {
    for (int col = 0; col < truth.width; ++col) {
      const size_t pixel = static_cast<size_t>(row) * truth.width + col;
      for (int axis = 0; axis < 3; ++axis) {
        const double value = truth.normal[axis * num_pixels + pixel];
        // OpenCV stores blue first.
        image.at<cv::Vec3w>(row, col)[2 - axis] =
            static_cast<uint16_t>(std::lround(32767.5 * (value + 1)));
      }
    }
  }
  return image;
}

void WritePixels(const SyntheticRoom& room,
                 const int image_idx,
                 const fs::path& folder) {
  const SyntheticImage& image = room.images[image_idx];
  const cv::Mat rgb(image.pixels.height,
                    image.pixels.width,
                    CV_8UC3,
                    const_cast<uint8_t*>(image.pixels.data.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  WritePng(folder / "images" / image.name, bgr);

  const fs::path stem = fs::path(image.name).replace_extension(".png");
  RoomTruth truth = CastTruth(room, image_idx, PixelPoint::kCenter);
  WritePng(folder / "depth" / stem,
           DepthImage(truth, room.options.world_scale));
  WritePng(folder / "normal" / stem, NormalImage(truth));
  if (room.options.fault != RoomFault::kNone &&
      room.options.fault != RoomFault::kExposureJump) {
    WritePng(
        folder / "fault" / stem,
        cv::Mat(truth.height, truth.width, CV_8U, truth.fault_mask.data()));
  }
}

// Where a folder is written until it is complete: beside it.
fs::path PartialFolder(const fs::path& target) {
  std::random_device random;
  return target.parent_path() / ("." + target.filename().string() + ".partial" +
                                 std::to_string(random()));
}

}  // namespace

void CheckRoomFolder(const std::string& folder) {
  std::error_code error;
  if (fs::exists(folder, error) &&
      (!fs::is_directory(folder, error) || !fs::is_empty(folder, error))) {
    throw std::runtime_error("The folder " + folder +
                             " exists and is not empty; choose a new one.");
  }
}

void WriteSyntheticRoom(const SyntheticRoom& room, const std::string& folder) {
  CheckRoomFolder(folder);
  const fs::path target = fs::absolute(folder + "/").parent_path();
  const fs::path partial = PartialFolder(target);
  try {
    const fs::path sparse = partial / "sparse" / "0";
    fs::create_directories(sparse);
    WriteCameras(room, sparse / "cameras.txt");
    WriteImages(room, sparse / "images.txt");
    WritePoints(room, sparse / "points3D.txt");
    for (size_t i = 0; i < room.images.size(); ++i) {
      WritePixels(room, static_cast<int>(i), partial);
    }
    fs::rename(partial, target);
  } catch (const std::exception& error) {
    std::error_code ignored;
    fs::remove_all(partial, ignored);
    throw std::runtime_error("Cannot write the folder " + folder + ": " +
                             error.what());
  }
}

}  // namespace structnerf
