#include "nerf/cuda/cuda_engine.h"

#include "nerf/cuda/cuda_device.h"
#include "nerf/cuda/device_engine-inl.h"

#include <stdexcept>
#include <utility>

namespace structnerf {

std::unique_ptr<RenderEngine> MakeCudaEngine(
    const EngineOptions& options,
    std::function<void(const std::string&)> warn) {
  if (options.field.type != "grid") {
    throw std::invalid_argument("the field " + options.field.type +
                                " does not run on a graphics card");
  }
  return std::make_unique<DeviceEngine<CudaDevice>>(
      options, std::make_unique<CudaDevice>(), std::move(warn));
}

}  // namespace structnerf
