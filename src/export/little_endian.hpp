// SPDX-License-Identifier: Apache-2.0
// Numbers as the little-endian bytes that STL and binary PLY want.
#pragma once
#include <bit>
#include <cstring>

namespace scanmill::exporting {

static_assert(std::endian::native == std::endian::little,
              "this build writes its own byte order and must be little-endian");

/// -0 as +0, so that equal values have equal bytes.
template <class T>
T without_minus_zero(T value) {
  return value == 0 ? T{0} : value;
}

/// Puts the bytes of `value` at `at`; returns the place behind them.
template <class T>
char* put(char* at, T value) {
  std::memcpy(at, &value, sizeof value);
  return at + sizeof value;
}

}  // namespace scanmill::exporting
