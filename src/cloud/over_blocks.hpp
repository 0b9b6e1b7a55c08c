// SPDX-License-Identifier: Apache-2.0
// One pass over a cloud on all workers.
#pragma once
#include <atomic>
#include <limits>
#include <mutex>

#include "base/context.hpp"
#include "cloud/cloud.hpp"

namespace scanmill {

/// The first failure in block order, so that the message does not depend on threads: blocks behind a failed one are
/// skipped, those before it are still read.
class FirstBlockError {
 public:
  void report(std::size_t block, Error error) {
    std::lock_guard<std::mutex> guard(mutex_);
    if (block >= block_.load(std::memory_order_relaxed)) return;
    error_ = std::move(error);
    block_.store(block, std::memory_order_relaxed);
  }
  bool is_before(std::size_t block) const { return block_.load(std::memory_order_relaxed) < block; }
  Result<void> take(const Context& context) {
    if (block_.load(std::memory_order_relaxed) != kNone) return std::move(error_);
    if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
    return {};
  }

 private:
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::mutex mutex_;
  Error error_;
  std::atomic<std::size_t> block_{kNone};
};

/// Reads every block once; `body(worker, block)` sees a private buffer and returns Result<void>.
/// errors  the first one in block order; Cancelled
template <class Body>
Result<void> over_blocks(const PointSource& points, const Context& context, Body body) {
  FirstBlockError first;
  std::vector<PointBlock> buffers(static_cast<std::size_t>(context.loop.threads()));
  context.loop.run(points.block_count(), [&](std::size_t number, int worker) {
    if (context.cancel.is_set() || first.is_before(number)) return;
    PointBlock& block = buffers[static_cast<std::size_t>(worker)];
    auto read = points.read_block(number, block);
    if (read.ok()) read = body(worker, block);
    if (!read.ok()) first.report(number, std::move(read).error());
  });
  return first.take(context);
}

}  // namespace scanmill
