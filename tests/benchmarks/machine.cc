#include "tests/benchmarks/machine.h"

#include "tests/benchmarks/roofline_probe.h"

#include <cstdio>
#include <map>
#include <thread>
#include <utility>

namespace structnerf {
namespace {

constexpr size_t kKilobyte = size_t{1} << 10;
constexpr size_t kMegabyte = size_t{1} << 20;

}  // namespace

const MachineRates& MeasuredRates(const FieldLayout& layout,
                                  const int num_threads) {
  static std::map<std::pair<int, double>, MachineRates> cache;
  const double table_bytes = TableBytes(layout);
  const auto [entry, is_new] =
      cache.emplace(std::make_pair(num_threads, table_bytes), MachineRates());
  if (is_new) {
    const RooflineProbe probe(num_threads);
    entry->second.clock = probe.ClockRate();
    entry->second.flops = probe.PeakFlops();
    entry->second.table_lines =
        probe.RandomLineRate(static_cast<size_t>(table_bytes));
    entry->second.bandwidth = probe.StreamBandwidth();
  }
  return entry->second;
}

void PrintMachine() {
  std::printf(
      "This machine, %u processors, %s; per thread and second of its processor "
      "time:\n",
      std::thread::hardware_concurrency(),
      SimdTargetInUse());
  for (const int num_threads : {1, 2}) {
    const RooflineProbe probe(num_threads);
    std::printf(
        "  %d thread%s: %.2f GHz, %.1f GFLOP/s, random lines of 256 KiB %.0f, "
        "of 8 MiB %.0f, of 128 MiB %.0f million, stream %.1f GB/s\n",
        num_threads,
        num_threads == 1 ? "" : "s",
        1e-9 * probe.ClockRate(),
        1e-9 * probe.PeakFlops(),
        1e-6 * probe.RandomLineRate(256 * kKilobyte),
        1e-6 * probe.RandomLineRate(8 * kMegabyte),
        1e-6 * probe.RandomLineRate(128 * kMegabyte),
        1e-9 * probe.StreamBandwidth());
  }
  std::fflush(stdout);
}

}  // namespace structnerf
