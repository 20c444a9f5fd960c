#include "tests/support/corner_detector.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace structnerf::room {
namespace {

constexpr int kWindowRadius = 2;

std::vector<float> GrayLevels(const RgbImage& image) {
  std::vector<float> gray(image.data.size() / 3);
  for (size_t i = 0; i < gray.size(); ++i) {
    gray[i] = 0.299f * image.data[3 * i] + 0.587f * image.data[3 * i + 1] +
              0.114f * image.data[3 * i + 2];
  }
  return gray;
}

// Smaller eigenvalue of the mean of the gradients' outer products.
float Response(const std::vector<float>& gray,
               const int width,
               const int col,
               const int row) {
  float xx = 0;
  float xy = 0;
  float yy = 0;
  for (int r = row - kWindowRadius; r <= row + kWindowRadius; ++r) {
    for (int c = col - kWindowRadius; c <= col + kWindowRadius; ++c) {
      const int i = r * width + c;
      const float dx = 0.5f * (gray[i + 1] - gray[i - 1]);
      const float dy = 0.5f * (gray[i + width] - gray[i - width]);
      xx += dx * dx;
      xy += dx * dy;
      yy += dy * dy;
    }
  }
  constexpr int kWindowArea = (2 * kWindowRadius + 1) * (2 * kWindowRadius + 1);
  const float mean = 0.5f * (xx + yy);
  const float difference = 0.5f * (xx - yy);
  return (mean - std::sqrt(difference * difference + xy * xy)) / kWindowArea;
}

}  // namespace

std::vector<Eigen::Vector2d> DetectCorners(const RgbImage& image,
                                           const double min_response,
                                           const int radius) {
  const std::vector<float> gray = GrayLevels(image);
  const int border = kWindowRadius + 1;
  std::vector<float> response(gray.size(), 0.f);
  for (int row = border; row < image.height - border; ++row) {
    for (int col = border; col < image.width - border; ++col) {
      response[row * image.width + col] = Response(gray, image.width, col, row);
    }
  }

  std::vector<std::pair<float, Eigen::Vector2d>> corners;
  const int margin = border + radius;
  for (int row = margin; row < image.height - margin; ++row) {
    for (int col = margin; col < image.width - margin; ++col) {
      const float center = response[row * image.width + col];
      if (center < min_response) {
        continue;
      }
      bool is_largest = true;
      for (int r = row - radius; is_largest && r <= row + radius; ++r) {
        const float* begin = &response[r * image.width + col - radius];
        is_largest = *std::max_element(begin, begin + 2 * radius + 1) <= center;
      }
      if (is_largest) {
        corners.emplace_back(center, Eigen::Vector2d(col + 0.5, row + 0.5));
      }
    }
  }
  std::stable_sort(
      corners.begin(), corners.end(), [](const auto& a, const auto& b) {
        return a.first > b.first;
      });
  std::vector<Eigen::Vector2d> points;
  points.reserve(corners.size());
  for (const auto& corner : corners) {
    points.push_back(corner.second);
  }
  return points;
}

}  // namespace structnerf::room
