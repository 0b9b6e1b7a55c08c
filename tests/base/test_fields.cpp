// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "base/fields.hpp"

namespace scanmill {
namespace {

enum class Kind : std::int32_t { One, Two };

struct Sample {
  double edge_mm = 1;
  std::int64_t count = 2;
  bool exact = false;
  std::optional<double> share = {};
  Kind kind = Kind::Two;
  static std::span<const Field> fields() {
    static constexpr std::string_view kKinds[] = {"one", "two"};
    static const Field kTable[] = {
        field<Sample, &Sample::edge_mm>("edge_mm", "h", "", {0, 10, true}),
        field<Sample, &Sample::count>("count", "", "", {1, 5}),
        field<Sample, &Sample::exact>("exact", "", ""),
        field<Sample, &Sample::share>("share", "", "", {0, 1}),
        field<Sample, &Sample::kind>("kind", "", "", {}, kKinds),
    };
    return kTable;
  }
};

std::vector<std::string> problems(const Sample& sample) { return problems_of(Sample::fields(), &sample); }

TEST(Fields, FindNothingWrongWithinLimits) {
  EXPECT_TRUE(problems({}).empty());
  EXPECT_TRUE(problems({.edge_mm = 10, .count = 5, .share = 0.0}).empty());
  EXPECT_TRUE(problems({.edge_mm = 1e-300, .count = 1, .share = 1.0}).empty());
}

TEST(Fields, NameEachValueOutsideItsLimits) {
  EXPECT_EQ(problems({.edge_mm = 0}), (std::vector<std::string>{"edge_mm: found 0; allowed (0, 10]"}));
  EXPECT_EQ(problems({.edge_mm = 11, .count = 0, .share = -0.5}),
            (std::vector<std::string>{"edge_mm: found 11; allowed (0, 10]", "count: found 0; allowed [1, 5]",
                                      "share: found -0.5; allowed [0, 1]"}));
}

TEST(Fields, RefuseWhatIsNoNumber) {
  EXPECT_EQ(problems({.edge_mm = NAN}).size(), 1u);
  EXPECT_EQ(problems({.share = NAN}).size(), 1u);
  EXPECT_EQ(problems({.edge_mm = INFINITY}).size(), 1u);
}

TEST(Fields, ReachTheMembersTheyName) {
  Sample sample;
  const auto table = Sample::fields();
  *std::get<double* (*)(void*)>(table[0].member)(&sample) = 7;
  *std::get<bool* (*)(void*)>(table[2].member)(&sample) = true;
  *std::get<std::int32_t* (*)(void*)>(table[4].member)(&sample) = 0;
  EXPECT_EQ(sample.edge_mm, 7);
  EXPECT_TRUE(sample.exact);
  EXPECT_EQ(sample.kind, Kind::One);
}

}  // namespace
}  // namespace scanmill
