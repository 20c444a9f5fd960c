#include "nerf/perceptual_module.h"

#include "nerf/script_module.h"

#include <cmath>
#include <stdexcept>

namespace structnerf {
namespace {

torch::Tensor ImageTensor(const int width,
                          const int height,
                          const std::vector<float>& image) {
  return torch::from_blob(const_cast<float*>(image.data()),
                          {1, height, width, 3})
                 .permute({0, 3, 1, 2})
                 .contiguous() *
             2 -
         1;
}

}  // namespace

class PerceptualModule::Impl {
 public:
  std::string path;
  torch::jit::Module module;
};

PerceptualModule::PerceptualModule(const std::string& path)
    : impl_(std::make_unique<Impl>()) {
  impl_->path = path;
  impl_->module = LoadScriptModule(path);
}

PerceptualModule::~PerceptualModule() = default;

double PerceptualModule::Measure(const int width,
                                 const int height,
                                 const std::vector<float>& image,
                                 const std::vector<float>& reference) const {
  try {
    const torch::NoGradGuard no_grad;
    const double distance =
        impl_->module
            .forward({ImageTensor(width, height, image),
                      ImageTensor(width, height, reference)})
            .toTensor()
            .item<double>();
    if (!std::isfinite(distance)) {
      throw std::runtime_error("the result is not a finite number");
    }
    return distance;
  } catch (const std::exception& error) {
    throw std::runtime_error(
        "The module " + impl_->path +
        " must map two images of 1 x 3 x height x width in [-1, 1] to one "
        "number, but it failed: " +
        FirstLine(error));
  }
}

}  // namespace structnerf
