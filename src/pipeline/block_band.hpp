// SPDX-License-Identifier: Apache-2.0
// What one block of points says about the sensor's depth band, kept where threads meet.
#pragma once
#include <array>
#include <atomic>
#include <bit>
#include <cstdint>

#include "plan/band.hpp"

namespace scanmill::pipeline {

/// Threads may read the same block at once; all of them store the same numbers.
class BlockBand {
 public:
  void store(const plan::BandCounts& counts) {
    const std::uint64_t values[] = {counts.points,
                                    counts.too_near,
                                    counts.too_far,
                                    counts.beside,
                                    std::bit_cast<std::uint64_t>(counts.nearest_mm),
                                    std::bit_cast<std::uint64_t>(counts.farthest_mm),
                                    std::bit_cast<std::uint64_t>(counts.beside_mm)};
    for (std::size_t i = 0; i < values_.size(); ++i) values_[i].store(values[i], std::memory_order_relaxed);
    read_.store(true, std::memory_order_release);
  }
  plan::BandCounts load() const {
    if (!read_.load(std::memory_order_acquire)) return {};
    const auto value = [&](std::size_t i) { return values_[i].load(std::memory_order_relaxed); };
    return {value(0),
            value(1),
            value(2),
            value(3),
            std::bit_cast<double>(value(4)),
            std::bit_cast<double>(value(5)),
            std::bit_cast<double>(value(6))};
  }

 private:
  std::array<std::atomic<std::uint64_t>, 7> values_{};
  std::atomic<bool> read_{false};
};

}  // namespace scanmill::pipeline
