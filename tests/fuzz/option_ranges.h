#pragma once

#include "nerf/option_entry.h"
#include "tests/fuzz/fuzz_target.h"

#include <type_traits>
#include <variant>
#include <vector>

namespace structnerf {

// What was accepted must be in the range that the help names.
inline void RequireOptionsInRange(const std::vector<OptionEntry>& table) {
  for (const OptionEntry& entry : table) {
    std::visit(
        [&](const auto* value) {
          if constexpr (!std::is_same_v<decltype(value), const std::string*>) {
            // Not the other way round, so that NaN is in no range.
            if (!(*value >= entry.min_value && *value <= entry.max_value)) {
              FuzzFault("the option " + entry.name + " is out of its range");
            }
          }
        },
        entry.value);
  }
}

}  // namespace structnerf
