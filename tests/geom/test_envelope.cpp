// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "base/random.hpp"
#include "geom/envelope.hpp"

namespace scanmill {
namespace {

TEST(Envelope, SolvesWhatAFullMatrixSolves) {
  // A ring of blocks: rows begin at different columns, the last reaches back to the first.
  const std::size_t n = 30;
  Random random(1, 0, 0);
  std::vector<std::size_t> first;
  for (std::size_t i = 0; i < n; ++i) first.push_back(i > 25 ? 0 : i - std::min<std::size_t>(i, 4));
  std::vector<std::vector<double>> full(n, std::vector<double>(n, 0.0));
  Envelope system(first);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = first[i]; j <= i; ++j)
      full[i][j] = full[j][i] = system.at(i, j) = i == j ? 20 : random.uniform(-1, 1);
  std::vector<double> x(n), b(n, 0.0);
  for (double& value : x) value = random.uniform(-3, 3);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) b[i] += full[i][j] * x[j];
  ASSERT_TRUE(system.factor());
  system.solve(b);
  for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(b[i], x[i], 1e-12);
  Envelope flat({0, 0});
  flat.at(0, 0) = flat.at(1, 0) = flat.at(1, 1) = 1;
  EXPECT_FALSE(flat.factor());
}

}  // namespace
}  // namespace scanmill
