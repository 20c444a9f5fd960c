#include "colmap_plugin/rendering/frame_writer.h"

#include "colmap_plugin/evaluation/map_pictures.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <stdexcept>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

void WritePng(const fs::path& path, const cv::Mat& image) {
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  bool written = false;
  try {
    written = cv::imwrite(path.string(), image);
  } catch (const cv::Exception&) {
    // As if it had returned false.
  }
  if (!written) {
    throw std::runtime_error("The file " + path.string() +
                             " could not be written; is the disk full?");
  }
}

cv::Mat ColorImage(const RenderedView& view) {
  const cv::Mat rgb(
      view.height, view.width, CV_32FC3, const_cast<float*>(view.color.data()));
  cv::Mat levels;
  rgb.convertTo(levels, CV_8U, 255);
  cv::cvtColor(levels, levels, cv::COLOR_RGB2BGR);
  return levels;
}

cv::Mat1f DepthOf(const RenderedView& view) {
  return cv::Mat1f(
      view.height, view.width, const_cast<float*>(view.depth.data()));
}

}  // namespace

double LargestDepth(const FrameOptions& options) {
  return std::numeric_limits<uint16_t>::max() / options.depth_scale;
}

size_t WriteFrame(const RenderedView& view,
                  const std::string& name,
                  const FrameOptions& options,
                  const std::string& folder) {
  cv::Mat1f depth = DepthOf(view).clone();
  const cv::Mat too_deep = depth > LargestDepth(options);
  depth.setTo(0, too_deep);
  cv::Mat depth_levels;
  depth.convertTo(depth_levels, CV_16U, options.depth_scale);

  const fs::path path(folder);
  const std::string file_name = name + ".png";
  WritePng(path / "color" / file_name, ColorImage(view));
  WritePng(path / "depth" / file_name, depth_levels);
  WritePng(path / "depth_color" / file_name,
           DepthPicture(
               DepthOf(view), options.nearest_depth, options.farthest_depth));
  WritePng(path / "normal" / file_name,
           NormalPicture(view.normal, view.width, view.height));
  return cv::countNonZero(too_deep);
}

}  // namespace structnerf
