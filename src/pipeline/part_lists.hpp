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

/// The same back, from `at` on.
class Taker {
 public:
  explicit Taker(const PartFile& file, std::uint64_t at = 0) : file_(file), at_(at) {}
  std::uint64_t at() const { return at_; }
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
  std::uint64_t at_;
};

/// A list that is not taken whole.
template <class T>
class ListView {
 public:
  /// Where a list begins; moves `at` behind it.
  static Result<ListView> open(const PartFile& file, std::uint64_t& at) {
    ListView list(file);
    Taker taker(file, at);
    taker(list.count_);
    TRY(std::move(taker.state));
    list.begin_ = taker.at();
    if (list.count_ > (file.rows() - list.begin_) / sizeof(T))
      return fail(Code::IoFailed, "is shorter than its lists; remove it and run again");
    at = list.begin_ + list.count_ * sizeof(T);
    return list;
  }
  std::uint64_t size() const { return count_; }
  /// Values [first, last), behind those in `out`.
  Result<void> read(std::uint64_t first, std::uint64_t last, std::vector<T>& out) const {
    const std::size_t before = out.size();
    out.resize(before + static_cast<std::size_t>(last - first));
    return file_.read(begin_ + first * sizeof(T),
                      {reinterpret_cast<char*>(out.data() + before), (out.size() - before) * sizeof(T)});
  }
  /// The first value that is not before; those that are come first.
  template <class IsBefore>
  Result<std::uint64_t> first_not(const IsBefore& is_before) const {
    std::uint64_t low = 0, high = count_;
    while (low < high) {
      const std::uint64_t middle = low + (high - low) / 2;
      T value;
      TRY(file_.read(begin_ + middle * sizeof(T), {reinterpret_cast<char*>(&value), sizeof value}));
      (is_before(value) ? low = middle + 1 : high = middle);
    }
    return low;
  }

 private:
  explicit ListView(const PartFile& file) : file_(file) {}
  const PartFile& file_;
  std::uint64_t begin_ = 0, count_ = 0;
};

}  // namespace scanmill::pipeline
