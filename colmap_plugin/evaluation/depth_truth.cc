#include "colmap_plugin/evaluation/depth_truth.h"

#include "colmap_plugin/image_file.h"
#include "colmap_plugin/text_output.h"
#include "nerf/util/median.h"

#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

constexpr int kNoValue = 65535;

// What rooms, and even buildings, do not exceed, in metres. Error thresholds
// in centimetres mean nothing outside.
constexpr double kMinMedianDepth = 0.01;
constexpr double kMaxMedianDepth = 1000;

// Largest relative difference of width and height ratios, to allow for sizes
// that were rounded.
constexpr double kMaxAspectError = 0.02;

// Of an image's file in a folder of them.
std::string FilePath(const std::string& folder, const std::string& image_name) {
  const std::string replaced =
      (fs::path(folder) / fs::path(image_name).replace_extension(".png"))
          .string();
  return fs::exists(replaced)
             ? replaced
             : (fs::path(folder) / (image_name + ".png")).string();
}

void CheckFolder(const std::string& path, const std::string& option) {
  if (!fs::is_directory(path)) {
    throw std::runtime_error("The folder " + path + " of --" + option +
                             " does not exist.");
  }
}

void CheckMedian(const cv::Mat1f& depth,
                 const std::string& path,
                 const double scale) {
  std::vector<float> values;
  for (const float value : depth) {
    if (value > 0) {
      values.push_back(value);
    }
  }
  if (values.empty()) {
    return;
  }
  const double median = Median(&values);
  if (median < kMinMedianDepth || median > kMaxMedianDepth) {
    throw std::runtime_error("The ground truth " + path +
                             " has a median depth of " +
                             FormatNumber("%g", median) + " m; --depth_scale " +
                             FormatNumber("%g", scale) +
                             " (its value for one metre) must be wrong.");
  }
}

}  // namespace

void DepthTruthOptions::Check() const {
  if (path.empty()) {
    throw std::runtime_error("The option --ground_truth_path is missing.");
  }
  CheckFolder(path, "ground_truth_path");
  if (!mask_path.empty()) {
    CheckFolder(mask_path, "ground_truth_mask_path");
  }
  if (!(scale > 0) || !std::isfinite(scale)) {
    throw std::runtime_error(
        "The option --depth_scale must be positive, but is " +
        FormatNumber("%g", scale) + ".");
  }
  if (!(min_depth >= 0) || !(max_depth >= 0) ||
      (max_depth > 0 && max_depth <= min_depth)) {
    throw std::runtime_error(
        "The options --min_depth and --max_depth must be a range of positive "
        "depths; 0 = no limit.");
  }
}

DepthTruth::DepthTruth(const DepthTruthOptions& options) : options_(options) {
  options_.Check();
}

bool DepthTruth::Has(const std::string& image_name) const {
  return fs::exists(FilePath(options_.path, image_name));
}

cv::Mat1f DepthTruth::Read(const std::string& image_name,
                           const colmap::Camera& camera) const {
  const std::string path = FilePath(options_.path, image_name);
  const cv::Mat raw = cv::imread(path, cv::IMREAD_UNCHANGED);
  if (raw.type() != CV_16UC1) {
    throw std::runtime_error(
        "The ground truth " + path +
        (raw.empty() ? " cannot be read." : " is not a 16-bit grey image."));
  }
  const double ratio = (static_cast<double>(raw.cols) / camera.width) /
                       (static_cast<double>(raw.rows) / camera.height);
  if (std::abs(ratio - 1) > kMaxAspectError) {
    throw std::runtime_error(
        "The ground truth " + path + " is " + SizeText(raw.cols, raw.rows) +
        ", but the camera of its image is " +
        SizeText(camera.width, camera.height) +
        "; the two must show the same field of view. If the truth belongs to "
        "the original images, pass their model as --input_path.");
  }
  cv::Mat1f depth(raw.size(), 0.0f);
  for (int row = 0; row < raw.rows; ++row) {
    for (int col = 0; col < raw.cols; ++col) {
      const int value = raw.at<uint16_t>(row, col);
      const double metres = value / options_.scale;
      if (value != 0 && value != kNoValue && metres >= options_.min_depth &&
          (options_.max_depth == 0 || metres <= options_.max_depth)) {
        depth(row, col) = static_cast<float>(metres);
      }
    }
  }
  CheckMedian(depth, path, options_.scale);
  return depth;
}

cv::Mat1f DepthTruth::ReadMasked(const std::string& image_name,
                                 const colmap::Camera& camera) const {
  cv::Mat1f depth = Read(image_name, camera);
  if (!options_.mask_path.empty()) {
    const std::string path = FilePath(options_.mask_path, image_name);
    cv::Mat1b mask = ReadGreyImage(path);
    if (mask.empty()) {
      throw std::runtime_error("The mask of the ground truth " + path +
                               " cannot be read.");
    }
    cv::resize(mask, mask, depth.size(), 0, 0, cv::INTER_NEAREST);
    depth.setTo(0, mask == 0);
  }
  return depth;
}

}  // namespace structnerf
