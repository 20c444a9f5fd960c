#pragma once

#include <string>

namespace structnerf {

// Whether a name, appended to a folder, is a file in that folder and fits a
// line of a text file.
bool IsSafeImageName(const std::string& name);

// The name with control characters shown as '?', so that an error stays one
// line.
std::string Printable(std::string name);

}  // namespace structnerf
