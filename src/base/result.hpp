// SPDX-License-Identifier: Apache-2.0
// Expected failure as a value: a code, a sentence, and where.
#pragma once
#include <string>
#include <utility>
#include <variant>

namespace scanmill {

/// Who must act. Exit codes follow (README, "Exit codes").
enum class Code {
  BadUsage,      // the command line
  BadParameter,  // a key of the job or plan
  BadInput,      // a file of the archive
  IoFailed,      // the machine: read, write, sync
  NoSpace,       // the machine: disk or memory is full
  Cancelled,     // the user or the system asked to stop
  Unsupported,   // known, but not by this build
  Internal,      // us
};

const char* name_of(Code code);

/// `message`: what was found, what was wanted, what to do. `where`: file, then line or byte, view, scan; outermost
/// first.
struct Error {
  Code code = Code::Internal;
  std::string message;
  std::string where;

  /// "where: message", or the message alone.
  std::string text() const;
  /// The same failure seen from one layer further out: `place` goes in front of `where`.
  Error at(const std::string& place) &&;
};

inline Error fail(Code code, std::string message, std::string where = {}) {
  return {code, std::move(message), std::move(where)};
}

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}      // NOLINT: by intent
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT: by intent
  explicit operator bool() const { return state_.index() == 0; }
  bool ok() const { return state_.index() == 0; }
  T& value() & { return std::get<0>(state_); }
  const T& value() const& { return std::get<0>(state_); }
  T&& value() && { return std::get<0>(std::move(state_)); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  Error& error() & { return std::get<1>(state_); }
  const Error& error() const& { return std::get<1>(state_); }
  Error&& error() && { return std::get<1>(std::move(state_)); }

 private:
  std::variant<T, Error> state_;
};

template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)), failed_(true) {}  // NOLINT: by intent
  explicit operator bool() const { return !failed_; }
  bool ok() const { return !failed_; }
  Error& error() & { return error_; }
  const Error& error() const& { return error_; }
  Error&& error() && { return std::move(error_); }

 private:
  Error error_;
  bool failed_ = false;
};

#define SCANMILL_CONCAT_(a, b) a##b
#define SCANMILL_CONCAT(a, b) SCANMILL_CONCAT_(a, b)
/// TRY(expr): return the error of `expr` from the enclosing function, if there is one.
#define SCANMILL_TRY_(name, ...)                    \
  do {                                              \
    auto name = (__VA_ARGS__);                      \
    if (!name.ok()) return std::move(name).error(); \
  } while (false)
#define TRY(...) SCANMILL_TRY_(SCANMILL_CONCAT(try_result_, __COUNTER__), __VA_ARGS__)
/// TRY_ASSIGN(auto x, expr): the value of `expr`, or return its error.
#define SCANMILL_TRY_ASSIGN_(name, declaration, ...) \
  auto name = (__VA_ARGS__);                         \
  if (!name.ok()) return std::move(name).error();    \
  declaration = std::move(name).value()
#define TRY_ASSIGN(declaration, ...) \
  SCANMILL_TRY_ASSIGN_(SCANMILL_CONCAT(try_value_, __COUNTER__), declaration, __VA_ARGS__)

}  // namespace scanmill
