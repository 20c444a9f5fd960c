#include "tests/fuzz/fuzz_target.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

namespace structnerf {

void FuzzFault(const std::string& text) {
  std::fprintf(stderr, "FAULT: %s\n", text.c_str());
  std::abort();
}

void WriteFuzzFile(const std::string& path,
                   const uint8_t* data,
                   const size_t size) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(data),
             static_cast<std::streamsize>(size));
  if (!file.flush()) {
    FuzzFault("the test's own file " + path + " cannot be written");
  }
}

std::string ReadFuzzFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace structnerf
