// SPDX-License-Identifier: Apache-2.0
// Repeated measurements: their median, their noise, and what counts as slower.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "document/document.hpp"

namespace scanmill::timing {

/// Median of the repeats with the noise band.
struct Band {
  double median = 0, least = 0, greatest = 0;
};
/// values  at least one, rounded to microseconds, which is what the clock tells
Band band_of(std::vector<double> values);

/// Beyond the noise: more than this factor.
inline constexpr double kSlower = 1.1;

document::Node to_document(const Band& band);
/// "0.0123 [0.0120, 0.0150]"
std::string band_text(const Band& band);
/// A number with so many digits after the point.
std::string fixed(double value, int digits);
/// Columns as wide as their widest cell, two blanks between; no line feed at the end.
std::string aligned(const std::vector<std::vector<std::string>>& rows);

/// Reads the keys of one map of a document; `problem` keeps the first key that is missing or no value of its kind.
class Keys {
 public:
  Keys(const document::Node* map, std::string place, std::string& problem);
  void read(const char* key, std::string& out) const;
  void read(const char* key, double& out) const;  // not negative
  void read(const char* key, Band& out) const;
  template <class Whole>
  void read_whole(const char* key, Whole& out) const {
    std::int64_t value = 0;
    if (whole(key, value)) out = static_cast<Whole>(value);
  }
  Keys map(const char* key) const { return Keys(value(key), path(key), problem_); }
  /// The entries of a list; none, and a problem, when it is no list.
  std::vector<Keys> list(const char* key) const;

 private:
  const document::Node* value(const char* key) const { return map_ ? map_->find(key) : nullptr; }
  bool whole(const char* key, std::int64_t& out) const;
  std::string path(const std::string& key) const;
  void complain(const std::string& key, const char* wanted) const;
  const document::Node* map_;
  std::string place_;
  std::string& problem_;
};

}  // namespace scanmill::timing
