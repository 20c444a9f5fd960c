#pragma once

#include "nerf/cuda/device_buffer.h"
#include "nerf/util/thread_pool.h"

#include <cstddef>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#ifdef STRUCTNERF_CUDA
#include "nerf/cuda/cuda_device.h"
#endif

namespace structnerf {

// Runs kernels on threads of the processor. Its memory can be made small.
class HostDevice {
 public:
  explicit HostDevice(
      const size_t max_bytes = std::numeric_limits<size_t>::max())
      : max_bytes_(max_bytes), pool_(2) {}

  void* Allocate(const size_t num_bytes) {
    if (num_bytes > max_bytes_ - num_bytes_) {
      throw DeviceOutOfMemory();
    }
    void* const data = ::operator new(num_bytes);
    sizes_[data] = num_bytes;
    num_bytes_ += num_bytes;
    return data;
  }
  void Free(void* data) {
    num_bytes_ -= sizes_[data];
    sizes_.erase(data);
    ::operator delete(data);
  }
  size_t NumBytes() const { return num_bytes_; }

  void Clear(void* data, const size_t num_bytes) {
    std::memset(data, 0, num_bytes);
  }
  void Upload(const void* from, const size_t num_bytes, void* to) {
    std::memcpy(to, from, num_bytes);
  }
  void Download(const void* from, const size_t num_bytes, void* to) {
    std::memcpy(to, from, num_bytes);
  }

  // Neighbouring calls are made by different threads, as on a card: what they
  // do to the same memory, a thread sanitizer finds.
  template <class Kernel>
  void Launch(const Kernel& kernel, const size_t count) {
    const size_t num_threads = pool_.NumThreads();
    pool_.ParallelFor(num_threads, [&](const size_t first, int /*thread*/) {
      for (size_t i = first; i < count; i += num_threads) {
        kernel(i);
      }
    });
  }

 private:
  const size_t max_bytes_;
  size_t num_bytes_ = 0;
  std::map<void*, size_t> sizes_;
  ThreadPool pool_;
};

#ifdef STRUCTNERF_CUDA
using TestDevices = testing::Types<HostDevice, CudaDevice>;
#else
using TestDevices = testing::Types<HostDevice>;
#endif

// A test on a device, skipped without one.
template <class DeviceType>
class DeviceTest : public testing::Test {
 protected:
  using Device = DeviceType;
  using Floats = DeviceBuffer<float, Device>;

  void SetUp() override {
    try {
      device_ = std::make_unique<Device>();
    } catch (const std::runtime_error& error) {
      GTEST_SKIP() << error.what();
    }
  }

  std::unique_ptr<Floats> Upload(const std::vector<float>& values) const {
    auto buffer = std::make_unique<Floats>(device_.get());
    buffer->Upload(values);
    return buffer;
  }

  static void ExpectNear(const std::vector<float>& actual,
                         const std::vector<float>& expected,
                         const double tolerance) {
    ASSERT_EQ(actual.size(), expected.size());
    for (size_t i = 0; i < actual.size(); ++i) {
      ASSERT_NEAR(actual[i], expected[i], tolerance) << i;
    }
  }

  std::unique_ptr<Device> device_;
};

}  // namespace structnerf
