#include "nerf/util/thread_pool.h"

#include <algorithm>

namespace structnerf {

ThreadPool::ThreadPool(int num_threads) {
  if (num_threads <= 0) {
    num_threads =
        std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  }
  for (int thread = 1; thread < num_threads; ++thread) {
    workers_.emplace_back([this, thread] { RunWorker(thread); });
  }
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  work_ready_.notify_all();
  for (std::thread& worker : workers_) {
    worker.join();
  }
}

int ThreadPool::NumThreads() const {
  return static_cast<int>(workers_.size()) + 1;
}

void ThreadPool::ParallelFor(
    const size_t num_items,
    const std::function<void(size_t item, int thread)>& body) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    body_ = &body;
    num_items_ = num_items;
    next_item_ = 0;
    error_ = nullptr;
    num_busy_ = static_cast<int>(workers_.size());
    ++loop_id_;
  }
  work_ready_.notify_all();
  RunItems(0);
  std::unique_lock<std::mutex> lock(mutex_);
  work_done_.wait(lock, [this] { return num_busy_ == 0; });
  body_ = nullptr;
  if (error_) {
    std::rethrow_exception(error_);
  }
}

void ThreadPool::RunWorker(const int thread) {
  size_t last_loop_id = 0;
  while (true) {
    {
      std::unique_lock<std::mutex> lock(mutex_);
      work_ready_.wait(lock,
                       [&] { return stopping_ || loop_id_ != last_loop_id; });
      if (stopping_) {
        return;
      }
      last_loop_id = loop_id_;
    }
    RunItems(thread);
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      --num_busy_;
    }
    work_done_.notify_one();
  }
}

void ThreadPool::RunItems(const int thread) {
  while (true) {
    size_t item;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (next_item_ >= num_items_ || error_) {
        return;
      }
      item = next_item_++;
    }
    try {
      (*body_)(item, thread);
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!error_) {
        error_ = std::current_exception();
      }
    }
  }
}

}  // namespace structnerf
