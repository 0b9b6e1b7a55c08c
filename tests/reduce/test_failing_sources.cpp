// SPDX-License-Identifier: Apache-2.0
// Sources that fail, or that change between two readings.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "clouds.hpp"
#include "reduce/reduce.hpp"

namespace scanmill::reduce {
namespace {

Result<Reduction> run(const PointSource& points, const Params& params, int threads) {
  const ChunkLoop loop(threads);
  const CancelFlag cancel;
  LatticeParams lattice;
  lattice.bin_mm = 1;
  return reduce_cloud(points, lattice, params, {loop, cancel});
}

/// The last block fails at once, an earlier one after a while.
class TwoFailures final : public PointSource {
 public:
  std::size_t block_count() const override { return 64; }
  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    out.clear();
    if (number == 63) return fail(Code::BadInput, "late block");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (number == 20) return fail(Code::BadInput, "early block");
    out.positions = {{0.5, 0.5, 0.5}};
    out.rows = {number};
    out.points_read = 1;
    return {};
  }
  std::uint64_t expected_points() const override { return 64; }
};

TEST(ReduceCloud, ReportsTheFirstFailureWhateverTheThreads) {
  for (const int threads : {1, 2, 7})
    for (int again = 0; again < 5; ++again) {
      const auto result = run(TwoFailures(), {}, threads);
      ASSERT_FALSE(result.ok());
      EXPECT_EQ(result.error().message, "early block") << "threads " << threads;
    }
}

/// The first reading gives a cube of points, later ones give it without its last point, or with one more.
class Changing final : public PointSource {
 public:
  enum class Change { Fewer, More };
  explicit Changing(Change change) : change_(change) {}
  std::size_t block_count() const override { return 1; }
  Result<void> read_block(std::size_t, PointBlock& out) const override {
    out.clear();
    for (std::uint64_t i = 0; i < 27; ++i) {
      const double x = static_cast<double>(i / 9), y = static_cast<double>(i / 3 % 3), z = static_cast<double>(i % 3);
      out.positions.push_back({x + 0.5, y + 0.5, z + 0.5});
      out.rows.push_back(i);
    }
    // The search for a first point, the first pass, the second pass.
    if (++readings_ >= 3) {
      if (change_ == Change::Fewer)
        out.positions.pop_back(), out.rows.pop_back();
      else
        out.positions.push_back({9.5, 9.5, 9.5}), out.rows.push_back(27);
    }
    out.points_read = out.positions.size();
    return {};
  }
  std::uint64_t expected_points() const override { return 27; }

 private:
  Change change_;
  mutable std::atomic<int> readings_{0};
};

TEST(ReduceCloud, NoticesPointsThatComeBetweenTheReadings) {
  const auto result = run(Changing(Changing::Change::More), {}, 1);
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.error().message.find("changed between"), std::string::npos) << result.error().message;
}

TEST(ReduceCloud, NoticesBinsThatVanishBetweenTheReadings) {
  const auto result = run(Changing(Changing::Change::Fewer), {}, 1);
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.error().message.find("changed between"), std::string::npos) << result.error().message;
}

}  // namespace
}  // namespace scanmill::reduce
