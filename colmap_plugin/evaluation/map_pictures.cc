#include "colmap_plugin/evaluation/map_pictures.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include <boost/archive/iterators/base64_from_binary.hpp>
#include <boost/archive/iterators/transform_width.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

const cv::Vec3b kNoValueColor(128, 128, 128);
constexpr int kJpegQuality = 90;

uint8_t Level(const double share) {
  return static_cast<uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

// Levels from 0 to 255 in colours.
using ColorMap = cv::Mat3b (*)(const cv::Mat1b& levels);

cv::Mat3b DepthColors(const cv::Mat1b& levels) {
  cv::Mat3b colors;
  cv::applyColorMap(levels, colors, cv::COLORMAP_VIRIDIS);
  return colors;
}

cv::Mat3b ErrorColors(const cv::Mat1b& levels) {
  cv::Mat3b colors;
  cv::applyColorMap(levels, colors, cv::COLORMAP_INFERNO);
  return colors;
}

cv::Mat3b BalanceColors(const cv::Mat1b& levels) {
  const cv::Vec3d blue(172, 102, 33);
  const cv::Vec3d white(247, 247, 247);
  const cv::Vec3d orange(1, 97, 230);
  cv::Mat3b scale(1, 256);
  for (int i = 0; i < 256; ++i) {
    const double place = (i - 127.5) / 127.5;  // from -1 to 1
    const double share = std::abs(place);
    scale(0, i) = (1 - share) * white + share * (place < 0 ? blue : orange);
  }
  cv::Mat3b colors;
  cv::applyColorMap(levels, colors, scale.t());
  return colors;
}

cv::Mat3b Picture(const cv::Mat1f& values,
                  const double lowest,
                  const double highest,
                  const cv::Mat1b& has_value,
                  const ColorMap color_map) {
  const double range = highest > lowest ? highest - lowest : 1.0;
  cv::Mat1b levels(values.size());
  std::transform(
      values.begin(), values.end(), levels.begin(), [&](const float value) {
        return Level((value - lowest) / range);
      });
  cv::Mat3b picture = color_map(levels);
  picture.setTo(kNoValueColor, ~has_value);
  return picture;
}

cv::Mat3b ScaleBar(const ColorMap color_map) {
  cv::Mat1b levels(1, 256);
  std::iota(levels.begin(), levels.end(), uint8_t{0});
  return color_map(levels);
}

std::string Base64(const std::vector<uint8_t>& data) {
  namespace iterators = boost::archive::iterators;
  using Encoder = iterators::base64_from_binary<
      iterators::transform_width<std::vector<uint8_t>::const_iterator, 6, 8>>;
  std::string text(Encoder(data.begin()), Encoder(data.end()));
  text.append((3 - data.size() % 3) % 3, '=');
  return text;
}

std::string DataUri(const cv::Mat3b& picture,
                    const std::string& format,
                    const std::vector<int>& parameters) {
  std::vector<uint8_t> data;
  if (!cv::imencode("." + format, picture, data, parameters)) {
    throw std::runtime_error("A picture could not be encoded.");
  }
  return "data:image/" + format + ";base64," + Base64(data);
}

}  // namespace

cv::Mat3b DepthPicture(const cv::Mat1f& depth,
                       const double nearest,
                       const double farthest) {
  return Picture(depth, nearest, farthest, depth > 0, DepthColors);
}

cv::Mat3b ErrorPicture(const cv::Mat1f& error, const double largest) {
  return Picture(error, 0, largest, error >= 0, ErrorColors);
}

cv::Mat3b BalancePicture(const cv::Mat1f& a,
                         const cv::Mat1f& b,
                         const double largest) {
  return Picture(a - b, -largest, largest, (a >= 0) & (b >= 0), BalanceColors);
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

cv::Mat3b DepthScaleBar() { return ScaleBar(DepthColors); }

cv::Mat3b ErrorScaleBar() { return ScaleBar(ErrorColors); }

cv::Mat3b BalanceScaleBar() { return ScaleBar(BalanceColors); }

std::string PngDataUri(const cv::Mat3b& picture) {
  return DataUri(picture, "png", {});
}

std::string JpegDataUri(const cv::Mat3b& picture, const int max_size) {
  cv::Mat3b reduced = picture;
  const double scale =
      static_cast<double>(max_size) / std::max(picture.cols, picture.rows);
  if (scale < 1) {
    const cv::Size size(
        std::max(1, static_cast<int>(std::lround(scale * picture.cols))),
        std::max(1, static_cast<int>(std::lround(scale * picture.rows))));
    cv::resize(picture, reduced, size, 0, 0, cv::INTER_AREA);
  }
  return DataUri(reduced, "jpeg", {cv::IMWRITE_JPEG_QUALITY, kJpegQuality});
}

}  // namespace structnerf
