#pragma once

#include "tests/support/json_file.h"

#include <string>

namespace structnerf {

// Of the run that wrote the workspace. Throws as ReadJson does.
nlohmann::json ReadReport(const std::string& workspace_path);

}  // namespace structnerf
