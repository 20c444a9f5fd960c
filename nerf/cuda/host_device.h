#pragma once

#include <cstdint>

// Marks functions that run on the device, and on the host for tests.
#ifdef __CUDACC__
#define STRUCTNERF_HOST_DEVICE __host__ __device__
#else
#define STRUCTNERF_HOST_DEVICE
#endif

namespace structnerf {

// *sum += value, whatever other threads do to it.
STRUCTNERF_HOST_DEVICE inline void AtomicAdd(const float value, float* sum) {
#ifdef __CUDA_ARCH__
  atomicAdd(sum, value);
#else
  float before;
  __atomic_load(sum, &before, __ATOMIC_RELAXED);
  float after = before + value;
  while (!__atomic_compare_exchange(
      sum, &before, &after, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
    after = before + value;
  }
#endif
}

// *largest = max(*largest, value), likewise. Neither may be negative or NaN.
STRUCTNERF_HOST_DEVICE inline void AtomicMax(const float value,
                                             float* largest) {
#ifdef __CUDA_ARCH__
  // Such numbers are ordered as their bits are.
  atomicMax(reinterpret_cast<unsigned*>(largest), __float_as_uint(value));
#else
  float before;
  __atomic_load(largest, &before, __ATOMIC_RELAXED);
  float after = value;
  while (
      before < value &&
      !__atomic_compare_exchange(
          largest, &before, &after, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
  }
#endif
}

// *flag = 1, likewise.
STRUCTNERF_HOST_DEVICE inline void AtomicSet(uint32_t* flag) {
#ifdef __CUDA_ARCH__
  atomicExch(flag, 1u);
#else
  __atomic_store_n(flag, 1u, __ATOMIC_RELAXED);
#endif
}

}  // namespace structnerf
