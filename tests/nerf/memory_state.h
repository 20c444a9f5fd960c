#pragma once

#include "nerf/util/state_stream.h"

#include <algorithm>
#include <vector>

namespace structnerf {

// A state in memory, to be written and then read.
class MemoryState : public StateWriter, public StateReader {
 public:
  void Write(const void* data, const size_t num_bytes) override {
    const char* const begin = static_cast<const char*>(data);
    bytes.insert(bytes.end(), begin, begin + num_bytes);
  }

  void Read(void* data, const size_t num_bytes) override {
    if (num_bytes > NumBytesLeft()) {
      throw std::runtime_error("the state ends too early");
    }
    std::copy_n(bytes.data() + num_read, num_bytes, static_cast<char*>(data));
    num_read += num_bytes;
  }

  size_t NumBytesLeft() const override { return bytes.size() - num_read; }

  std::vector<char> bytes;
  size_t num_read = 0;
};

}  // namespace structnerf
