#include "tests/colmap_plugin/tiny_model.h"

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <opencv2/imgcodecs.hpp>

namespace structnerf {

namespace fs = std::filesystem;

void TinyModel::WriteModel(const std::string& folder) const {
  fs::create_directories(folder);
  std::ofstream camera_file(fs::path(folder) / "cameras.txt");
  for (size_t i = 0; i < cameras.size(); ++i) {
    camera_file << i + 1 << " " << cameras[i].model << " " << cameras[i].width
                << " " << cameras[i].height;
    for (const double param : cameras[i].params) {
      camera_file << " " << param;
    }
    camera_file << "\n";
  }

  // All models start with a focal length; PINHOLE has a second one.
  std::ofstream image_file(fs::path(folder) / "images.txt");
  for (size_t i = 0; i < images.size(); ++i) {
    const Camera& camera = cameras[images[i].camera_idx];
    image_file << i + 1 << " 1 0 0 0 " << -images[i].x << " 0 0 "
               << images[i].camera_idx + 1 << " " << images[i].name << "\n";
    const size_t center_idx = camera.params.size() == 4 ? 2 : 1;
    for (size_t j = 0; j < points.size(); ++j) {
      const Eigen::Vector3d x = points[j] - Eigen::Vector3d(images[i].x, 0, 0);
      image_file << (j > 0 ? " " : "")
                 << camera.params[0] * x.x() / x.z() + camera.params[center_idx]
                 << " "
                 << camera.params[0] * x.y() / x.z() +
                        camera.params[center_idx + 1]
                 << " " << j + 1;
    }
    image_file << "\n";
  }

  std::ofstream point_file(fs::path(folder) / "points3D.txt");
  for (size_t j = 0; j < points.size(); ++j) {
    point_file << j + 1 << " " << points[j].x() << " " << points[j].y() << " "
               << points[j].z() << " 128 128 128 " << point_error;
    for (size_t i = 0; i < images.size(); ++i) {
      point_file << " " << i + 1 << " " << j;
    }
    point_file << "\n";
  }
}

void TinyModel::WriteImages(const std::string& folder) const {
  for (size_t i = 0; i < images.size(); ++i) {
    const Camera& camera = cameras[images[i].camera_idx];
    const fs::path path = fs::path(folder) / images[i].name;
    fs::create_directories(path.parent_path());
    if (!cv::imwrite(path.string(),
                     RandomImage(camera.width, camera.height, i))) {
      throw std::runtime_error("cannot write " + path.string());
    }
  }
}

TinyModel MakeTinyModel(const int num_images) {
  TinyModel model;
  model.cameras.emplace_back();
  for (int i = 0; i < num_images; ++i) {
    model.images.push_back({std::to_string(i) + ".png", 0, 0.5 * i});
  }
  for (int i = 0; i < 9; ++i) {
    model.points.emplace_back(0.4 * (i % 3), 0.4 * (i / 3 - 1), 4);
  }
  return model;
}

cv::Mat RandomImage(const int width, const int height, const int seed) {
  cv::Mat image(height, width, CV_8UC3);
  cv::RNG random(seed + 1);
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

}  // namespace structnerf
