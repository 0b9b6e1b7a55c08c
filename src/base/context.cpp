// SPDX-License-Identifier: Apache-2.0
#include "base/context.hpp"

#include <algorithm>

namespace scanmill {

void for_each_piece(const Context& context, std::size_t count, std::size_t grain,
                    FunctionRef<void(std::size_t, std::size_t, std::size_t, int)> body) {
  if (count == 0) return;
  const std::size_t pieces = (count + grain - 1) / grain;
  context.loop.run(pieces, [&](std::size_t piece, int worker) {
    if (context.cancel.is_set()) return;
    body(piece * grain, std::min(count, (piece + 1) * grain), piece, worker);
  });
}

void for_each_range(const Context& context, std::size_t count, std::size_t grain,
                    FunctionRef<void(std::size_t, std::size_t)> body) {
  for_each_piece(context, count, grain, [&](std::size_t b, std::size_t e, std::size_t, int) { body(b, e); });
}

}  // namespace scanmill
