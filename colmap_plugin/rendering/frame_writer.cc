#include "colmap_plugin/rendering/frame_writer.h"

#include "colmap_plugin/evaluation/map_pictures.h"
#include "colmap_plugin/png_file.h"

#include <cmath>
#include <filesystem>
#include <limits>

#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

void WriteImage(const fs::path& path, const cv::Mat& image) {
  // WritePng names the file where there is no folder for it.
  std::error_code ignored;
  fs::create_directories(path.parent_path(), ignored);
  WritePng(path.string(), image);
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
  WriteImage(path / kColorFolder / file_name, ColorImage(view));
  WriteImage(path / kDepthFolder / file_name, depth_levels);
  WriteImage(path / kDepthColorFolder / file_name,
             DepthPicture(
                 DepthOf(view), options.nearest_depth, options.farthest_depth));
  WriteImage(path / kNormalFolder / file_name,
             NormalPicture(view.normal, view.width, view.height));
  return cv::countNonZero(too_deep);
}

}  // namespace structnerf
