#pragma once

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <type_traits>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace structnerf {

// Zero-initialised array of plain numbers, aligned to cache lines so that
// vector loads never straddle two. Large ones ask for huge pages: random reads
// of a grid table otherwise miss the TLB more often than the cache.
template <typename T>
class AlignedBuffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  AlignedBuffer() = default;
  explicit AlignedBuffer(const size_t size) { Allocate(size); }

  // Loses what was in it.
  void Allocate(const size_t size) {
    constexpr size_t kCacheLine = 64;
    constexpr size_t kHugePage = size_t{2} << 20;
    const size_t alignment =
        size * sizeof(T) >= kHugePage ? kHugePage : kCacheLine;
    const size_t num_bytes =
        (size * sizeof(T) + alignment - 1) / alignment * alignment;
    T* const data = static_cast<T*>(
        std::aligned_alloc(alignment, num_bytes > 0 ? num_bytes : alignment));
    if (data == nullptr) {
      throw std::bad_alloc();
    }
#ifdef __linux__
    if (alignment == kHugePage) {
      madvise(data, num_bytes, MADV_HUGEPAGE);
    }
#endif
    std::memset(static_cast<void*>(data), 0, num_bytes);
    data_.reset(data);
    size_ = size;
  }

  size_t size() const { return size_; }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  T& operator[](const size_t i) { return data_.get()[i]; }
  const T& operator[](const size_t i) const { return data_.get()[i]; }

 private:
  struct Free {
    void operator()(T* data) const { std::free(data); }
  };
  std::unique_ptr<T[], Free> data_;
  size_t size_ = 0;
};

}  // namespace structnerf
