// SPDX-License-Identifier: Apache-2.0
// The wall around TBB: one erased call per chunk. The race-check build compiles the plain-thread version below instead,
// because the stock TBB library is not instrumented and drowns the sanitizer in false reports.
#include "base/context.hpp"
#include "base/paged_memory.hpp"

#ifdef SCANMILL_PLAIN_THREADS
#include <exception>
#include <mutex>
#include <thread>
#include <vector>
#else
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace scanmill {

#ifdef SCANMILL_PLAIN_THREADS

struct ChunkLoop::Impl {
  int threads;
};
ChunkLoop::ChunkLoop(int threads) : impl_(new Impl{threads}) {}

void ChunkLoop::run(std::size_t chunks, FunctionRef<void(std::size_t, int)> body) const {
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::exception_ptr failure;
  auto work = [&](int worker) {
    try {
      for (std::size_t chunk; (chunk = next.fetch_add(1)) < chunks;) body(chunk, worker);
    } catch (...) {
      std::lock_guard<std::mutex> guard(mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  std::vector<std::thread> pool;
  for (int t = 1; t < impl_->threads; ++t) pool.emplace_back(work, t);
  work(0);
  for (auto& thread : pool) thread.join();
  if (failure) std::rethrow_exception(failure);
}

#else

struct ChunkLoop::Impl {
  explicit Impl(int n)
      : allowed(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(n)), arena(n, 1), threads(n) {}
  tbb::global_control allowed;  // also lets more threads run than the machine has cores, for invariance tests
  mutable tbb::task_arena arena;
  int threads;
};
ChunkLoop::ChunkLoop(int threads) : impl_(new Impl(threads)) {}

void ChunkLoop::run(std::size_t chunks, FunctionRef<void(std::size_t, int)> body) const {
  if (impl_->threads == 1 || chunks <= 1) {
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
      body(chunk, 0);
      paged::relieve();
    }
    return;
  }
  impl_->arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, chunks, 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          const int worker = tbb::this_task_arena::current_thread_index();
          for (std::size_t chunk = range.begin(); chunk < range.end(); ++chunk) {
            body(chunk, worker);
            paged::relieve();
          }
        },
        tbb::simple_partitioner());
  });
}

#endif

ChunkLoop::~ChunkLoop() = default;
int ChunkLoop::threads() const { return impl_->threads; }

}  // namespace scanmill
