#pragma once

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace structnerf {

// Worker threads that sleep between loops. (Spinning at barriers costs a shared
// machine more than waking up costs us.)
class ThreadPool {
 public:
  // -1 = all cores. The calling thread counts as one of them.
  explicit ThreadPool(int num_threads);
  ~ThreadPool();

  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int NumThreads() const;

  // Calls body(item, thread) for every item in [0, num_items), in any order,
  // with thread in [0, NumThreads()), and returns when all are done. Rethrows
  // the first exception a body threw; the remaining items are then skipped.
  // Not reentrant.
  void ParallelFor(size_t num_items,
                   const std::function<void(size_t item, int thread)>& body);

 private:
  void RunWorker(int thread);
  void RunItems(int thread);

  std::vector<std::thread> workers_;
  std::mutex mutex_;
  std::condition_variable work_ready_;
  std::condition_variable work_done_;

  // The current loop, guarded by mutex_ except `body_`, which is only replaced
  // while no worker is busy.
  const std::function<void(size_t, int)>* body_ = nullptr;
  size_t num_items_ = 0;
  size_t next_item_ = 0;
  size_t loop_id_ = 0;
  int num_busy_ = 0;
  std::exception_ptr error_;
  bool stopping_ = false;
};

}  // namespace structnerf
