// SPDX-License-Identifier: Apache-2.0
#include "geom/banded.hpp"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

namespace scanmill {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

constexpr double kRidge = 1e-12;  // of the greatest diagonal, where rounding left a pivot without sign

}  // namespace

std::vector<double> BandedSystem::solve() && {
  const auto n = static_cast<Eigen::Index>(n_);
  double greatest = 0;
  for (std::size_t i = 0; i < n_; ++i) greatest = std::max(greatest, at(i, i));
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(rows_.size());
  for (std::size_t i = 0; i < n_; ++i) {
    if (at(i, i) == 0) at(i, i) = 1, right_[i] = 0;  // nothing determines it
    for (std::size_t j = i > band_ ? i - band_ : 0; j <= i; ++j)
      if (at(i, j) != 0) entries.emplace_back(static_cast<int>(i), static_cast<int>(j), at(i, j));
  }
  Matrix lower(n, n);
  lower.setFromTriplets(entries.begin(), entries.end());
  const Eigen::Map<const Eigen::VectorXd> right(right_.data(), n);
  std::vector<double> solution(n_);
  Eigen::SimplicialLDLT<Matrix, Eigen::Lower> factors(lower);
  if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 0)) {
    factors.setShift(kRidge * greatest);
    factors.factorize(lower);
  }
  if (factors.info() == Eigen::Success) Eigen::Map<Eigen::VectorXd>(solution.data(), n) = factors.solve(right);
  return solution;
}

}  // namespace scanmill
