// SPDX-License-Identifier: Apache-2.0
#include "timing/band.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace scanmill::timing {

using document::Node;

Band band_of(std::vector<double> values) {
  for (double& value : values) value = std::round(value * 1e6) / 1e6;
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  const double median = values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
  return {median, values.front(), values.back()};
}

Node to_document(const Band& band) {
  Node node = Node::map();
  node.set("median", band.median);
  node.set("least", band.least);
  node.set("greatest", band.greatest);
  return node;
}

std::string fixed(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

std::string band_text(const Band& band) {
  return fixed(band.median, 4) + " [" + fixed(band.least, 4) + ", " + fixed(band.greatest, 4) + "]";
}

std::string aligned(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> width;
  for (const auto& row : rows) {
    width.resize(std::max(width.size(), row.size()), 0);
    for (std::size_t k = 0; k < row.size(); ++k) width[k] = std::max(width[k], row[k].size());
  }
  std::string text;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (r > 0) text += "\n";
    for (std::size_t k = 0; k < rows[r].size(); ++k)
      text += rows[r][k] + (k + 1 < rows[r].size() ? std::string(width[k] - rows[r][k].size() + 2, ' ') : "");
  }
  return text;
}

Keys::Keys(const Node* map, std::string place, std::string& problem)
    : map_(map), place_(std::move(place)), problem_(problem) {
  if (!map_ || !map_->is_map()) complain("", "a map");
}

void Keys::read(const char* key, std::string& out) const {
  const Node* node = value(key);
  if (node && node->is_string())
    out = node->as_string();
  else
    complain(key, "a text");
}

void Keys::read(const char* key, double& out) const {
  const Node* node = value(key);
  if (node && node->is_number() && node->as_number() >= 0)
    out = node->as_number();
  else
    complain(key, "a number that is not negative");
}

void Keys::read(const char* key, Band& out) const {
  const Keys band = map(key);
  band.read("median", out.median);
  band.read("least", out.least);
  band.read("greatest", out.greatest);
}

bool Keys::whole(const char* key, std::int64_t& out) const {
  const Node* node = value(key);
  if (!node || !node->is_integer() || node->as_integer() < 0) {
    complain(key, "a whole number that is not negative");
    return false;
  }
  out = node->as_integer();
  return true;
}

std::vector<Keys> Keys::list(const char* key) const {
  std::vector<Keys> entries;
  const Node* node = value(key);
  if (!node || !node->is_sequence()) {
    complain(key, "a list");
    return entries;
  }
  for (std::size_t k = 0; k < node->items().size(); ++k)
    entries.emplace_back(&node->items()[k], path(key) + "[" + std::to_string(k) + "]", problem_);
  return entries;
}

std::string Keys::path(const std::string& key) const {
  return place_.empty() ? key : key.empty() ? place_ : place_ + "." + key;
}

void Keys::complain(const std::string& key, const char* wanted) const {
  if (problem_.empty()) problem_ = (path(key).empty() ? "the document" : path(key)) + ": wanted " + wanted;
}

}  // namespace scanmill::timing
