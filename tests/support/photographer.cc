#include "tests/support/photographer.h"

#include "tests/support/parallel_for.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <Eigen/Geometry>

namespace structnerf::room {
namespace {

// Samples within a pixel: no two in one row or column of a 4 x 4 raster, which
// smooths upright and level edges as well as slanted ones.
constexpr int kSamplesPerPixel = 4;
constexpr double kSampleCols[kSamplesPerPixel] = {0.375, 0.875, 0.125, 0.625};
constexpr double kSampleRows[kSamplesPerPixel] = {0.125, 0.375, 0.625, 0.875};

constexpr double kGamma = 2.2;

}  // namespace

Photographer::Photographer(const RoomModel& model,
                           const SyntheticCamera& camera)
    : model_(model), width_(camera.width), height_(camera.height) {
  sample_rays_.resize(static_cast<size_t>(width_) * height_ * kSamplesPerPixel);
  ParallelFor(height_, [&](const int row) {
    Eigen::Vector2d* ray =
        &sample_rays_[static_cast<size_t>(row) * width_ * kSamplesPerPixel];
    for (int col = 0; col < width_; ++col) {
      for (int sample = 0; sample < kSamplesPerPixel; ++sample) {
        *ray++ = camera
                     .Unproject(Eigen::Vector2d(col + kSampleCols[sample],
                                                row + kSampleRows[sample]))
                     .head<2>();
      }
    }
  });
}

RgbImage Photographer::TakePhotograph(const CameraPose& pose,
                                      const double exposure,
                                      const double noise_sigma,
                                      const int seed) const {
  const Eigen::Matrix3d room_from_cam = pose.cam_from_room.transpose();
  std::vector<double> values(static_cast<size_t>(width_) * height_ * 3);
  ParallelFor(height_, [&](const int row) {
    const size_t first_pixel = static_cast<size_t>(row) * width_;
    const Eigen::Vector2d* ray = &sample_rays_[first_pixel * kSamplesPerPixel];
    for (int col = 0; col < width_; ++col) {
      Color light = Color::Zero();
      for (int sample = 0; sample < kSamplesPerPixel; ++sample) {
        light += model_.Radiance(
            {pose.center, room_from_cam * (ray++)->homogeneous()});
      }
      light *= exposure / kSamplesPerPixel;
      for (int channel = 0; channel < 3; ++channel) {
        values[3 * (first_pixel + col) + channel] =
            255 * std::pow(std::min(light[channel], 1.0), 1 / kGamma);
      }
    }
  });

  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  RgbImage image;
  image.width = width_;
  image.height = height_;
  image.data.resize(values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    const double value = values[i] + noise_sigma * normal(random);
    image.data[i] =
        static_cast<uint8_t>(std::clamp(std::round(value), 0.0, 255.0));
  }
  return image;
}

}  // namespace structnerf::room
