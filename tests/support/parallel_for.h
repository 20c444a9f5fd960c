#pragma once

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace structnerf::room {

// Calls function(i) for all i in [0, count) on all cores, in any order.
// `function` must not throw.
template <typename Function>
void ParallelFor(const int count, const Function& function) {
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int i = next++; i < count; i = next++) {
      function(i);
    }
  };
  std::vector<std::thread> helpers;
  const int num_threads =
      std::min(count, std::max(1, int(std::thread::hardware_concurrency())));
  for (int i = 1; i < num_threads; ++i) {
    helpers.emplace_back(work);
  }
  work();
  for (std::thread& helper : helpers) {
    helper.join();
  }
}

}  // namespace structnerf::room
