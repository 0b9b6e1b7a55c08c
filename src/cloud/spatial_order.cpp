// SPDX-License-Identifier: Apache-2.0
#include "cloud/spatial_order.hpp"

#include <algorithm>
#include <numeric>

#include "cloud/over_blocks.hpp"

namespace scanmill {
namespace {

constexpr int kBits = 21;  // per axis

/// The low bits of `v` two places apart.
std::uint64_t spread(std::uint64_t v) {
  v &= (1ull << kBits) - 1;
  v = (v | v << 32) & 0x1f00000000ffffull;
  v = (v | v << 16) & 0x1f0000ff0000ffull;
  v = (v | v << 8) & 0x100f00f00f00f00full;
  v = (v | v << 4) & 0x10c30c30c30c30c3ull;
  return (v | v << 2) & 0x1249249249249249ull;
}

}  // namespace

Result<std::vector<std::uint32_t>> spatial_order(const PointSource& points, const Context& context,
                                                 FunctionRef<void(int, const PointBlock&)> look) {
  const std::size_t count = points.block_count();
  std::vector<Bounds> boxes(count);
  {
    FirstBlockError first;
    std::vector<PointBlock> buffers(static_cast<std::size_t>(context.loop.threads()));
    context.loop.run(count, [&](std::size_t number, int worker) {
      if (context.cancel.is_set() || first.is_before(number)) return;
      PointBlock& block = buffers[static_cast<std::size_t>(worker)];
      if (auto read = points.read_block(number, block); !read.ok())
        return first.report(number, std::move(read).error());
      for (const Vec3 p : block.positions) boxes[number].add(p);
      look(worker, block);
    });
    TRY(first.take(context));
  }
  Bounds all;
  for (const Bounds& box : boxes) all.add(box);
  const Vec3 size = all.empty() ? Vec3{1, 1, 1} : all.size();
  const double edge = std::max({size.x, size.y, size.z, 1e-300});
  std::vector<std::uint64_t> key(count, 0);
  for (std::size_t n = 0; n < count; ++n) {
    if (boxes[n].empty()) continue;
    const Vec3 middle = (boxes[n].low + boxes[n].high) * 0.5 - all.low;
    auto step = [&](double v) { return static_cast<std::uint64_t>(v / edge * ((1 << kBits) - 1)); };
    key[n] = spread(step(middle.x)) | spread(step(middle.y)) << 1 | spread(step(middle.z)) << 2;
  }
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  if (count > 1)
    std::sort(order.begin() + 1, order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return key[a] != key[b] ? key[a] < key[b] : a < b; });
  return order;
}

}  // namespace scanmill
