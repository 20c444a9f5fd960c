#pragma once

#include <cstddef>
#include <string>

namespace structnerf {

constexpr double kBytesPerGb = 1024.0 * 1024.0 * 1024.0;

// What control groups, version 2 or 1, leave a process, in bytes: the least
// limit of its group and of those around it. `folder`: where the groups are
// seen. `membership_path`: a file that says which group the process is in, see
// cgroups(7). The largest number there is if they set no limit ("max") or are
// not understood.
size_t ControlGroupLimit(const std::string& folder,
                         const std::string& membership_path);

// Memory in bytes that processes here can have: what is installed, or the
// limit of the control group (container) if that is smaller.
size_t AvailableMemory();

// The limit that the option --StructNeRF.max_memory_gb stands for, in bytes:
// three quarters of AvailableMemory() if it is not positive. Less if the limit
// of the address space (`ulimit -v`) would be hit before.
size_t MemoryLimit(double max_memory_gb);

// Memory in bytes that this process holds, after it has given back what it can.
size_t CurrentMemory();

// The most memory in bytes that this process has held so far.
size_t PeakMemory();

}  // namespace structnerf
