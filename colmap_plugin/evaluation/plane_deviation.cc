#include "colmap_plugin/evaluation/plane_deviation.h"

#include "colmap_plugin/superpixels.h"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

constexpr int kMinArea = 1000;        // pixels
constexpr double kMinCoverage = 0.5;  // of a region's pixels

// Sum of the distances to the plane that fits best in the least-squares sense.
double SumOfDistances(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) {
    mean += point;
  }
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& point : points) {
    scatter += (point - mean) * (point - mean).transpose();
  }
  const Eigen::Vector3d normal =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter)
          .eigenvectors()
          .col(0);  // of the smallest eigenvalue
  double sum = 0;
  for (const Eigen::Vector3d& point : points) {
    sum += std::abs(normal.dot(point - mean));
  }
  return sum;
}

}  // namespace

void PlaneDeviation::AddView(const PinholeCamera& camera,
                             const double offset,
                             const std::vector<int32_t>& labels,
                             const cv::Mat1f& depth) {
  std::vector<std::vector<Eigen::Vector3d>> regions;
  std::vector<size_t> areas;
  for (int row = 0; row < depth.rows; ++row) {
    for (int col = 0; col < depth.cols; ++col) {
      const int32_t label = labels[static_cast<size_t>(row) * depth.cols + col];
      if (label < 0) {
        continue;
      }
      if (label >= static_cast<int32_t>(regions.size())) {
        regions.resize(label + 1);
        areas.resize(label + 1, 0);
      }
      ++areas[label];
      const double z = depth(row, col);
      if (z > 0) {
        regions[label].emplace_back(z * (col + offset - camera.cx) / camera.fx,
                                    z * (row + offset - camera.cy) / camera.fy,
                                    z);
      }
    }
  }
  for (size_t i = 0; i < regions.size(); ++i) {
    if (regions[i].size() >= 3 &&
        regions[i].size() >= kMinCoverage * areas[i]) {
      sum_ += SumOfDistances(regions[i]);
      num_points_ += regions[i].size();
      ++num_planes_;
    }
  }
}

double PlaneDeviation::Mean() const {
  return num_points_ > 0 ? sum_ / num_points_ : 0.0;
}

std::vector<int32_t> FindPlanarRegions(const cv::Mat3b& image) {
  cv::Mat rgb;
  cv::cvtColor(image, rgb, cv::COLOR_BGR2RGB);
  RgbImage pixels;
  pixels.width = rgb.cols;
  pixels.height = rgb.rows;
  pixels.data.assign(rgb.datastart, rgb.dataend);
  return FindLargeSuperpixels(pixels, kMinArea);
}

}  // namespace structnerf
