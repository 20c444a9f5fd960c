#include "tests/end_to_end/json_files.h"

#include <fstream>

namespace structnerf {

nlohmann::json ReadJson(const std::string& path) {
  return nlohmann::json::parse(std::ifstream(path));
}

nlohmann::json ReadReport(const std::string& workspace_path) {
  return ReadJson(workspace_path + "/structnerf/report.json");
}

}  // namespace structnerf
