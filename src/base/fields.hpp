// SPDX-License-Identifier: Apache-2.0
// One table per parameter struct; job parsing, help texts, the schema and the record all read it. Nothing is written
// twice.
#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "base/result.hpp"

namespace scanmill {

/// A choice of words: the enum's value is the index into `words`.
struct Words {
  std::span<const std::string_view> words;
};

/// Type-erased member of a parameter struct; `object` below always is the struct the table belongs to.
struct Field {
  std::string_view name;    // the key in the job, with its unit
  std::string_view symbol;  // the paper's symbol, or empty
  std::string_view help;    // one sentence
  // Exactly one of these is set.
  std::variant<double* (*)(void*), std::int64_t* (*)(void*), bool* (*)(void*), std::optional<double>* (*)(void*),
               std::int32_t* (*)(void*)>
      member;
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
  bool minimum_excluded = false;
  std::span<const std::string_view> words = {};  // with the int32 member: an enum's words by value
};

namespace detail {
template <class P, auto Member>
auto member_access() {
  using M = std::remove_cvref_t<decltype(std::declval<P>().*Member)>;
  if constexpr (std::is_enum_v<M>) {
    static_assert(std::is_same_v<std::underlying_type_t<M>, std::int32_t>, "enums in tables are int32_t");
    return static_cast<std::int32_t* (*)(void*)>(
        [](void* p) { return reinterpret_cast<std::int32_t*>(&(static_cast<P*>(p)->*Member)); });
  } else {
    return static_cast<M* (*)(void*)>([](void* p) { return &(static_cast<P*>(p)->*Member); });
  }
}
}  // namespace detail

/// field<&Params::edge>("edge_mm", "", "...", {min, max}) builds one row.
struct Limits {
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
  bool minimum_excluded = false;
};
template <class P, auto Member>
Field field(std::string_view name, std::string_view symbol, std::string_view help, Limits limits = {},
            std::span<const std::string_view> words = {}) {
  return Field{
      name, symbol, help, detail::member_access<P, Member>(), limits.minimum, limits.maximum, limits.minimum_excluded,
      words};
}

/// Every row outside its limits, one sentence each; empty when all is well.
std::vector<std::string> problems_of(std::span<const Field> table, const void* object);

}  // namespace scanmill
