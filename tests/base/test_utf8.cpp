// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/utf8.hpp"

namespace scanmill {
namespace {

TEST(Printable, KeepsWordsOfAnyTongue) {
  const std::string text = "Gehäuse_Ø12 \xe9\x83\xa8\xe5\x93\x81 \xf0\x9f\x94\xa9 <&\"'>";
  EXPECT_EQ(printable(text), text);
}

TEST(Printable, ShowsWhatCannotBeSeen) {
  EXPECT_EQ(printable(std::string_view("a\0b\x1b[31m\x7f\r", 10)), "a\\x00b\\x1b[31m\\x7f\\x0d");
  EXPECT_EQ(printable("a\nb\tc"), "a\\x0ab\\x09c");
  EXPECT_EQ(printable("a\nb\tc\r", true), "a\nb\tc\\x0d");
  EXPECT_EQ(printable("\xe2\x80\xae\xef\xbb\xbf\xc2\x85\xef\xbf\xbf"), "\\u{202e}\\u{feff}\\u{0085}\\u{ffff}");
  EXPECT_EQ(printable("\xf0\x9f\xbf\xbe"), "\\u{01fffe}");
}

TEST(Printable, ShowsBytesThatAreNoUtf8) {
  EXPECT_EQ(printable("\xff"), "\\xff");
  EXPECT_EQ(printable("\xc3"), "\\xc3");                             // cut
  EXPECT_EQ(printable("\xc0\xaf"), "\\xc0\\xaf");                    // overlong
  EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");           // a surrogate
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");  // beyond the last character
  EXPECT_EQ(printable("\xe4r"), "\\xe4r");
}

}  // namespace
}  // namespace scanmill
