#pragma once

#include "nerf/progress.h"
#include "nerf/util/thread_pool.h"

#include <cstddef>

namespace structnerf {

// ThreadPool::ParallelFor that waits while the work is paused, and throws
// Aborted if it was told to abort, before each item that the calling thread
// takes.
template <typename Body>
void WatchedParallelFor(const size_t num_items,
                        ThreadPool* pool,
                        Progress* progress,
                        const Body& body) {
  pool->ParallelFor(num_items, [&](const size_t item, const int thread) {
    if (thread == 0) {
      PauseOrAbort(progress);
    }
    body(item, thread);
  });
}

}  // namespace structnerf
