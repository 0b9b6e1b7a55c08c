// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "runner/console.hpp"
#include "runner/machine.hpp"

namespace scanmill::runner {
namespace {

struct Streams {
  std::FILE* out = std::tmpfile();
  std::FILE* err = std::tmpfile();
  ~Streams() {
    std::fclose(out);
    std::fclose(err);
  }
  static std::string text(std::FILE* file) {
    std::string all(static_cast<std::size_t>(std::ftell(file)), '\0');
    std::rewind(file);
    all.resize(std::fread(all.data(), 1, all.size(), file));
    return all;
  }
};

void show_all(const ConsoleOptions& options, Streams& streams) {
  Console console(options, streams.out, streams.err);
  console.begin("scan");
  console.result("result", Console::event("scan"));
  console.problem("problem", Console::event("error"));
  console.last("last", Console::event("summary"));
}

TEST(Console, KeepsResultsAndProblemsApart) {
  Streams streams;
  show_all({ProgressStyle::None, false, false}, streams);
  EXPECT_EQ(Streams::text(streams.out), "result\nlast\n");
  EXPECT_EQ(Streams::text(streams.err), "problem\n");
}

TEST(Console, QuietKeepsProblemsAndTheLastLine) {
  Streams streams;
  show_all({ProgressStyle::Auto, false, true}, streams);
  EXPECT_EQ(Streams::text(streams.out), "last\n");
  EXPECT_EQ(Streams::text(streams.err), "problem\n");
}

TEST(Console, JsonIsOneObjectWithTypePerLine) {
  Streams streams;
  show_all({ProgressStyle::None, true, false}, streams);
  EXPECT_EQ(Streams::text(streams.out), "{\"type\":\"scan\"}\n{\"type\":\"error\"}\n{\"type\":\"summary\"}\n");
}

TEST(Console, TtyProgressIsRedrawnAndErased) {
  Streams streams;
  {
    Console console({ProgressStyle::Tty, false, false}, streams.out, streams.err);
    console.begin("scan");
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(150);
    while (std::chrono::steady_clock::now() < end) console.stage("reduce", 500, 1000);
    console.end();
  }
  const std::string text = Streams::text(streams.err);
  EXPECT_NE(text.find("scan  reduce  500/1.0k  50%"), std::string::npos) << text;
  EXPECT_NE(text.find("ETA"), std::string::npos) << text;
  EXPECT_EQ(text.substr(text.size() - 4), "\r\x1b[J");
}

TEST(ClockText, CountsHoursMinutesSeconds) {
  EXPECT_EQ(clock_text(67.9), "00:01:07");
  EXPECT_EQ(clock_text(100 * 3600.0), "100:00:00");
}

}  // namespace
}  // namespace scanmill::runner
