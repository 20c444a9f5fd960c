#pragma once

#include <memory>
#include <string>
#include <vector>

namespace structnerf {

// LPIPS (Zhang et al. 2018) by a TorchScript module of the user, whose weights
// are not part of this project. Its forward takes two float tensors,
//   image, reference   1 x 3 x height x width, RGB in [-1, 1]
// and returns one number.
class PerceptualModule {
 public:
  // Throws std::runtime_error, naming the file, if it is no TorchScript module.
  explicit PerceptualModule(const std::string& path);
  ~PerceptualModule();

  // Of two images in [0, 1], interleaved RGB, row-major, each 3 * width *
  // height. Throws std::runtime_error, naming the file, if the module fails or
  // returns something else than one finite number.
  double Measure(int width,
                 int height,
                 const std::vector<float>& image,
                 const std::vector<float>& reference) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace structnerf
