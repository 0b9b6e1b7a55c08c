// SPDX-License-Identifier: Apache-2.0
#include "fake_work.hpp"
#include "runner/journal.hpp"
#include "runner/worklist.hpp"

namespace scanmill::runner {
namespace {

using document::Node;

Node event(const char* type, const std::string& scan) {
  Node node = Node::map();
  node.set("type", type);
  node.set("scan", scan);
  return node;
}

class JournalFile : public RunnerTest {};

TEST_F(JournalFile, LoadsWholeLinesAfterACutAtEveryByte) {
  std::string text;
  std::vector<std::size_t> ends{0};
  for (const char* scan : {"plain", "with \"quotes\" and \\", "Деталь\n\t", ""}) {
    text += journal_line(event("end", scan));
    ends.push_back(text.size());
  }
  for (std::size_t cut = 0; cut <= text.size(); ++cut) {
    const auto events = read_journal(text.substr(0, cut));
    const auto whole = static_cast<std::size_t>(std::upper_bound(ends.begin(), ends.end(), cut) - ends.begin()) - 1;
    ASSERT_EQ(events.size(), whole) << "cut at " << cut;
  }
  EXPECT_EQ(read_journal(text)[2].find("scan")->as_string(), "Деталь\n\t");
}

TEST_F(JournalFile, StopsAtADamagedLine) {
  const std::string first = journal_line(event("start", "a")), second = journal_line(event("start", "b"));
  for (std::size_t at = 0; at < second.size(); ++at) {
    std::string damaged = first + second + first;
    damaged[first.size() + at] ^= 1;
    ASSERT_EQ(read_journal(damaged).size(), 1u) << "byte " << at;
  }
}

TEST_F(JournalFile, CountsEpochsUp) {
  EXPECT_EQ(latest_epoch(root), 0u);
  {
    auto one = Journal::begin(root, event("run", ""));
    ASSERT_TRUE(one.ok());
    EXPECT_EQ(one->epoch(), 1u);
    one->add(event("start", "a"));
    EXPECT_EQ(load_journal(root, 1).size(), 1u);  // the head; the line waits
    ASSERT_TRUE(one->commit(true).ok());
    EXPECT_EQ(load_journal(root, 1).size(), 2u);
    one->add(event("end", "a"));
  }
  EXPECT_EQ(load_journal(root, 1).size(), 3u);  // the end commits
  spill(root + "/17.jsonl", "");
  spill(root + "/x.jsonl", "");
  const auto next = Journal::begin(root, event("run", ""));
  ASSERT_TRUE(next.ok());
  EXPECT_EQ(next->epoch(), 18u);
  EXPECT_EQ(epochs_in(root), (std::vector<std::uint64_t>{1, 17, 18}));
}

Worklist list_of(std::initializer_list<std::uint64_t> bytes) {
  Worklist list;
  std::size_t scan = 0;
  for (const std::uint64_t n : bytes) list.add({scan++, n, 0, {}, 0, 0});
  return list;
}

TEST(Worklist, StartsTheHeaviestFirstWithItsShareOfCores) {
  const Moment now = std::chrono::steady_clock::now();
  Worklist list = list_of({10, 1000, 10, 10});
  const auto giant = list.next({4, 4, 0, 0}, now);
  ASSERT_TRUE(giant);
  EXPECT_EQ(giant->first.scan, 1u);
  EXPECT_EQ(giant->second.threads, 4);
  Worklist even = list_of({10, 10, 10, 10});
  std::vector<std::size_t> order;
  while (!even.empty()) {
    const auto next = even.next({4, 4, 0, 0}, now);
    ASSERT_TRUE(next);
    order.push_back(next->first.scan);
    EXPECT_LE(next->second.threads, 4);
    if (order.size() == 1) {
      EXPECT_EQ(next->second.threads, 1);
    }
  }
  EXPECT_EQ(order, (std::vector<std::size_t>{0, 1, 2, 3}));
  EXPECT_FALSE(list.next({4, 0, 0, 0}, now)) << "no core is free";
}

TEST(Worklist, NeverGivesMoreMemoryThanThereIs) {
  const Moment now = std::chrono::steady_clock::now();
  constexpr std::uint64_t kGiB = 1ull << 30;
  Worklist list = list_of({kGiB / 4, kGiB / 8, 1000, 1000});
  Room room{2, 2, 2 * kGiB, 2 * kGiB};
  std::uint64_t given = 0;
  while (const auto next = list.next(room, now)) {
    EXPECT_GE(next->second.memory, std::min(room.memory, memory_guess(next->first.bytes)));
    given += next->second.memory;
    room.memory_free -= next->second.memory;
    room.cores_free -= next->second.threads;
    ASSERT_LE(given, room.memory);
  }
  EXPECT_LT(list.size(), 4u);
}

TEST(Worklist, PassesAnItemOverAFewTimesOnly) {
  const Moment now = std::chrono::steady_clock::now();
  constexpr std::uint64_t kGiB = 1ull << 30;
  Worklist list = list_of({kGiB});
  for (std::size_t i = 0; i < 40; ++i) list.add({i + 1, 10, 0, {}, 0, 0});
  std::size_t passed = 0;
  while (const auto next = list.next({8, 4, 8 * kGiB, kGiB}, now)) {
    EXPECT_NE(next->first.scan, 0u);
    ++passed;
  }
  EXPECT_GT(passed, 0u);
  EXPECT_LT(passed, 40u);
  const auto turn = list.next({8, 8, 8 * kGiB, 8 * kGiB}, now);
  ASSERT_TRUE(turn);
  EXPECT_EQ(turn->first.scan, 0u);
}

TEST(Worklist, WaitsForItsMoment) {
  const Moment now = std::chrono::steady_clock::now();
  Worklist list;
  list.add({0, 100, 0, now + std::chrono::seconds(5), 0, 0});
  list.add({1, 10, 0, {}, 0, 0});
  EXPECT_EQ(list.next({1, 1, 0, 0}, now)->first.scan, 1u);
  EXPECT_FALSE(list.next({1, 1, 0, 0}, now));
  EXPECT_EQ(list.next_moment(now), now + std::chrono::seconds(5));
  EXPECT_TRUE(list.next({1, 1, 0, 0}, now + std::chrono::seconds(6)));
}

}  // namespace
}  // namespace scanmill::runner
