#pragma once

#include <string>
#include <vector>

namespace structnerf {

// Runs a program and waits for it. It has our standard error, and our standard
// output if `keep_output`, else none. Returns its exit code, -1 if it could not
// be run or a signal ended it. While ScopedInterrupts lives, a SIGTERM is
// passed on to the program.
int RunChildProcess(const std::string& path,
                    const std::vector<std::string>& arguments,
                    bool keep_output);

}  // namespace structnerf
