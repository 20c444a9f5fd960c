#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <type_traits>
#include <vector>

namespace structnerf {

// Where something that will be continued later writes what it must know then,
// as plain bytes in the order of this machine.
class StateWriter {
 public:
  virtual ~StateWriter() = default;

  // Throws std::runtime_error if that fails.
  virtual void Write(const void* data, size_t num_bytes) = 0;

  template <typename T>
  void WriteValue(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    Write(&value, sizeof(value));
  }

  // Their number and the elements; T is a plain type or std::string's char.
  template <typename Container>
  void WriteArray(const Container& values) {
    static_assert(std::is_trivially_copyable_v<typename Container::value_type>);
    WriteValue(static_cast<uint64_t>(values.size()));
    Write(values.data(), values.size() * sizeof(*values.data()));
  }
};

// Reads what a StateWriter has written, in the same order.
class StateReader {
 public:
  virtual ~StateReader() = default;

  // Throws std::runtime_error if there are fewer bytes.
  virtual void Read(void* data, size_t num_bytes) = 0;

  virtual size_t NumBytesLeft() const = 0;

  template <typename T>
  T ReadValue() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value;
    Read(&value, sizeof(value));
    return value;
  }

  // A vector or string of whatever length was written.
  template <typename Container>
  Container ReadArray() {
    const uint64_t size = ReadValue<uint64_t>();
    if (size > NumBytesLeft() / sizeof(typename Container::value_type)) {
      throw std::runtime_error("the state ends too early");
    }
    Container values;
    values.resize(static_cast<size_t>(size));
    Read(values.data(), values.size() * sizeof(*values.data()));
    return values;
  }
};

}  // namespace structnerf
