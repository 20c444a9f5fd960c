#include "colmap_plugin/memory_budget.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <limits>
#include <system_error>
#include <thread>

#include <malloc.h>
#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

namespace structnerf {
namespace {

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

size_t ControlGroupLimit(const std::string& folder) {
  size_t limit = std::numeric_limits<size_t>::max();
  // Version 2, then version 1.
  for (const char* name : {"/memory.max", "/memory/memory.limit_in_bytes"}) {
    std::string text;
    std::ifstream(folder + name) >> text;
    size_t value = 0;
    const char* const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, value);
    if (error == std::errc() && rest == end && value > 0) {
      limit = std::min(limit, value);
    }
  }
  return limit;
}

size_t AvailableMemory() {
  const size_t physical = static_cast<size_t>(sysconf(_SC_PHYS_PAGES)) *
                          static_cast<size_t>(sysconf(_SC_PAGESIZE));
  return std::min(physical, ControlGroupLimit("/sys/fs/cgroup"));
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
