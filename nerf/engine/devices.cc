#include "nerf/engine/devices.h"

#include "nerf/engine/render_engine.h"
#include "nerf/engine/torch_factory.h"

#include <stdexcept>
#include <utility>

#ifdef STRUCTNERF_CUDA
#include "nerf/cuda/cuda_device.h"
#include "nerf/cuda/cuda_engine.h"
#endif

namespace structnerf {
namespace {

// Why there is no card for the field, to follow "but"; empty if there is one.
std::string WhyNotCuda(const std::string& field_type) {
#ifdef STRUCTNERF_CUDA
  if (field_type != "grid") {
    return "the field " + field_type +
           " of --StructNeRF.field does not run on a graphics card";
  }
  try {
    const CudaDevice probe;
    return "";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
#else
  static_cast<void>(field_type);
  return "this program was built without CUDA (CMake's STRUCTNERF_CUDA, which "
         "needs nvcc)";
#endif
}

}  // namespace

std::string ResolveDevice(const std::string& device,
                          const std::string& field_type) {
  const std::string prefix =
      "The option --StructNeRF.device is " + device + ", but ";
  if (device == "cpu") {
    return device;
  }
  if (device != "auto" && device != "cuda") {
    throw std::invalid_argument(prefix + "must be auto, cpu or cuda.");
  }
  const std::string reason = WhyNotCuda(field_type);
  if (reason.empty()) {
    return "cuda";
  }
  if (device == "auto") {
    return "cpu";
  }
  throw std::invalid_argument(prefix + reason + "; choose auto or cpu.");
}

EngineFactory EnginesOfDevice(const std::string& device,
                              std::function<void(const std::string&)> warn) {
#ifdef STRUCTNERF_CUDA
  if (device == "cuda") {
    return [warn = std::move(warn)](const EngineOptions& options) {
      return MakeCudaEngine(options, warn);
    };
  }
#else
  static_cast<void>(warn);
#endif
  if (device != "cpu") {
    throw std::invalid_argument("there is no device " + device);
  }
  return MakeAnyEngine;
}

}  // namespace structnerf
