// SPDX-License-Identifier: Apache-2.0
// Symmetric positive definite systems whose entries lie in a band about the diagonal.
#pragma once
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace scanmill {

/// The lower half of the band, row by row: n (band + 1) numbers.
class BandedSystem {
 public:
  BandedSystem(std::size_t n, std::size_t band) : n_(n), band_(band), rows_(n * (band + 1), 0.0), right_(n, 0.0) {}
  std::size_t size() const { return n_; }
  /// Adds to entry (row, column) and its mirror image; column <= row <= column + band.
  void add(std::size_t row, std::size_t column, double value) { at(row, column) += value; }
  void add_right(std::size_t row, double value) { right_[row] += value; }

  /// Solves by sparse LDL' (Eigen); an unknown that nothing determines is zero. Always the same order of + - * /.
  /// cost  that of the fill-in after minimum-degree ordering, O(n^1.5) for a grid of poles
  std::vector<double> solve() &&;

 private:
  double& at(std::size_t row, std::size_t column) { return rows_[row * (band_ + 1) + (column + band_ - row)]; }
  std::size_t n_, band_;
  std::vector<double> rows_, right_;
};

}  // namespace scanmill
