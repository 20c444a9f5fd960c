#pragma once

#include <cstddef>
#include <memory>

namespace structnerf {

// The first NVIDIA device, as a Device of DeviceBuffer.
class CudaDevice {
 public:
  // Throws std::runtime_error, saying why in words that can follow "but", if
  // there is none that can be used.
  CudaDevice();
  ~CudaDevice();

  CudaDevice(const CudaDevice&) = delete;
  CudaDevice& operator=(const CudaDevice&) = delete;

  void* Allocate(size_t num_bytes);
  void Free(void* data);
  void Clear(void* data, size_t num_bytes);
  void Upload(const void* from, size_t num_bytes, void* to);
  void Download(const void* from, size_t num_bytes, void* to);

  // For the kernels of this folder.
  template <class Kernel>
  void Launch(const Kernel& kernel, size_t count);

 private:
  struct Stream;
  std::unique_ptr<Stream> stream_;
};

}  // namespace structnerf
