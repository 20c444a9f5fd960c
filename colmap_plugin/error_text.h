#pragma once

#include <string>

namespace structnerf {

// One sentence for people about the exception that is being handled, whatever
// its type. To be called in a catch block.
std::string CurrentErrorText();

}  // namespace structnerf
