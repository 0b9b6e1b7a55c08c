// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "base/random.hpp"
#include "stars/complex.hpp"

namespace scanmill::stars {
namespace {

TEST(Fan, GrowsBeyondItsInlineRoom) {
  Fan fan;
  for (std::uint32_t t = 0; t < 40; ++t) fan.add(t * 3);
  ASSERT_EQ(fan.size(), 40u);
  fan.remove(0);
  fan.remove(57);
  fan.remove(117);
  EXPECT_EQ(fan.size(), 37u);
  EXPECT_TRUE(std::is_sorted(fan.begin(), fan.end()));
  EXPECT_EQ(std::find(fan.begin(), fan.end(), 57u), fan.end());
  const Fan moved(std::move(fan));
  EXPECT_EQ(moved.size(), 37u);
  EXPECT_EQ(*moved.begin(), 3u);
  EXPECT_TRUE(fan.empty());  // NOLINT: a moved fan is empty by contract
  fan.add(7);
  EXPECT_EQ(*fan.begin(), 7u);
}

/// Everything that can be asked of a complex; fans as sets.
struct State {
  std::int64_t open_edges, unused;
  std::vector<std::vector<std::uint32_t>> fans;
  std::vector<std::uint8_t> open, kept, alive;
  friend bool operator==(const State&, const State&) = default;
};

State state_of(const Complex& complex, std::size_t triangles) {
  State s{complex.open_edges(), complex.unused(), {}, {}, {}, {}};
  for (std::uint32_t v = 0; v < complex.vertex_count(); ++v) {
    s.fans.emplace_back(complex.fan(v).begin(), complex.fan(v).end());
    std::sort(s.fans.back().begin(), s.fans.back().end());
    s.open.push_back(complex.is_open(v));
    s.kept.push_back(complex.kept(v));
  }
  for (std::uint32_t t = 0; t < triangles; ++t) s.alive.push_back(complex.alive(t));
  return s;
}

void change_at_random(Complex& complex, Random& random, int steps) {
  const auto pick = [&](std::size_t n) { return static_cast<std::uint32_t>(random.next() % n); };
  for (int step = 0; step < steps; ++step) {
    const double what = random.uniform();
    if (what < 0.6) {
      const Triangle t{pick(complex.vertex_count()), pick(complex.vertex_count()), pick(complex.vertex_count())};
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0] && complex.edges_free(t))
        complex.add(t, static_cast<int>(pick(4)));
    } else if (what < 0.9 && complex.triangle_count() > 0) {
      const std::uint32_t t = pick(complex.triangle_count());
      if (complex.alive(t)) complex.remove(t);
    } else {
      const std::uint32_t v = pick(complex.vertex_count());
      if (!complex.kept(v)) complex.revive(v);
    }
  }
}

/// The counters, counted again from the triangles.
void expect_counters_hold(const Complex& complex) {
  std::int64_t open = 0, unused = 0;
  std::vector<int> ends(complex.vertex_count(), 0);
  for (std::uint32_t t = 0; t < complex.triangle_count(); ++t)
    for (std::size_t e = 0; e < 3 && complex.alive(t); ++e) {
      const std::uint32_t a = complex.triangle(t)[e], b = complex.triangle(t)[(e + 1) % 3];
      if (complex.half(b, a) != kNone) continue;
      ++open;
      ++ends[a];
      ++ends[b];
    }
  for (std::uint32_t v = 0; v < complex.vertex_count(); ++v) {
    unused += complex.kept(v) && complex.fan(v).empty();
    EXPECT_EQ(complex.is_open(v), ends[v] > 0) << "vertex " << v;
  }
  EXPECT_EQ(complex.open_edges(), open);
  EXPECT_EQ(complex.unused(), unused);
}

TEST(Complex, UndoRestoresEveryCounter) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed, 0, 1);
    std::vector<std::uint8_t> kept(14);
    for (auto& k : kept) k = random.uniform() < 0.7;
    Complex complex(kept);
    change_at_random(complex, random, 60);
    expect_counters_hold(complex);
    const std::size_t triangles = complex.triangle_count();
    const State before = state_of(complex, triangles);
    complex.begin();
    change_at_random(complex, random, 80);
    expect_counters_hold(complex);
    complex.undo();
    ASSERT_TRUE(state_of(complex, triangles) == before);
    for (std::size_t t = triangles; t < complex.triangle_count(); ++t)
      EXPECT_FALSE(complex.alive(static_cast<std::uint32_t>(t)));
    expect_counters_hold(complex);
  }
}

TEST(Complex, KeepForgetsTheWayBack) {
  Complex complex(std::vector<std::uint8_t>(4, 1));
  complex.begin();
  complex.add({0, 1, 2}, 3);
  EXPECT_EQ(complex.touched().size(), 1u);
  complex.keep();
  complex.undo();
  EXPECT_TRUE(complex.alive(0));
  EXPECT_EQ(complex.unused(), 1);
  EXPECT_EQ(complex.open_edges(), 3);
}

TEST(Complex, KnowsASingleFan) {
  Complex complex(std::vector<std::uint8_t>(9, 1));
  EXPECT_TRUE(complex.single_fan(0));
  complex.add({0, 1, 2}, 3);
  EXPECT_TRUE(complex.single_fan(0));
  complex.add({0, 3, 4}, 3);
  EXPECT_FALSE(complex.single_fan(0));
  std::vector<std::vector<std::uint32_t>> groups;
  complex.split_fans(0, groups);
  EXPECT_EQ(groups.size(), 2u);
  complex.add({0, 2, 3}, 3);
  EXPECT_TRUE(complex.single_fan(0));
  complex.add({0, 4, 1}, 3);  // closed
  EXPECT_TRUE(complex.single_fan(0));
  EXPECT_EQ(complex.open_edges(), 4);
  complex.add({0, 5, 6}, 3);
  complex.add({0, 6, 7}, 3);
  complex.add({0, 7, 5}, 3);  // a second closed fan
  EXPECT_FALSE(complex.single_fan(0));
  complex.split_fans(0, groups);
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(groups[0].size(), 4u);
  EXPECT_EQ(groups[1].size(), 3u);
}

/// Against split_fans, on fans of every kind.
TEST(Complex, SingleFanAgreesWithSplitFans) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Random random(seed, 0, 2);
    Complex complex(std::vector<std::uint8_t>(9, 1));
    change_at_random(complex, random, 50);
    std::vector<std::vector<std::uint32_t>> groups;
    for (std::uint32_t v = 0; v < 9; ++v) {
      complex.split_fans(v, groups);
      EXPECT_EQ(complex.single_fan(v), groups.size() < 2) << "seed " << seed << " vertex " << v;
    }
  }
}

}  // namespace
}  // namespace scanmill::stars
