#include "colmap_plugin/memory_budget.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
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

namespace fs = std::filesystem;

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

// Of a control group, in bytes.
constexpr const char* kLimitName = "memory.max";
constexpr const char* kLimitNameOfVersion1 = "memory.limit_in_bytes";

// The largest number there is if the file holds none.
size_t ReadLimit(const fs::path& path) {
  std::string text;
  std::ifstream(path) >> text;
  size_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && rest == end && value > 0
             ? value
             : std::numeric_limits<size_t>::max();
}

}  // namespace

size_t ControlGroupLimit(const std::string& folder,
                         const std::string& membership_path) {
  const fs::path hierarchy_of_version1 = fs::path(folder) / "memory";
  // In a container, the outermost group that is seen is its own.
  size_t limit =
      std::min(ReadLimit(fs::path(folder) / kLimitName),
               ReadLimit(hierarchy_of_version1 / kLimitNameOfVersion1));
  std::ifstream memberships(membership_path);
  for (std::string line; std::getline(memberships, line);) {
    // hierarchy:controllers:/group
    const size_t first = line.find(':');
    const size_t second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) {
      continue;
    }
    const std::string controllers =
        "," + line.substr(first + 1, second - first - 1) + ",";
    const bool is_version1 = controllers.find(",memory,") != std::string::npos;
    if (!is_version1 && controllers != ",,") {
      continue;
    }
    for (fs::path group = fs::path(line.substr(second + 1)).relative_path();
         !group.empty();
         group = group.parent_path()) {
      limit = std::min(
          limit,
          is_version1
              ? ReadLimit(hierarchy_of_version1 / group / kLimitNameOfVersion1)
              : ReadLimit(fs::path(folder) / group / kLimitName));
    }
  }
  return limit;
}

size_t AvailableMemory() {
  const size_t physical = static_cast<size_t>(sysconf(_SC_PHYS_PAGES)) *
                          static_cast<size_t>(sysconf(_SC_PAGESIZE));
  return std::min(physical,
                  ControlGroupLimit("/sys/fs/cgroup", "/proc/self/cgroup"));
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
