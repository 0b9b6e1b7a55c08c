// SPDX-License-Identifier: Apache-2.0
// Lines of a text file with their numbers, and the words of a line one after the other without an allocation.
#pragma once
#include <charconv>
#include <cstdint>
#include <string_view>

#include "formats/cursor.hpp"
#include "formats/decimal.hpp"

namespace scanmill::formats {

class LineWords {
 public:
  explicit LineWords(std::string_view line) : p_(line.data()), end_(line.data() + line.size()) {}
  /// The next word, empty at the end.
  std::string_view next() {
    skip_space();
    const char* begin = p_;
    while (p_ != end_ && !is_space(*p_)) ++p_;
    return {begin, static_cast<std::size_t>(p_ - begin)};
  }
  /// False, and nothing moves, when the next word is no number.
  bool number(double& value) {
    skip_space();
    const char* stop = p_ == end_ ? nullptr : parse_decimal(p_, end_, value);
    if (stop == nullptr || (stop != end_ && !is_space(*stop))) return false;
    p_ = stop;
    return true;
  }
  /// False, and nothing moves, when the next word is no whole number of 64 bits.
  template <class Integer>
  bool integer(Integer& value) {
    skip_space();
    const auto [stop, error] = std::from_chars(p_, end_, value);
    if (error != std::errc{} || (stop != end_ && !is_space(*stop))) return false;
    p_ = stop;
    return true;
  }
  bool at_end() {
    skip_space();
    return p_ == end_;
  }
  /// What is left, without blanks around it.
  std::string_view rest() {
    skip_space();
    const char* last = end_;
    while (last != p_ && is_space(last[-1])) --last;
    return {p_, static_cast<std::size_t>(last - p_)};
  }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }
  void skip_space() {
    while (p_ != end_ && is_space(*p_)) ++p_;
  }
  const char* p_;
  const char* end_;
};

class NumberedLines {
 public:
  explicit NumberedLines(const ByteSource& source) : cursor_(source) {}
  bool at_end() const { return cursor_.at_end(); }
  std::uint64_t number() const { return number_; }  // of the line given last, from 1
  Result<std::string_view> next() {
    ++number_;
    std::string_view line;
    if (cursor_.line_at_hand(line)) return line;
    return cursor_.line();
  }

 private:
  Cursor cursor_;
  std::uint64_t number_ = 0;
};

/// Equal but for the case of ASCII letters; `lower` is in lower case.
inline bool is_word(std::string_view word, std::string_view lower) {
  if (word.size() != lower.size()) return false;
  for (std::size_t i = 0; i < word.size(); ++i) {
    const char c = word[i] >= 'A' && word[i] <= 'Z' ? static_cast<char>(word[i] - 'A' + 'a') : word[i];
    if (c != lower[i]) return false;
  }
  return true;
}

}  // namespace scanmill::formats
