#include "colmap_plugin/memory_budget.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

namespace structnerf {
namespace {

// Control groups version 2 and 1 as a container sees them. "max", or a number
// beyond the installed memory, means no limit.
size_t ControlGroupLimit() {
  size_t limit = std::numeric_limits<size_t>::max();
  for (const char* path : {"/sys/fs/cgroup/memory.max",
                           "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    size_t value = 0;
    if (std::ifstream(path) >> value && value > 0) {
      limit = std::min(limit, value);
    }
  }
  return limit;
}

}  // namespace

size_t AvailableMemory() {
  const size_t physical = static_cast<size_t>(sysconf(_SC_PHYS_PAGES)) *
                          static_cast<size_t>(sysconf(_SC_PAGESIZE));
  return std::min(physical, ControlGroupLimit());
}

size_t MemoryLimit(const double max_memory_gb) {
  return max_memory_gb > 0 ? static_cast<size_t>(max_memory_gb * kBytesPerGb)
                           : AvailableMemory() / 4 * 3;
}

size_t CurrentMemory() {
  malloc_trim(0);
  size_t num_pages = 0;
  size_t num_resident_pages = 0;
  std::ifstream("/proc/self/statm") >> num_pages >> num_resident_pages;
  return num_resident_pages * static_cast<size_t>(sysconf(_SC_PAGESIZE));
}

size_t PeakMemory() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<size_t>(usage.ru_maxrss) * 1024;
}

}  // namespace structnerf
