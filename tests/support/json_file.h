#pragma once

#include <fstream>
#include <stdexcept>
#include <string>

#include <nlohmann/json.hpp>

namespace structnerf {

// Throws std::runtime_error, naming the file, if it is missing or no JSON.
inline nlohmann::json ReadJson(const std::string& path) {
  std::ifstream file(path);
  try {
    return nlohmann::json::parse(file);
  } catch (const nlohmann::json::exception& error) {
    throw std::runtime_error("The file " + path + " is missing or no JSON (" +
                             error.what() + ").");
  }
}

}  // namespace structnerf
