#include "colmap_plugin/memory_budget.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>
#include <thread>

#include <malloc.h>
#include <pthread.h>
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

// Address space that a thread takes before it has done anything: its stack, and
// what the C library sets aside for its allocations.
size_t ThreadAddressSpace() {
  constexpr size_t kHeapBytes = size_t{128} << 20;
  size_t stack_bytes = 0;
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_getstacksize(&attributes, &stack_bytes);
  pthread_attr_destroy(&attributes);
  return kHeapBytes + stack_bytes;
}

struct MemoryUse {
  size_t address_space = 0;
  size_t resident = 0;
};

MemoryUse PresentUse() {
  const auto page_size = static_cast<size_t>(sysconf(_SC_PAGESIZE));
  MemoryUse use;
  std::ifstream("/proc/self/statm") >> use.address_space >> use.resident;
  use.address_space *= page_size;
  use.resident *= page_size;
  return use;
}

// What `ulimit -v` leaves to be held, beside what is only set aside.
size_t AddressSpaceLimit() {
  rlimit limit;
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) {
    return std::numeric_limits<size_t>::max();
  }
  const MemoryUse use = PresentUse();
  const size_t set_aside =
      use.address_space - std::min(use.address_space, use.resident) +
      std::max(1u, std::thread::hardware_concurrency()) * ThreadAddressSpace();
  return limit.rlim_cur - std::min<size_t>(limit.rlim_cur, set_aside);
}

}  // namespace

size_t AvailableMemory() {
  const size_t physical = static_cast<size_t>(sysconf(_SC_PHYS_PAGES)) *
                          static_cast<size_t>(sysconf(_SC_PAGESIZE));
  return std::min(physical, ControlGroupLimit());
}

size_t MemoryLimit(const double max_memory_gb) {
  const size_t limit = max_memory_gb > 0
                           ? static_cast<size_t>(max_memory_gb * kBytesPerGb)
                           : AvailableMemory() / 4 * 3;
  return std::min(limit, AddressSpaceLimit());
}

size_t CurrentMemory() {
  malloc_trim(0);
  return PresentUse().resident;
}

size_t PeakMemory() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<size_t>(usage.ru_maxrss) * 1024;
}

}  // namespace structnerf
