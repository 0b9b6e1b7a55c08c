// SPDX-License-Identifier: Apache-2.0
// Cubic B-splines and banded systems against what must hold of them.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "geom/banded.hpp"
#include "geom/cubic.hpp"

namespace scanmill {
namespace {

TEST(Cubic, FunctionsSumToOneAndTheirDerivativesToNothing) {
  for (const std::size_t count : {1, 2, 3, 4, 9}) {
    const CubicSpans spans{count, 0.7};
    for (int k = 0; k <= 50; ++k) {
      const CubicBasis b = spans.basis(spans.end() * k / 50);
      ASSERT_LE(b.first + 4, spans.poles());
      EXPECT_NEAR(b.value[0] + b.value[1] + b.value[2] + b.value[3], 1, 1e-14);
      EXPECT_NEAR(b.slope[0] + b.slope[1] + b.slope[2] + b.slope[3], 0, 1e-12);
      EXPECT_NEAR(b.bend[0] + b.bend[1] + b.bend[2] + b.bend[3], 0, 1e-11);
    }
  }
}

TEST(Cubic, DerivativesAreThoseOfTheValues) {
  const CubicSpans spans{5, 1.3};
  const double d = 1e-5;
  for (int k = 1; k < 60; ++k) {
    const double t = spans.end() * k / 60 + 1e-3;
    const CubicBasis low = spans.basis(t - d), b = spans.basis(t), high = spans.basis(t + d);
    if (low.first != high.first) continue;
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_NEAR(b.slope[i], (high.value[i] - low.value[i]) / (2 * d), 1e-8);
      EXPECT_NEAR(b.bend[i], (high.slope[i] - low.slope[i]) / (2 * d), 1e-8);
    }
  }
}

TEST(Cubic, GrevillePlacesGiveAStraightLine) {
  const CubicSpans spans{6, 0.25};
  for (int k = 0; k <= 40; ++k) {
    const double t = spans.end() * k / 40;
    const CubicBasis b = spans.basis(t);
    double x = 0;
    for (std::size_t i = 0; i < 4; ++i) x += b.value[i] * spans.greville(b.first + i);
    EXPECT_NEAR(x, t, 1e-14);
  }
}

TEST(Cubic, TablesGiveWhatTheRecurrenceGives) {
  for (const std::size_t count : {1, 2, 3, 5, 8}) {
    const CubicSpans spans{count, 2.1};
    const CubicTable table(spans);
    for (int k = 0; k <= 70; ++k) {
      const double t = spans.end() * k / 70;
      const CubicBasis b = spans.basis(t);
      const CubicTable::Values v = table.at(t);
      ASSERT_EQ(v.first, b.first);
      for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_NEAR(v.value[i], b.value[i], 1e-13) << count << " spans at " << t;
        EXPECT_NEAR(v.slope[i], b.slope[i], 1e-12);
      }
    }
  }
}

TEST(Cubic, GramMatricesAreIntegrals) {
  const CubicSpans spans{3, 0.8};
  for (int order = 0; order < 3; ++order) {
    const std::vector<double> gram = cubic_gram(spans, order);
    std::vector<double> sums(gram.size(), 0.0);
    constexpr int kSteps = 30000;
    for (int k = 0; k < kSteps; ++k) {
      const CubicBasis b = spans.basis(spans.end() * (k + 0.5) / kSteps);
      const auto& f = order == 0 ? b.value : order == 1 ? b.slope : b.bend;
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = i; j < 4; ++j) sums[4 * (b.first + i) + (j - i)] += f[i] * f[j] * spans.end() / kSteps;
    }
    for (std::size_t k = 0; k < gram.size(); ++k) EXPECT_NEAR(gram[k], sums[k], 1e-5 * (1 + std::abs(sums[k])));
  }
}

TEST(BandedSystem, SolvesLikeADenseSolver) {
  constexpr std::size_t kSize = 40, kBand = 7;
  BandedSystem system(kSize, kBand);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(kSize, kSize);
  Eigen::VectorXd right(kSize);
  for (std::size_t i = 0; i < kSize; ++i) {
    for (std::size_t j = i > kBand ? i - kBand : 0; j <= i; ++j) {
      const double value = i == j ? 9 + 0.1 * static_cast<double>(i) : std::sin(static_cast<double>(7 * i + 3 * j));
      system.add(i, j, value);
      dense(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = value;
      dense(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(i)) = value;
    }
    right(static_cast<Eigen::Index>(i)) = std::cos(static_cast<double>(i));
    system.add_right(i, std::cos(static_cast<double>(i)));
  }
  const Eigen::VectorXd wanted = dense.ldlt().solve(right);
  const std::vector<double> found = std::move(system).solve();
  for (std::size_t i = 0; i < kSize; ++i) EXPECT_NEAR(found[i], wanted(static_cast<Eigen::Index>(i)), 1e-12);
}

TEST(BandedSystem, LeavesAnUnknownAtZeroThatNothingDetermines) {
  BandedSystem system(3, 1);
  system.add(0, 0, 2);
  system.add(2, 2, 4);
  system.add_right(0, 6);
  system.add_right(2, 2);
  EXPECT_EQ(std::move(system).solve(), (std::vector<double>{3, 0, 0.5}));
}

}  // namespace
}  // namespace scanmill
