#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace structnerf {

// Worker threads that sleep between loops. (Spinning at barriers costs a shared
// machine more than waking up costs us.)
class ThreadPool {
 public:
  // -1 = all cores. The calling thread counts as one of them. Has fewer if the
  // system does not give as many.
  explicit ThreadPool(int num_threads);
  ~ThreadPool();

  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int NumThreads() const;

  // Calls body(size_t item, int thread) for every item in [0, num_items), in
  // any order, with thread in [0, NumThreads()), and returns when all are done.
  // Rethrows the first exception a body threw; the remaining items are then
  // skipped. Allocates nothing. Not reentrant.
  template <typename Body>
  void ParallelFor(const size_t num_items, const Body& body) {
    Run({&body,
         [](const void* b, const size_t item, const int thread) {
           (*static_cast<const Body*>(b))(item, thread);
         },
         num_items});
  }

 private:
  struct Loop {
    const void* body = nullptr;
    void (*call)(const void* body, size_t item, int thread) = nullptr;
    size_t num_items = 0;
  };

  void Run(const Loop& loop);
  void RunWorker(int thread);
  void RunItems(const Loop& loop, int thread);

  std::vector<std::thread> workers_;
  std::atomic<size_t> next_item_{0};
  std::atomic<bool> failed_{false};

  // The rest is guarded by the mutex.
  std::mutex mutex_;
  std::condition_variable work_ready_;
  std::condition_variable work_done_;
  Loop loop_;
  bool loop_open_ = false;  // workers that wake up may still join
  size_t loop_id_ = 0;
  int num_busy_ = 0;
  std::exception_ptr error_;
  bool stopping_ = false;
};

}  // namespace structnerf
