#pragma once

#include <colmap/scene/camera.h>

#include <opencv2/core.hpp>

namespace structnerf {

// Where in an image the value of a pixel is taken: ground truth and photographs
// at the pixel's centre, dense maps at the integer point (nerf/dense_maps.h).
constexpr double kPixelCenter = 0.5;
constexpr double kPixelCorner = 0.0;

// The rays (x / z, y / z in the camera frame) through the points (col + offset,
// row + offset) of a grid of `size` that covers the whole image of `camera`,
// which may be distorted. NaN where the camera model has no ray.
cv::Mat2d GridRays(const colmap::Camera& camera, cv::Size size, double offset);

// What a depth map over the whole image of `camera` says for each ray, by the
// nearest pixel in the sense of pixel centres: 0 outside of it, and where it is
// not a positive number.
cv::Mat1f LookUp(const cv::Mat2d& rays,
                 const colmap::Camera& camera,
                 const cv::Mat1f& depth);

}  // namespace structnerf
