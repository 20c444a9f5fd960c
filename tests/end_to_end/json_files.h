#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace structnerf {

// Both throw nlohmann::json::exception if the file is missing or no JSON.

nlohmann::json ReadJson(const std::string& path);

// Of the run that wrote the workspace.
nlohmann::json ReadReport(const std::string& workspace_path);

}  // namespace structnerf
