// SPDX-License-Identifier: Apache-2.0
// Lists of several kinds in one part: rows of a byte.
#pragma once
#include <cstdint>
#include <type_traits>
#include <vector>

#include "mesh/mesh.hpp"
#include "pipeline/part_file.hpp"

namespace scanmill::pipeline {

/// Values one after the other, as they stand in memory; a list begins with its length.
class Keeper {
 public:
  explicit Keeper(PartWriter& writer) : writer_(writer) {}
  template <class... Values>
  void operator()(const Values&... values) {
    (keep(values), ...);
  }
  Result<void> state = {};

 private:
  template <class T>
  void keep(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes(&value, sizeof value);
  }
  template <class T>
  void keep(const std::vector<T>& list) {
    keep(static_cast<std::uint64_t>(list.size()));
    if constexpr (std::is_trivially_copyable_v<T>)
      bytes(list.data(), list.size() * sizeof(T));
    else
      for (const T& value : list) keep(value);
  }
  void keep(const BorderLoop& loop) { (*this)(loop.vertices, loop.length_mm, loop.centre); }
  void bytes(const void* begin, std::size_t count) {
    if (state.ok() && count > 0) state = writer_.add({static_cast<const char*>(begin), count});
  }
  PartWriter& writer_;
};

/// The same back.
class Taker {
 public:
  explicit Taker(const PartFile& file) : file_(file) {}
  template <class... Values>
  void operator()(Values&... values) {
    (take(values), ...);
  }
  Result<void> state = {};

 private:
  template <class T>
  void take(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes(&value, sizeof value);
  }
  template <class T>
  void take(std::vector<T>& list) {
    std::uint64_t count = 0;
    take(count);
    if (count > file_.rows() - at_) state = fail(Code::IoFailed, "is shorter than its lists; remove it and run again");
    if (!state.ok()) return;
    list.resize(static_cast<std::size_t>(count));
    if constexpr (std::is_trivially_copyable_v<T>)
      bytes(list.data(), list.size() * sizeof(T));
    else
      for (T& value : list) take(value);
  }
  void take(BorderLoop& loop) { (*this)(loop.vertices, loop.length_mm, loop.centre); }
  void bytes(void* begin, std::size_t count) {
    if (!state.ok() || count == 0) return;
    state = file_.read(at_, {static_cast<char*>(begin), count});
    at_ += count;
  }
  const PartFile& file_;
  std::uint64_t at_ = 0;
};

}  // namespace scanmill::pipeline
