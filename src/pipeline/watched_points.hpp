// SPDX-License-Identifier: Apache-2.0
// A point source that tells how far its readers are.
#pragma once
#include <atomic>
#include <string>

#include "base/progress.hpp"
#include "cloud/cloud.hpp"

namespace scanmill::pipeline {

/// Passes blocks through and reports points handed out. Several passes count on: the total is what one pass reads times
/// the passes begun so far.
class WatchedPoints final : public PointSource {
 public:
  WatchedPoints(const PointSource& points, std::string stage, Progress& progress)
      : points_(points), stage_(std::move(stage)), progress_(progress) {}
  std::size_t block_count() const override { return points_.block_count(); }
  std::uint64_t expected_points() const override { return points_.expected_points(); }
  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    auto result = points_.read_block(number, out);
    const std::uint64_t done = done_.fetch_add(out.points_read) + out.points_read;
    const std::uint64_t one_pass = points_.expected_points();
    const std::uint64_t passes = one_pass == 0 ? 1 : (done + one_pass - 1) / one_pass;
    progress_.stage(stage_, done, one_pass * (passes == 0 ? 1 : passes));
    return result;
  }

 private:
  const PointSource& points_;
  std::string stage_;
  Progress& progress_;
  mutable std::atomic<std::uint64_t> done_{0};
};

}  // namespace scanmill::pipeline
