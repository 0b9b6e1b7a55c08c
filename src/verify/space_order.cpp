// SPDX-License-Identifier: Apache-2.0
#include "verify/space_order.hpp"

#include <algorithm>
#include <array>
#include <numeric>

namespace scanmill::verify {
namespace {

constexpr std::uint32_t kCells = 1024;  // along an axis: ten bits, so that a key has thirty

/// Ten bits with two zeros after each.
constexpr std::uint32_t spread(std::uint32_t x) {
  x = (x | x << 16) & 0x030000ffu;
  x = (x | x << 8) & 0x0300f00fu;
  x = (x | x << 4) & 0x030c30c3u;
  return (x | x << 2) & 0x09249249u;
}
constexpr auto kSpread = [] {
  std::array<std::uint32_t, kCells> table{};
  for (std::uint32_t n = 0; n < kCells; ++n) table[n] = spread(n);
  return table;
}();

bool follow_one_another(std::span<const Vec3> points, double near) {
  std::size_t jumps = 0;
  for (std::size_t n = 1; n < points.size(); ++n) jumps += norm2(points[n] - points[n - 1]) > near * near;
  return 4 * jumps < points.size();
}

}  // namespace

std::span<const std::uint32_t> SpaceOrder::of(std::span<const Vec3> points, double edge) {
  rows_.resize(points.size());
  if (follow_one_another(points, 2 * edge))
    std::iota(rows_.begin(), rows_.end(), 0u);
  else
    sort(points, edge);
  return rows_;
}

void SpaceOrder::sort(std::span<const Vec3> points, double edge) {
  Bounds box;
  for (const Vec3& p : points) box.add(p);
  const Vec3 size = box.size();
  const double widest = std::max({size.x, size.y, size.z});
  const double cells_per_mm = widest < edge * kCells ? 1 / edge : kCells / widest;
  auto cell = [&](double x, double low) {
    return kSpread[std::min(kCells - 1, static_cast<std::uint32_t>((x - low) * cells_per_mm))];
  };
  entries_.resize(points.size());
  spare_.resize(points.size());
  std::array<std::array<std::uint32_t, kCells>, 3> place{};
  for (std::uint32_t n = 0; n < points.size(); ++n) {
    const Vec3& p = points[n];
    const std::uint32_t key = cell(p.x, box.low.x) | cell(p.y, box.low.y) << 1 | cell(p.z, box.low.z) << 2;
    entries_[n] = {key, n};
    for (unsigned digit = 0; digit < 3; ++digit) ++place[digit][key >> (10 * digit) & (kCells - 1)];
  }
  for (unsigned digit = 0; digit < 3; ++digit) {
    std::uint32_t before = 0;
    for (std::uint32_t& count : place[digit]) {
      const std::uint32_t here = count;
      count = before;
      before += here;
    }
    for (const Entry& entry : entries_) spare_[place[digit][entry.key >> (10 * digit) & (kCells - 1)]++] = entry;
    entries_.swap(spare_);
  }
  for (std::size_t n = 0; n < points.size(); ++n) rows_[n] = entries_[n].row;
}

}  // namespace scanmill::verify
