// SPDX-License-Identifier: Apache-2.0
// Symmetric positive definite systems whose rows begin where they first differ from zero.
#pragma once
#include <cstddef>
#include <vector>

namespace scanmill {

/// Lower triangle by rows, row i from column first[i] on; Cholesky's L D L^T in place (George and Liu 1981, chapter 4):
/// what is zero before the first entry of a row stays zero. Fixed order, no pivots, only + - * /.
class Envelope {
 public:
  /// first[i] <= i
  explicit Envelope(std::vector<std::size_t> first);
  std::size_t size() const { return first_.size(); }
  /// column in [first[row], row]
  double& at(std::size_t row, std::size_t column) { return values_[begin_[row] + column - first_[row]]; }
  double at(std::size_t row, std::size_t column) const { return values_[begin_[row] + column - first_[row]]; }
  std::size_t first(std::size_t row) const { return first_[row]; }

  /// False when a pivot is not positive: the system is not definite.
  /// cost  sum of squares of the rows' lengths
  bool factor();
  /// After factor: b becomes the solution.
  void solve(std::vector<double>& b) const;

 private:
  std::vector<std::size_t> first_, begin_;
  std::vector<double> values_;
};

}  // namespace scanmill
