// SPDX-License-Identifier: Apache-2.0
#include "verify/vertex_errors.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "verify/tally.hpp"

namespace scanmill::verify {
namespace {

/// Bin number below or at x, relative to base; false when it does not fit.
bool local_of(double x, std::int64_t base, std::int32_t& local) {
  if (!(std::abs(x) < 0x1p62)) return false;
  auto whole = static_cast<std::int64_t>(x);
  if (x < static_cast<double>(whole)) --whole;
  const std::int64_t from_base = whole - base;
  local = static_cast<std::int32_t>(from_base);
  return from_base == local;
}

}  // namespace

void VertexErrors::Feed::begin(std::span<const Vec3> points) {
  local_.resize(points.size());
  rows_.resize(points.size());
  const Lattice& lattice = bins_.lattice;
  for (std::size_t n = 0; n < points.size(); ++n) {
    const Vec3 u = points[n] - lattice.origin;
    LocalBin& local = local_[n];
    if (!local_of(u.x / lattice.edge_mm, bins_.base.i, local[0]) ||
        !local_of(u.y / lattice.edge_mm, bins_.base.j, local[1]) ||
        !local_of(u.z / lattice.edge_mm, bins_.base.k, local[2])) {
      // No bin of the index lies at the end of the numbers.
      constexpr std::int32_t kEnd = std::numeric_limits<std::int32_t>::min();
      local = {kEnd, kEnd, kEnd};
    }
  }
  reader_.rows_of(local_, rows_);
}

void VertexErrors::Feed::add(std::size_t point, double distance, std::int64_t units, bool is_above, bool is_near) {
  if (rows_[point] != row_) {
    flush();
    row_ = rows_[point];
  }
  // A vertex lies in its own bin, so no point of it is farther than two bin edges; what is, in a mesh that is not of
  // this lattice, counts as 1024, so that sums fit.
  const auto capped = static_cast<std::uint64_t>(std::min(units, std::int64_t{1} << 30)), square = capped * capped;
  ++count_;
  low_ += square & 0xffffffffu;
  high_ += square >> 32;
  const std::uint64_t key = std::bit_cast<std::uint64_t>(distance) << 1 | (is_above ? 1 : 0);
  if (key > worst_) worst_ = key;
  near_ |= is_near;
}

void VertexErrors::Feed::flush() {
  if (count_ > 0 && row_ != kNoSlot && static_cast<std::size_t>(row_) < errors_.rows_) {
    const auto row = static_cast<std::size_t>(row_);
    constexpr auto kRelaxed = std::memory_order_relaxed;
    if (near_ && (errors_.near_[row / 64].load(kRelaxed) >> (row % 64) & 1) == 0)
      errors_.near_[row / 64].fetch_or(std::uint64_t{1} << (row % 64), kRelaxed);
    if (const std::uint32_t v = bins_.vertex_of_row[row]; v != kNoVertex) {
      Vertex& sums = errors_.sums_[v];
      sums.count.fetch_add(count_, kRelaxed);
      sums.low.fetch_add(low_, kRelaxed);
      sums.high.fetch_add(high_, kRelaxed);
      std::uint64_t worst = sums.worst.load(kRelaxed);
      while (worst_ > worst && !sums.worst.compare_exchange_weak(worst, worst_, kRelaxed)) {
      }
    }
  }
  count_ = low_ = high_ = worst_ = 0;
  near_ = false;
}

std::vector<VertexError> VertexErrors::errors(double bin_mm) const {
  std::vector<VertexError> out(sums_.size());
  for (std::size_t v = 0; v < out.size(); ++v) {
    const Vertex& sums = sums_[v];
    VertexError& error = out[v];
    error.points = sums.count;
    if (error.points == 0) continue;
    const std::uint64_t worst = sums.worst;
    const auto distance = std::bit_cast<double>(worst >> 1);
    error.signed_mm = (worst & 1) != 0 ? distance : -distance;
    const WideCount sum = (static_cast<WideCount>(sums.high) << 32) + sums.low;
    const double rms =
        std::sqrt(static_cast<double>(sum) / static_cast<double>(error.points)) * (bin_mm / kUnitsPerBin);
    error.rms_mm = rms < distance ? rms : distance;
  }
  return out;
}

std::vector<PieceVerdict::Vertex> VertexErrors::sums() const {
  std::vector<PieceVerdict::Vertex> out;
  for (std::size_t v = 0; v < sums_.size(); ++v)
    if (const Vertex& one = sums_[v]; one.count != 0) out.push_back({v, one.count, one.low, one.high, one.worst});
  return out;
}

bool VertexErrors::add(std::span<const PieceVerdict::Vertex> sums) {
  for (const PieceVerdict::Vertex& more : sums) {
    if (more.vertex >= sums_.size()) return false;
    Vertex& one = sums_[static_cast<std::size_t>(more.vertex)];
    one.count += more.count;
    one.low += more.low;
    one.high += more.high;
    one.worst = std::max(one.worst.load(), more.worst);
  }
  return true;
}

std::uint64_t VertexErrors::bins_near() const {
  std::uint64_t count = 0;
  for (const auto& word : near_) count += static_cast<std::uint64_t>(std::popcount(word.load()));
  return count;
}

}  // namespace scanmill::verify
