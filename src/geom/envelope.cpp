// SPDX-License-Identifier: Apache-2.0
#include "geom/envelope.hpp"

#include <algorithm>

namespace scanmill {

Envelope::Envelope(std::vector<std::size_t> first) : first_(std::move(first)) {
  std::size_t used = 0;
  for (std::size_t i = 0; i < first_.size(); ++i) {
    begin_.push_back(used);
    used += i - first_[i] + 1;
  }
  values_.assign(used, 0);
}

bool Envelope::factor() {
  for (std::size_t i = 0; i < size(); ++i) {
    // Row i of L times D, column by column; divided by D when the row is finished.
    for (std::size_t j = first_[i]; j < i; ++j) {
      double sum = at(i, j);
      for (std::size_t k = std::max(first_[i], first_[j]); k < j; ++k) sum -= at(i, k) * at(j, k);
      at(i, j) = sum;
    }
    double pivot = at(i, i);
    for (std::size_t k = first_[i]; k < i; ++k) {
      const double scaled = at(i, k) / at(k, k);
      pivot -= at(i, k) * scaled;
      at(i, k) = scaled;
    }
    if (!(pivot > 0)) return false;
    at(i, i) = pivot;
  }
  return true;
}

void Envelope::solve(std::vector<double>& b) const {
  for (std::size_t i = 0; i < size(); ++i)
    for (std::size_t k = first_[i]; k < i; ++k) b[i] -= at(i, k) * b[k];
  for (std::size_t i = 0; i < size(); ++i) b[i] /= at(i, i);
  for (std::size_t i = size(); i-- > 0;)
    for (std::size_t k = first_[i]; k < i; ++k) b[k] -= at(i, k) * b[i];
}

}  // namespace scanmill
