#include "colmap_plugin/json_text.h"

#include <nlohmann/json.hpp>

namespace structnerf {

std::string JsonText(const nlohmann::json& object) {
  return object.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) +
         "\n";
}

}  // namespace structnerf
