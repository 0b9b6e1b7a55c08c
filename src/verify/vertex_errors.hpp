// SPDX-License-Identifier: Apache-2.0
// The signed distance of largest magnitude among the input points of a vertex's own bin, and their rms. Internal to
// `verify`.
#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "verify/verify.hpp"

namespace scanmill::verify {

/// Shared by all workers: sums and maxima of whole numbers commute.
class VertexErrors {
 public:
  VertexErrors(std::size_t vertices, std::size_t rows) : sums_(vertices), near_((rows + 63) / 64), rows_(rows) {}

  /// Points of one worker on their way in; a run of points of one bin is added at once.
  class Feed {
   public:
    Feed(VertexErrors& errors, const VertexBins& bins) : errors_(errors), bins_(bins), reader_(*bins.index) {}
    void begin(std::span<const Vec3> points);
    void add(std::size_t point, double distance, std::int64_t units, bool is_above, bool is_near);
    void end() { flush(); }

   private:
    void flush();
    VertexErrors& errors_;
    const VertexBins& bins_;
    BinIndex::Reader reader_;
    std::vector<LocalBin> local_;
    std::vector<std::int32_t> rows_;
    std::int32_t row_ = kNoSlot;
    std::uint64_t count_ = 0, low_ = 0, high_ = 0, worst_ = 0;
    bool near_ = false;
  };

  std::vector<VertexError> errors(double bin_mm) const;
  /// The sums of the vertices that have points, ascending.
  std::vector<PieceVerdict::Vertex> sums() const;
  /// False when a vertex is none of these.
  bool add(std::span<const PieceVerdict::Vertex> sums);
  /// body(64 rows) for all rows, and their union with what `next` gives, word by word.
  template <class Body>
  void visit_near(Body body) const {
    for (const auto& word : near_) body(word.load());
  }
  template <class Next>
  void add_near(Next next) {
    for (auto& word : near_) word.fetch_or(next());
  }
  std::uint64_t bins_near() const;

 private:
  struct Vertex {
    std::atomic<std::uint64_t> count{0};
    std::atomic<std::uint64_t> low{0}, high{0};  // sum of squared units: lower and upper 32 bits summed apart
    std::atomic<std::uint64_t> worst{0};         // bits of the distance, times two, plus one when above
  };
  std::vector<Vertex> sums_;
  std::vector<std::atomic<std::uint64_t>> near_;  // bit per row
  std::size_t rows_;
};

}  // namespace scanmill::verify
