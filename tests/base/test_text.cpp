// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/text.hpp"

namespace scanmill {
namespace {

TEST(WordsOf, CutsAtBlanksTabsAndCarriageReturns) {
  EXPECT_EQ(words_of("  a\tb c\r"), (std::vector<std::string_view>{"a", "b", "c"}));
  EXPECT_TRUE(words_of(" \t\r").empty());
  EXPECT_TRUE(words_of("").empty());
}

TEST(LinesOf, KeepsEmptyLines) {
  EXPECT_EQ(lines_of("a\n\nb"), (std::vector<std::string>{"a", "", "b"}));
  EXPECT_EQ(lines_of(""), (std::vector<std::string>{""}));
}

TEST(IsInside, RefusesEveryWayOut) {
  for (const char* path : {"a", "a/b.ply", "a/..b/c..", "./a", "..."}) EXPECT_TRUE(is_inside(path)) << path;
  for (const char* path : {"", "/a", "..", "../a", "a/..", "a/../../b"}) EXPECT_FALSE(is_inside(path)) << path;
  EXPECT_FALSE(is_inside(std::string_view("a\0b", 3)));
}

TEST(ParseNumber, TakesOneSign) {
  EXPECT_EQ(parse_number("+1.5"), 1.5);
  EXPECT_FALSE(parse_number("+-1.5").has_value());
  EXPECT_FALSE(parse_number("++1").has_value());
  EXPECT_FALSE(parse_number("+").has_value());
}

}  // namespace
}  // namespace scanmill
