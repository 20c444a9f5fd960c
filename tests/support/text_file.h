#pragma once

#include <fstream>
#include <ios>
#include <iterator>
#include <string>

namespace structnerf {

// All of a file, byte by byte; empty if there is none.
inline std::string ReadText(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace structnerf
