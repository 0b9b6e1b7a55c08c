// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <new>
#include <thread>
#include <vector>

#include "base/digest.hpp"
#include "base/paged_memory.hpp"
#include "support/temp_folder.hpp"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // they have operators of their own

namespace scanmill {
namespace {

constexpr std::uint64_t kMiB = 1 << 20;

std::uint64_t resident() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t size = 0, pages = 0;
  file >> size >> pages;
  return pages * 4096;
}

/// Values that tell their place.
void fill(std::vector<std::uint64_t>& values, std::uint64_t seed) {
  for (std::size_t n = 0; n < values.size(); ++n) values[n] = mix64(seed + n);
}
bool holds(const std::vector<std::uint64_t>& values, std::uint64_t seed) {
  for (std::size_t n = 0; n < values.size(); ++n)
    if (values[n] != mix64(seed + n)) return false;
  return true;
}

TEST(PagedMemory, KeepsWhatIsWrittenAndStaysUnderTheLimit) {
  const support::TempFolder folder;
  const std::uint64_t limit = resident() + 48 * kMiB;
  paged::begin(folder.path(), {limit, 4 * kMiB, 0});
  std::vector<std::vector<std::uint64_t>> pieces(40);
  std::uint64_t most = 0;
  for (std::size_t n = 0; n < pieces.size(); ++n) {
    pieces[n].resize(kMiB);  // 8 MiB
    fill(pieces[n], n);
    most = std::max(most, resident());
  }
  EXPECT_GE(paged::usage().in_file, 300 * kMiB);
  EXPECT_LT(most, limit + 32 * kMiB);
  for (std::size_t n = 0; n < pieces.size(); ++n) EXPECT_TRUE(holds(pieces[n], n)) << n;
  pieces.clear();
  EXPECT_LT(paged::usage().in_file, 8 * kMiB);
  EXPECT_GT(paged::usage().evictions, 0u);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << "the file has no name";
}

TEST(PagedMemory, GivesPiecesOfEverySizeToManyThreads) {
  const support::TempFolder folder;
  paged::begin(folder.path(), {0, 0, 0});
  std::vector<std::thread> threads;
  std::atomic<int> wrong{0};
  for (std::uint64_t who = 0; who < 4; ++who)
    threads.emplace_back([&, who] {
      std::vector<std::vector<std::uint64_t>> pieces(64);
      std::vector<std::uint64_t> seeds(pieces.size());
      for (std::uint64_t step = 0; step < 4000; ++step) {
        const std::uint64_t lot = mix64(who * 1000000 + step);
        const std::size_t at = lot % pieces.size();
        if (!holds(pieces[at], seeds[at])) ++wrong;
        pieces[at] = std::vector<std::uint64_t>(100 + (lot >> 8) % (step % 50 == 0 ? 60000 : 3000));
        seeds[at] = lot;
        fill(pieces[at], lot);
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

struct alignas(64) Line {
  char bytes[64];
};

TEST(PagedMemory, KeepsAlignment) {
  const support::TempFolder folder;
  paged::begin(folder.path(), {0, 0, 0});
  for (std::size_t count = 1; count < 70000; count = count * 3 + 1) {
    const std::vector<Line> lines(count);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(lines.data()) % 64, 0u) << count;
  }
}

TEST(PagedMemory, SaysWhyThereIsNoMore) {
  const support::TempFolder folder;
  paged::begin(folder.path(), {0, 0, 16 * kMiB + paged::usage().in_file});
  EXPECT_THROW(std::vector<char>(64 * kMiB), std::bad_alloc);
  EXPECT_NE(paged::refusal().find("MiB of disk allowed"), std::string::npos) << paged::refusal();
  EXPECT_EQ(paged::refusal().find(folder.path()), 0u) << paged::refusal();
  EXPECT_NO_THROW(std::vector<char>(4 * kMiB));
}

TEST(PagedMemory, IsNotTheBusinessOfAChild) {
  const support::TempFolder folder;
  paged::begin(folder.path(), {0, 0, 0});
  std::vector<std::uint64_t> values(kMiB);
  fill(values, 7);
  const pid_t child = fork();
  if (child == 0) _exit(0);
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(holds(values, 7));
}

}  // namespace
}  // namespace scanmill

#endif
