// SPDX-License-Identifier: Apache-2.0
#include "cloud/spatial_order.hpp"

#include <algorithm>
#include <numeric>

#include "cloud/over_blocks.hpp"
#include "cloud/z_order.hpp"

namespace scanmill {
Result<BlockOrder> spatial_order(const PointSource& points, const Context& context,
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
    auto step = [&](double v) { return static_cast<std::uint64_t>(v / edge * ((1 << kZOrderBits) - 1)); };
    key[n] = z_order(step(middle.x), step(middle.y), step(middle.z));
  }
  BlockOrder out{std::vector<std::uint32_t>(count), all};
  std::vector<std::uint32_t>& order = out.order;
  std::iota(order.begin(), order.end(), 0u);
  if (count > 1)
    std::sort(order.begin() + 1, order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return key[a] != key[b] ? key[a] < key[b] : a < b; });
  return out;
}

}  // namespace scanmill
