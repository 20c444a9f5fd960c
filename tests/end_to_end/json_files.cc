#include "tests/end_to_end/json_files.h"

namespace structnerf {

nlohmann::json ReadReport(const std::string& workspace_path) {
  return ReadJson(workspace_path + "/structnerf/report.json");
}

}  // namespace structnerf
