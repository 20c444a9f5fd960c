#include "colmap_plugin/evaluation/map_pictures.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <boost/archive/iterators/base64_from_binary.hpp>
#include <boost/archive/iterators/transform_width.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

const cv::Vec3b kNoValueColor(128, 128, 128);

uint8_t Level(const double share) {
  return static_cast<uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

std::string Base64(const std::vector<uint8_t>& data) {
  namespace iterators = boost::archive::iterators;
  using Encoder = iterators::base64_from_binary<
      iterators::transform_width<std::vector<uint8_t>::const_iterator, 6, 8>>;
  std::string text(Encoder(data.begin()), Encoder(data.end()));
  text.append((3 - data.size() % 3) % 3, '=');
  return text;
}

}  // namespace

cv::Mat3b DepthPicture(const cv::Mat1f& depth,
                       const double nearest,
                       const double farthest) {
  const double range = farthest > nearest ? farthest - nearest : 1.0;
  cv::Mat1b levels(depth.size());
  for (int row = 0; row < depth.rows; ++row) {
    for (int col = 0; col < depth.cols; ++col) {
      const float value = depth(row, col);
      levels(row, col) =
          value > 0 ? Level((value - nearest) / range) : uint8_t{0};
    }
  }
  cv::Mat3b picture;
  cv::applyColorMap(levels, picture, cv::COLORMAP_VIRIDIS);
  picture.setTo(kNoValueColor, ~(depth > 0));
  return picture;
}

cv::Mat3b NormalPicture(const std::vector<float>& normal,
                        const int width,
                        const int height) {
  const size_t num_pixels = static_cast<size_t>(width) * height;
  cv::Mat3b picture(height, width);
  for (size_t i = 0; i < num_pixels; ++i) {
    const float x = normal[i];
    const float y = normal[num_pixels + i];
    const float z = normal[2 * num_pixels + i];
    picture(static_cast<int>(i / width), static_cast<int>(i % width)) =
        x == 0 && y == 0 && z == 0 ? kNoValueColor
                                   : cv::Vec3b(Level(0.5 - 0.5 * z),
                                               Level(0.5 - 0.5 * y),
                                               Level(0.5 + 0.5 * x));
  }
  return picture;
}

std::string PngDataUri(const cv::Mat3b& picture) {
  std::vector<uint8_t> data;
  if (!cv::imencode(".png", picture, data)) {
    throw std::runtime_error("A picture could not be encoded.");
  }
  return "data:image/png;base64," + Base64(data);
}

}  // namespace structnerf
