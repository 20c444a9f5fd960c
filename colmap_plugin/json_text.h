#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

namespace structnerf {

// The text of a JSON file, indented. Whatever is no UTF-8, as paths may be, is
// replaced.
std::string JsonText(const nlohmann::json& object);

}  // namespace structnerf
