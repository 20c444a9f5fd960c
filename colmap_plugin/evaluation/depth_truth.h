#pragma once

#include <string>

#include <colmap/scene/camera.h>

#include <opencv2/core.hpp>

namespace structnerf {

struct DepthTruthOptions {
  // Folder with one 16-bit grey PNG per image, "<image name without its
  // extension>.png" or "<image name>.png", aligned with the original image, at
  // its resolution or another one; 0 and 65535 = no value.
  std::string path;

  // Folder with one mask per image, named and aligned alike: where it is black,
  // nothing is compared with the truth, which still tells the scale. Empty =
  // everything is compared.
  std::string mask_path;

  // What the PNG says for one metre: 1000 for millimetres.
  double scale = 1000;

  // Metres; truth outside counts as no value. 0 = no limit.
  double min_depth = 0;
  double max_depth = 0;

  // Throws std::runtime_error, naming the option, if one is wrong.
  void Check() const;
};

// Ground-truth depth of the images of a model: z in the camera frame.
class DepthTruth {
 public:
  // Throws std::runtime_error if the options are wrong.
  explicit DepthTruth(const DepthTruthOptions& options);

  bool Has(const std::string& image_name) const;
  bool HasMasks() const { return !options_.mask_path.empty(); }

  // Metres, 0 = no value. Throws std::runtime_error, naming the file, if it is
  // missing or no 16-bit grey image, does not have the proportions of the
  // image's `camera`, or is so near or far that the scale must be wrong.
  cv::Mat1f Read(const std::string& image_name,
                 const colmap::Camera& camera) const;

  // The same where the mask is not black. Throws std::runtime_error, naming the
  // mask, if it cannot be read.
  cv::Mat1f ReadMasked(const std::string& image_name,
                       const colmap::Camera& camera) const;

 private:
  const DepthTruthOptions options_;
};

}  // namespace structnerf
