// SPDX-License-Identifier: Apache-2.0
// Large pages behind the arrays of a cloud: the system hands out small ones one fault at a time, which costs more than
// the arithmetic on them. Advice only: nothing fails, no value depends on it.
#pragma once
#include <cstddef>
#include <vector>

namespace scanmill {

/// Asks for large pages behind the whole large pages of a piece of memory; before its first use. Pieces under 4 MB are
/// left alone.
void advise_large_pages(void* begin, std::size_t bytes);

/// `reserve`, with large pages behind what is new.
template <class T>
void reserve_large(std::vector<T>& values, std::size_t count) {
  if (count <= values.capacity()) return;
  std::vector<T> larger;
  larger.reserve(count);
  advise_large_pages(larger.data(), count * sizeof(T));
  larger.insert(larger.end(), values.begin(), values.end());
  values.swap(larger);
}

/// `resize` of an array that is filled once.
template <class T>
void resize_large(std::vector<T>& values, std::size_t count) {
  reserve_large(values, count);
  values.resize(count);
}

/// `resize` of an array that grows step by step, to twice its size at least.
template <class T>
void grow_large(std::vector<T>& values, std::size_t count) {
  if (count > values.capacity()) reserve_large(values, count > 2 * values.capacity() ? count : 2 * values.capacity());
  values.resize(count);
}

}  // namespace scanmill
