#pragma once

#include <string>

namespace structnerf {

// Something that the scene, not the user, has decided about how it is modelled,
// with the number that decided it.
struct SceneDecision {
  std::string subject;  // e.g. "finest grid level"
  std::string choice;   // e.g. "512 cells"
  std::string reason;   // e.g. "a pixel covers 0.3 % of the median depth"

  // "subject: choice (reason)".
  std::string Text() const {
    return subject + ": " + choice + " (" + reason + ")";
  }
};

}  // namespace structnerf
