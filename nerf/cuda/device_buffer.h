#pragma once

#include <cstddef>
#include <stdexcept>
#include <vector>

namespace structnerf {

// Thrown when a device has no memory left.
struct DeviceOutOfMemory : std::runtime_error {
  DeviceOutOfMemory()
      : std::runtime_error(
            "The memory of the graphics card does not suffice; lower "
            "--StructNeRF.log2_table_size or choose --StructNeRF.device cpu.") {
  }
};

// An array in the memory of a device. A Device has
//   void* Allocate(size_t num_bytes), void Free(void*)
//   void Clear(void*, size_t num_bytes)                       sets to zero
//   void Upload(const void* from, size_t num_bytes, void* to)
//   void Download(const void* from, size_t num_bytes, void* to)
//   void Launch(const Kernel& kernel, size_t count)  calls kernel(i), i <
//   count,
//                                                    in no order
// which take effect in the order of the calls. Download() waits; Upload() has
// read `from` when it returns. Allocate() throws DeviceOutOfMemory, all throw
// std::runtime_error if the device fails.
template <class T, class Device>
class DeviceBuffer {
 public:
  explicit DeviceBuffer(Device* device) : device_(device) {}
  DeviceBuffer(const size_t size, Device* device) : device_(device) {
    Reserve(size);
  }
  ~DeviceBuffer() { Release(); }

  DeviceBuffer(const DeviceBuffer&) = delete;
  DeviceBuffer& operator=(const DeviceBuffer&) = delete;

  // Makes room for `size` elements. If there was less, all are zero then.
  void Reserve(const size_t size) {
    if (size > size_) {
      Release();
      data_ = static_cast<T*>(device_->Allocate(size * sizeof(T)));
      size_ = size;
      Clear(size);
    }
  }

  // Gives the memory back.
  void Release() {
    device_->Free(data_);
    data_ = nullptr;
    size_ = 0;
  }

  void Clear(const size_t count) { device_->Clear(data_, count * sizeof(T)); }

  void Upload(const T* from, const size_t count) {
    device_->Upload(from, count * sizeof(T), data_);
  }

  // Makes room first.
  void Upload(const std::vector<T>& from) {
    Reserve(from.size());
    Upload(from.data(), from.size());
  }

  std::vector<T> Download(const size_t count) const {
    std::vector<T> values(count);
    device_->Download(data_, count * sizeof(T), values.data());
    return values;
  }

  T* data() { return data_; }
  const T* data() const { return data_; }
  size_t size() const { return size_; }

 private:
  Device* const device_;
  T* data_ = nullptr;
  size_t size_ = 0;
};

}  // namespace structnerf
