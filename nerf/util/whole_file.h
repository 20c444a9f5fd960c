#pragma once

#include <functional>
#include <ostream>
#include <string>

namespace structnerf {

// Writes a file beside its name and renames it when it is complete: there is
// the old file or the new one, never half of it. Throws std::runtime_error,
// naming the file, if the disk is full or cannot be written.
void WriteWholeFile(const std::string& path,
                    const std::function<void(std::ostream*)>& write);

}  // namespace structnerf
