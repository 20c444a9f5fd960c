#include "nerf/cuda/adam-inl.h"
#include "nerf/cuda/compositing-inl.h"
#include "nerf/cuda/cuda_device.h"
#include "nerf/cuda/dense_layer-inl.h"
#include "nerf/cuda/device_buffer.h"
#include "nerf/cuda/grid_encoding-inl.h"

#include <memory>
#include <stdexcept>
#include <string>

#include <cuda_runtime.h>

namespace structnerf {
namespace {

constexpr unsigned kBlockThreads = 256;

void Check(const cudaError_t error, const char* what) {
  if (error != cudaSuccess) {
    throw std::runtime_error(std::string("The graphics card failed to ") +
                             what + " (" + cudaGetErrorString(error) +
                             "); --StructNeRF.device cpu does without it.");
  }
}

template <class Kernel>
__global__ void __launch_bounds__(kBlockThreads)
    CallForEach(const Kernel kernel, const size_t count) {
  const size_t i =
      static_cast<size_t>(blockIdx.x) * kBlockThreads + threadIdx.x;
  if (i < count) {
    kernel(i);
  }
}

}  // namespace

struct CudaDevice::Stream {
  cudaStream_t stream = nullptr;
};

CudaDevice::CudaDevice() : stream_(std::make_unique<Stream>()) {
  int num_devices = 0;
  cudaError_t error = cudaGetDeviceCount(&num_devices);
  if (error == cudaSuccess && num_devices == 0) {
    error = cudaErrorNoDevice;
  }
  if (error == cudaSuccess) {
    // Fails if the program has no code for the card, or the driver is too old.
    cudaFuncAttributes attributes;
    error = cudaFuncGetAttributes(&attributes, CallForEach<CopyColumnKernel>);
  }
  if (error == cudaSuccess) {
    error = cudaStreamCreate(&stream_->stream);
  }
  if (error != cudaSuccess) {
    cudaGetLastError();  // else the next device would be said to have failed
    // CUDA's own words for this would say that there is a driver.
    const std::string reason = error == cudaErrorInsufficientDriver
                                   ? "its driver is missing or too old"
                                   : cudaGetErrorString(error);
    throw std::runtime_error(
        "there is no NVIDIA graphics card that can be used (" + reason + ")");
  }
}

CudaDevice::~CudaDevice() { cudaStreamDestroy(stream_->stream); }

void* CudaDevice::Allocate(const size_t num_bytes) {
  void* data = nullptr;
  const cudaError_t error = cudaMalloc(&data, num_bytes);
  if (error == cudaErrorMemoryAllocation) {
    cudaGetLastError();  // else the next kernel would be said to have failed
    throw DeviceOutOfMemory();
  }
  Check(error, "give memory");
  return data;
}

void CudaDevice::Free(void* data) { cudaFree(data); }

void CudaDevice::Clear(void* data, const size_t num_bytes) {
  Check(cudaMemsetAsync(data, 0, num_bytes, stream_->stream), "clear memory");
}

void CudaDevice::Upload(const void* from, const size_t num_bytes, void* to) {
  Check(cudaMemcpyAsync(
            to, from, num_bytes, cudaMemcpyHostToDevice, stream_->stream),
        "take data");
  // Whether `from` has been read by now depends on machine and driver.
  Check(cudaStreamSynchronize(stream_->stream), "take data");
}

void CudaDevice::Download(const void* from, const size_t num_bytes, void* to) {
  Check(cudaMemcpyAsync(
            to, from, num_bytes, cudaMemcpyDeviceToHost, stream_->stream),
        "give data");
  Check(cudaStreamSynchronize(stream_->stream), "finish");
}

template <class Kernel>
void CudaDevice::Launch(const Kernel& kernel, const size_t count) {
  if (count == 0) {
    return;
  }
  const size_t num_blocks = (count + kBlockThreads - 1) / kBlockThreads;
  CallForEach<<<static_cast<unsigned>(num_blocks),
                kBlockThreads,
                0,
                stream_->stream>>>(kernel, count);
  Check(cudaGetLastError(), "start a kernel");
}

template void CudaDevice::Launch(const AddToColumnKernel&, size_t);
template void CudaDevice::Launch(const AdamGridKernel&, size_t);
template void CudaDevice::Launch(const AdamKernel&, size_t);
template void CudaDevice::Launch(const CheckGradientKernel&, size_t);
template void CudaDevice::Launch(const CompositeBackwardKernel&, size_t);
template void CudaDevice::Launch(const CompositeColorBackwardKernel&, size_t);
template void CudaDevice::Launch(const CompositeColorKernel&, size_t);
template void CudaDevice::Launch(const CompositeForwardKernel&, size_t);
template void CudaDevice::Launch(const CopyColumnKernel&, size_t);
template void CudaDevice::Launch(const DenseBackwardInputKernel&, size_t);
template void CudaDevice::Launch(const DenseBackwardWeightsKernel&, size_t);
template void CudaDevice::Launch(const DenseForwardKernel&, size_t);
template void CudaDevice::Launch(const GridBackwardKernel&, size_t);
template void CudaDevice::Launch(const GridEncodeKernel&, size_t);
template void CudaDevice::Launch(const LargestGradientKernel&, size_t);
template void CudaDevice::Launch(const SumChunksKernel&, size_t);
template void CudaDevice::Launch(const SumGroupsKernel&, size_t);
template void CudaDevice::Launch(const TransposeKernel&, size_t);

}  // namespace structnerf
