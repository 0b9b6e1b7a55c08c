// SPDX-License-Identifier: Apache-2.0
#include "geom/banded.hpp"

namespace scanmill {

std::vector<double> BandedSystem::solve() && {
  constexpr double kNoPivot = 1e-13;
  const std::size_t width = band_ + 1;
  std::vector<double> scaled(width);
  std::vector<double> first(n_);  // diagonals before elimination
  for (std::size_t i = 0; i < n_; ++i) first[i] = at(i, i);
  for (std::size_t i = 0; i < n_; ++i) {
    double* row = &rows_[i * width];  // row[k] is column i - band + k
    const std::size_t begin = i > band_ ? i - band_ : 0;
    for (std::size_t j = begin; j < i; ++j) {
      const double* other = &rows_[j * width];
      const std::size_t from = std::max(begin, j > band_ ? j - band_ : 0);
      double sum = row[j + band_ - i];
      for (std::size_t k = from; k < j; ++k) sum -= scaled[k - begin] * other[k + band_ - j];
      scaled[j - begin] = sum;  // L times D
      row[j + band_ - i] = sum;
    }
    double pivot = row[band_];
    for (std::size_t j = begin; j < i; ++j) {
      const double diagonal = rows_[j * width + band_], value = scaled[j - begin];
      const double low = diagonal > 0 ? value / diagonal : 0;
      row[j + band_ - i] = low;
      pivot -= low * value;
    }
    row[band_] = pivot > kNoPivot * first[i] ? pivot : 0;
  }
  for (std::size_t i = 0; i < n_; ++i)
    for (std::size_t j = i > band_ ? i - band_ : 0; j < i; ++j) right_[i] -= at(i, j) * right_[j];
  for (std::size_t i = 0; i < n_; ++i) right_[i] = at(i, i) > 0 ? right_[i] / at(i, i) : 0;
  for (std::size_t i = n_; i-- > 0;)
    for (std::size_t j = i > band_ ? i - band_ : 0; j < i; ++j) right_[j] -= at(i, j) * right_[i];
  return std::move(right_);
}

}  // namespace scanmill
