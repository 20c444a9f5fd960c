#include "nerf/util/thread_pool.h"

#include <algorithm>
#include <system_error>

namespace structnerf {

ThreadPool::ThreadPool(int num_threads) {
  if (num_threads <= 0) {
    num_threads =
        std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  }
  for (int thread = 1; thread < num_threads; ++thread) {
    try {
      workers_.emplace_back([this, thread] { RunWorker(thread); });
    } catch (const std::system_error&) {
      break;  // out of memory or processes; fewer threads do the same
    }
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

void ThreadPool::Run(const Loop& loop) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    loop_ = loop;
    next_item_ = 0;
    failed_ = false;
    error_ = nullptr;
    loop_open_ = true;
    ++loop_id_;
  }
  work_ready_.notify_all();
  RunItems(loop, 0);
  // Whoever has not woken up by now is not waited for.
  std::unique_lock<std::mutex> lock(mutex_);
  loop_open_ = false;
  work_done_.wait(lock, [this] { return num_busy_ == 0; });
  if (error_) {
    std::rethrow_exception(error_);
  }
}

void ThreadPool::RunWorker(const int thread) {
  size_t last_loop_id = 0;
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    work_ready_.wait(lock, [&] {
      return stopping_ || (loop_open_ && loop_id_ != last_loop_id);
    });
    if (stopping_) {
      return;
    }
    last_loop_id = loop_id_;
    const Loop loop = loop_;
    ++num_busy_;
    lock.unlock();
    RunItems(loop, thread);
    lock.lock();
    if (--num_busy_ == 0) {
      work_done_.notify_one();
    }
  }
}

void ThreadPool::RunItems(const Loop& loop, const int thread) {
  while (!failed_) {
    const size_t item = next_item_++;
    if (item >= loop.num_items) {
      return;
    }
    try {
      loop.call(loop.body, item, thread);
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!error_) {
        error_ = std::current_exception();
      }
      failed_ = true;
    }
  }
}

}  // namespace structnerf
