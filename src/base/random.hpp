// SPDX-License-Identifier: Apache-2.0
// Random numbers from (seed, key, purpose), never from clock, thread or device. Only + - * / and sqrt.
#pragma once
#include <cmath>
#include <cstdint>

#include "base/digest.hpp"

namespace scanmill {

class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t key, std::uint64_t purpose)
      : state_(mix64(seed ^ mix64(key ^ mix64(purpose)))) {}
  std::uint64_t next() { return mix64(state_ += 0x9e3779b97f4a7c15ull); }
  /// In [0, 1), 53 bits.
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Mean 0, variance 1, as the centred sum of twelve uniforms: no logarithm or sine, so the same bits on every
  /// machine. Range +-6; kurtosis 2.9.
  double gauss() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum;
  }

 private:
  std::uint64_t state_;
};

}  // namespace scanmill
