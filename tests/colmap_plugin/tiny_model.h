#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace structnerf {

// A COLMAP model of a few small images for tests, and its images. The cameras
// stand side by side on the x axis, all looking along z at points on z = 4.
struct TinyModel {
  struct Camera {
    std::string model = "PINHOLE";
    int width = 64;
    int height = 48;
    std::vector<double> params = {60, 60, 32, 24};
  };
  struct Image {
    std::string name;
    int camera_idx = 0;
    double x = 0;  // of the projection centre
  };

  std::vector<Camera> cameras;
  std::vector<Image> images;
  std::vector<Eigen::Vector3d> points;  // seen by every image
  double point_error = 0.5;

  // Writes cameras.txt, images.txt and points3D.txt.
  void WriteModel(const std::string& folder) const;

  // Writes a PNG of random texture, the same in every call, for each image.
  void WriteImages(const std::string& folder) const;
};

// Images "0.png", "1.png", ... half a unit apart, one camera, nine points.
TinyModel MakeTinyModel(int num_images);

// Random grey-level texture in colour.
cv::Mat RandomImage(int width, int height, int seed);

}  // namespace structnerf
