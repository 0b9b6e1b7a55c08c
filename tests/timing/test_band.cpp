// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "timing/band.hpp"
#include "timing/yardstick.hpp"

namespace scanmill::timing {
namespace {

TEST(BandOf, IsMedianLeastAndGreatestInAnyOrder) {
  const Band odd = band_of({3, 1, 2}), even = band_of({4, 1, 3, 2}), one = band_of({0.12345649});
  EXPECT_EQ(odd.median, 2);
  EXPECT_EQ(odd.least, 1);
  EXPECT_EQ(odd.greatest, 3);
  EXPECT_EQ(even.median, 2.5);
  EXPECT_EQ(one.median, 0.123456);
  EXPECT_EQ(band_text(odd), "2.0000 [1.0000, 3.0000]");
}

TEST(Aligned, TakesTheWidestCellOfEachColumn) {
  EXPECT_EQ(aligned({{"a", "bb", "c"}, {"dddd", "e"}, {}}), "a     bb  c\ndddd  e\n");
  EXPECT_EQ(aligned({}), "");
}

TEST(Keys, KeepTheFirstProblemWithItsPlace) {
  const auto read = [](const char* text) {
    const auto root = document::parse_json(text, "x");
    EXPECT_TRUE(root.ok());
    std::string problem, word;
    double number = 0;
    int whole = 0;
    Band band;
    const Keys keys(&*root, "", problem);
    keys.read("word", word);
    for (const Keys& row : keys.list("rows")) {
      row.read("number", number);
      row.read_whole("whole", whole);
      row.read("band", band);
    }
    return problem.empty() ? word + " " + fixed(number, 1) + " " + std::to_string(whole) + " " + band_text(band)
                           : problem;
  };
  const std::string band = "\"band\": {\"median\": 2, \"least\": 1, \"greatest\": 3}";
  EXPECT_EQ(read(("{\"word\": \"w\", \"rows\": [{\"number\": 1.5, \"whole\": 7, " + band + "}]}").c_str()),
            "w 1.5 7 2.0000 [1.0000, 3.0000]");
  EXPECT_EQ(read("{\"word\": \"w\", \"rows\": []}"), "w 0.0 0 0.0000 [0.0000, 0.0000]");
  EXPECT_EQ(read("{\"word\": 3, \"rows\": 7}"), "word: wanted a text");
  EXPECT_EQ(read("{\"word\": \"w\"}"), "rows: wanted a list");
  EXPECT_EQ(read("{\"word\": \"w\", \"rows\": [{\"number\": 1, \"whole\": 1.5}]}"),
            "rows[0].whole: wanted a whole number that is not negative");
  EXPECT_EQ(read("{\"word\": \"w\", \"rows\": [{\"number\": -1}]}"),
            "rows[0].number: wanted a number that is not negative");
  EXPECT_EQ(read("{\"word\": \"w\", \"rows\": [{\"number\": 1, \"whole\": 2, \"band\": {\"median\": 2}}]}"),
            "rows[0].band.least: wanted a number that is not negative");
  EXPECT_EQ(read("[]"), "the document: wanted a map");
}

TEST(YardstickCpuSeconds, TakesItsTime) {
  const double seconds = yardstick_cpu_seconds();
  EXPECT_GT(seconds, 0.005);
  EXPECT_LT(seconds, 30);  // with sanitizers on a slow machine
}

}  // namespace
}  // namespace scanmill::timing
