#include "nerf/util/thread_pool.h"

#include <atomic>
#include <chrono>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(ThreadPool, EveryItemOnce) {
  for (const int num_threads : {1, 2, 3, 8}) {
    ThreadPool pool(num_threads);
    EXPECT_EQ(pool.NumThreads(), num_threads);
    for (const size_t num_items : {0, 1, 2, 7, 1000}) {
      std::vector<std::atomic<int>> counts(num_items);
      std::atomic<bool> is_thread_valid{true};
      pool.ParallelFor(num_items, [&](const size_t item, const int thread) {
        ++counts[item];
        if (thread < 0 || thread >= num_threads) {
          is_thread_valid = false;
        }
      });
      for (const std::atomic<int>& count : counts) {
        EXPECT_EQ(count, 1);
      }
      EXPECT_TRUE(is_thread_valid);
    }
  }
}

TEST(ThreadPool, AllCores) {
  const int num_cores =
      std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  EXPECT_EQ(ThreadPool(-1).NumThreads(), num_cores);
}

// Two bodies never run with the same thread number at a time: buffers are per
// thread.
TEST(ThreadPool, ThreadNumbersAreExclusive) {
  ThreadPool pool(4);
  std::vector<std::atomic<int>> num_inside(4);
  std::atomic<int> num_clashes{0};
  for (int loop = 0; loop < 50; ++loop) {
    pool.ParallelFor(64, [&](size_t, const int thread) {
      num_clashes += ++num_inside[thread] != 1;
      std::this_thread::yield();
      --num_inside[thread];
    });
  }
  EXPECT_EQ(num_clashes, 0);
}

TEST(ThreadPool, ItemsRunAtTheSameTime) {
  ThreadPool pool(2);
  std::atomic<int> num_arrived{0};
  const auto deadline =
      std::chrono::steady_clock::now() + std::chrono::seconds(20);
  std::atomic<bool> met{true};
  pool.ParallelFor(2, [&](size_t, int) {
    ++num_arrived;
    while (num_arrived < 2) {
      if (std::chrono::steady_clock::now() > deadline) {
        met = false;
        return;
      }
      std::this_thread::yield();
    }
  });
  EXPECT_TRUE(met);
}

TEST(ThreadPool, ManySmallLoops) {
  ThreadPool pool(3);
  size_t sum = 0;
  for (size_t loop = 0; loop < 5000; ++loop) {
    std::atomic<size_t> items{0};
    pool.ParallelFor(loop % 5, [&](const size_t item, int) { items += item; });
    sum += items;
  }
  EXPECT_EQ(sum, 1000 * (0 + 0 + 1 + 3 + 6));
}

TEST(ThreadPool, ResultsAreVisibleAfterTheLoop) {
  ThreadPool pool(4);
  std::vector<size_t> values(10000);
  for (size_t loop = 1; loop < 20; ++loop) {
    pool.ParallelFor(values.size(),
                     [&](const size_t item, int) { values[item] += item; });
    for (size_t i = 0; i < values.size(); ++i) {
      ASSERT_EQ(values[i], loop * i);
    }
  }
}

TEST(ThreadPool, ExceptionsComeBackAndThePoolStaysUsable) {
  for (const int num_threads : {1, 4}) {
    ThreadPool pool(num_threads);
    for (int round = 0; round < 20; ++round) {
      std::atomic<int> num_run{0};
      try {
        pool.ParallelFor(1000, [&](const size_t item, int) {
          ++num_run;
          if (item == 5) {
            throw std::runtime_error("item five");
          }
        });
        FAIL() << "nothing was thrown";
      } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "item five");
      }
      // How far other threads have come in the meantime is not known.
      if (num_threads == 1) {
        EXPECT_EQ(num_run, 6);
      }
      std::atomic<int> count{0};
      pool.ParallelFor(10, [&](size_t, int) { ++count; });
      EXPECT_EQ(count, 10);
    }
  }
}

TEST(ThreadPool, EveryBodyThrows) {
  ThreadPool pool(4);
  EXPECT_THROW(pool.ParallelFor(
                   64, [](size_t, int) { throw std::invalid_argument(""); }),
               std::invalid_argument);
}

}  // namespace
}  // namespace structnerf
