#include "nerf/analysis/point_colors.h"

#include "nerf/util/median.h"

#include <algorithm>
#include <cmath>

namespace structnerf {
namespace {

// Observations that suffice for some hundred numbers per scene.
constexpr size_t kMaxObservations = 30000;

// Colours in which sensors do not tell more from less light.
constexpr float kDarkest = 4.0f / 255.0f;
constexpr float kBrightest = 251.0f / 255.0f;

// The colour between the four pixels around a point of the image.
bool FindColor(const View& view,
               const Eigen::Vector2d& xy,
               Eigen::Vector3f* color) {
  const RgbImage& image = view.image;
  const double x = xy.x() * image.width / view.camera.width - 0.5;
  const double y = xy.y() * image.height / view.camera.height - 0.5;
  if (!(x >= 0 && y >= 0 && x < image.width - 1 && y < image.height - 1)) {
    return false;
  }
  const size_t col = static_cast<size_t>(x);
  const size_t row = static_cast<size_t>(y);
  color->setZero();
  for (size_t dy = 0; dy < 2; ++dy) {
    for (size_t dx = 0; dx < 2; ++dx) {
      const size_t pixel = (row + dy) * image.width + col + dx;
      if (!view.mask.empty() && view.mask[pixel] == 0) {
        return false;
      }
      const double weight =
          std::abs(1 - dx - (x - col)) * std::abs(1 - dy - (y - row));
      for (int c = 0; c < 3; ++c) {
        (*color)[c] +=
            static_cast<float>(weight * image.data[3 * pixel + c] / 255.0);
      }
    }
  }
  return color->minCoeff() >= kDarkest && color->maxCoeff() <= kBrightest;
}

}  // namespace

std::vector<PointColor> CollectPointColors(const Scene& scene) {
  size_t num_all = 0;
  for (const SparsePoint& point : scene.points) {
    num_all += point.track.size();
  }
  const size_t stride = num_all / kMaxObservations + 1;
  std::vector<PointColor> colors;
  for (size_t i = 0; i < scene.points.size(); i += stride) {
    const size_t begin = colors.size();
    for (const Observation& observation : scene.points[i].track) {
      PointColor color;
      color.view_idx = static_cast<size_t>(observation.view_idx);
      color.point_idx = i;
      if (FindColor(
              scene.views[color.view_idx], observation.xy, &color.color)) {
        colors.push_back(color);
      }
    }
    if (colors.size() - begin < 2) {
      colors.resize(begin);
    }
  }
  return colors;
}

double MeasureColorSpread(const Scene& scene) {
  std::vector<PointColor> colors = CollectPointColors(scene);
  std::vector<Eigen::Vector3f> means(scene.points.size(),
                                     Eigen::Vector3f::Zero());
  std::vector<float> counts(scene.points.size(), 0);
  for (PointColor& color : colors) {
    const Exposure& exposure = scene.views[color.view_idx].exposure;
    color.color = (color.color - exposure.offset).cwiseQuotient(exposure.gain);
    means[color.point_idx] += color.color;
    ++counts[color.point_idx];
  }
  std::vector<double> differences;
  for (const PointColor& color : colors) {
    const Eigen::Vector3f difference =
        color.color - means[color.point_idx] / counts[color.point_idx];
    for (int c = 0; c < 3; ++c) {
      differences.push_back(std::abs(difference[c]));
    }
  }
  return Median(&differences);
}

}  // namespace structnerf
