// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <zlib.h>

#include <vector>

#include "base/random.hpp"
#include "base/run_deflate.hpp"

namespace scanmill {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes inflated(const std::string& text, std::size_t size) {
  Bytes out(size + 1);
  uLongf length = out.size();
  const int state = uncompress(out.data(), &length, reinterpret_cast<const Bytef*>(text.data()), text.size());
  EXPECT_EQ(state, Z_OK);
  out.resize(state == Z_OK ? length : 0);
  return out;
}

void expect_comes_back(const Bytes& bytes) {
  const std::string text = run_deflated(bytes);
  EXPECT_TRUE(inflated(text, bytes.size()) == bytes) << bytes.size() << " bytes";
  EXPECT_EQ(text, run_deflated(bytes));
}

TEST(RunDeflate, ComesBackFromZlibWhateverItHolds) {
  expect_comes_back({});
  expect_comes_back({7});
  Random random(1, 2, 3);
  for (const std::size_t size : {2u, 3u, 1000u, 40000u, 300000u}) {
    Bytes noise(size), few(size), steps(size);
    for (std::size_t n = 0; n < size; ++n) {
      noise[n] = static_cast<std::uint8_t>(random.next());
      few[n] = static_cast<std::uint8_t>(random.next() % 3);
      steps[n] = static_cast<std::uint8_t>(n / 777);
    }
    expect_comes_back(noise);
    expect_comes_back(few);
    expect_comes_back(steps);
    expect_comes_back(Bytes(size, 255));
  }
}

TEST(RunDeflate, KnowsRunsOfEveryLength) {
  Bytes bytes;
  for (std::size_t length = 1; length < 600; ++length)
    bytes.insert(bytes.end(), length, static_cast<std::uint8_t>(length));
  expect_comes_back(bytes);
}

/// Weights like Fibonacci numbers ask for codes longer than the 15 bits that the format has.
TEST(RunDeflate, KeepsCodesShortWhereBytesAreMostUneven) {
  Bytes bytes;
  std::size_t a = 1, b = 1;
  for (std::uint8_t value = 0; value < 22; ++value) {
    for (std::size_t n = 0; n < a; ++n) {
      bytes.push_back(value);
      bytes.push_back(static_cast<std::uint8_t>(100 + n % 2));
    }
    std::swap(a, b);
    b += a;
  }
  expect_comes_back(bytes);
}

TEST(RunDeflate, MakesRunsSmall) { EXPECT_LT(run_deflated(Bytes(1000000, 0)).size(), 5000u); }

}  // namespace
}  // namespace scanmill
