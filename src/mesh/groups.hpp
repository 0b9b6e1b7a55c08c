// SPDX-License-Identifier: Apache-2.0
// Union-find with path halving.
#pragma once
#include <cstdint>
#include <numeric>
#include <vector>

namespace scanmill {

/// Groups of rows 0 .. n-1, each alone at first. The root is the least member, so results do not depend on the order of
/// joins.
class Groups {
 public:
  explicit Groups(std::size_t n) : up_(n) { std::iota(up_.begin(), up_.end(), 0u); }
  std::uint32_t root(std::uint32_t i) {
    while (up_[i] != i) i = up_[i] = up_[up_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    if (a < b)
      up_[b] = a;
    else
      up_[a] = b;
  }

 private:
  std::vector<std::uint32_t> up_;
};

}  // namespace scanmill
