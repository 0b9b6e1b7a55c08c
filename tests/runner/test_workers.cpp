// SPDX-License-Identifier: Apache-2.0
// Runs with a process for every scan: what dies, hangs or hogs costs that scan alone.
#include <csignal>
#include <cstring>
#include <ctime>
#include <fstream>
#include <set>

#include "fake_work.hpp"
#include "runner/driver.hpp"
#include "runner/journal.hpp"
#include "runner/machine.hpp"
#include "runner/quarantine.hpp"

namespace scanmill::runner {
namespace {

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

class Workers : public RunnerTest {
 protected:
  void scan(const std::string& name, const std::string& words) { spill(root + "/archive/" + name + ".txt", words); }

  int run(std::function<void(RunOptions&)> change = {}) {
    spill(root + "/job.yaml", job_text);
    RunOptions options;
    options.job = root + "/job.yaml";
    options.out = root + "/out";
    options.threads = 2;
    options.executor = "local";
    options.memory = 512ull << 20;
    if (change) change(options);
    std::FILE* out = std::tmpfile();
    std::FILE* err = std::tmpfile();
    int code = 0;
    {
      Stop stop;
      Console console({ProgressStyle::None, false, false}, out, err);
      code = run_job(options, work, console, stop);
    }
    text = drain(out) + drain(err);
    if (auto tree = document::parse_json(slurp(root + "/out/run.json"), "run.json")) report = *tree;
    return code;
  }
  static std::string drain(std::FILE* file) {
    std::string all(static_cast<std::size_t>(std::ftell(file)), '\0');
    std::rewind(file);
    all.resize(std::fread(all.data(), 1, all.size(), file));
    std::fclose(file);
    return all;
  }
  const document::Node* entry(const std::string& scan) const {
    for (const document::Node& one : report.find("scans")->items())
      if (one.find("name")->as_string() == scan) return &one;
    return nullptr;
  }
  std::string state(const std::string& scan) const { return entry(scan)->find("state")->as_string(); }
  std::string error(const std::string& scan, const char* key) const {
    const document::Node* found = entry(scan)->find("error");
    return found ? found->find(key)->as_string() : "";
  }
  /// How often a scan was worked on, over all processes.
  std::size_t tries(const std::string& scan) const { return slurp(root + "/tries-" + scan).size(); }
  void count_try(const std::string& scan) const { std::ofstream(root + "/tries-" + scan, std::ios::app) << "."; }

  FakeWork work;
  std::string job_text = "scanmill: 1\narchive: archive\nsettle_s: 0\nlattice: {bin_mm: 1}\nretry: {wait_s: 0.05}\n";
  std::string text;
  document::Node report;
};

TEST_F(Workers, WhatDiesHangsOrIsBadCostsThatScanAlone) {
  job_text += "resources: {scan_time_limit: 3}\n";
  for (const char* name : {"bad", "crash", "fine", "good", "hang", "throws"}) scan(name, name);
  work.before_end = [&](const std::string& name) {
    count_try(name);
    if (name == "crash") raise(SIGABRT);
    while (name == "hang") pause();
  };
  EXPECT_EQ(run(), 3) << text;
  EXPECT_EQ(state("fine"), "done");
  EXPECT_EQ(state("good"), "done");
  EXPECT_EQ(error("bad", "class"), "bad_input");
  EXPECT_EQ(error("throws", "class"), "internal");
  EXPECT_EQ(error("crash", "class"), "internal");
  EXPECT_NE(error("crash", "text").find("signal 6"), std::string::npos) << error("crash", "text");
  EXPECT_NE(error("hang", "text").find("time limit"), std::string::npos) << error("hang", "text");
  EXPECT_EQ(error("hang", "stage"), "reduce");
  EXPECT_NE(error("hang", "repeat").find("--only hang"), std::string::npos);
  EXPECT_EQ(tries("crash"), 2u) << "a crash is tried once more";
  EXPECT_EQ(tries("hang"), 1u);
  EXPECT_EQ(entry("crash")->find("attempts")->as_integer(), 2);

  // The next night they are passed over with a line each, and nothing is wrong.
  EXPECT_EQ(run(), 0) << text;
  for (const char* name : {"bad", "crash", "hang", "throws"}) EXPECT_EQ(state(name), "quarantined") << name;
  EXPECT_NE(text.find("scan crash: quarantined"), std::string::npos) << text;
  EXPECT_EQ(tries("crash"), 2u);
  job_text += "strict: true\n";
  EXPECT_EQ(run(), 3);
  // A file that changed is tried again.
  work.before_end = {};
  scan("crash", "mended");
  EXPECT_EQ(run([](RunOptions&) {}), 3);
  EXPECT_EQ(state("crash"), "done");
}

TEST_F(Workers, AreGivenAnotherTryWhenTheTimeLimitIsRaised) {
  scan("slow", "slow");
  work.before_end = [&](const std::string& name) {
    count_try(name);
    if (tries(name) < 2) pause();
  };
  const auto limit = [](const char* time) {
    return [time](RunOptions& options) { options.sets = {std::string("resources.scan_time_limit=") + time}; };
  };
  EXPECT_EQ(run(limit("1s")), 3) << text;
  EXPECT_EQ(run(limit("1s")), 0) << text;
  EXPECT_EQ(state("slow"), "quarantined");
  EXPECT_EQ(run(limit("500ms")), 2) << "no such unit";
  EXPECT_EQ(run(limit("0.5s")), 0) << text;
  EXPECT_EQ(state("slow"), "quarantined");
  EXPECT_EQ(run(limit("20s")), 0) << text;
  EXPECT_EQ(state("slow"), "done");
}

TEST_F(Workers, AreGivenAnotherTryWhenTheDiskLimitIsRaised) {
  scan("large", "large");
  work.before_end = [&](const std::string& name) {
    count_try(name);
    if (tries(name) > 1) return;
    std::vector<std::vector<char>> held;
    for (;;) held.emplace_back(16u << 20, 'x');  // until memory and file are used up
  };
  const auto disk = [](std::uint64_t bytes) { return [bytes](RunOptions& options) { options.disk = bytes; }; };
  EXPECT_EQ(run(disk(100u << 20)), 3) << text;
  EXPECT_EQ(error("large", "class"), "resource");
  EXPECT_NE(error("large", "text").find("disk: "), std::string::npos) << error("large", "text");
  EXPECT_EQ(run(disk(100u << 20)), 0) << text;
  EXPECT_EQ(state("large"), "quarantined");
  EXPECT_EQ(run(disk(50u << 20)), 0) << text;
  EXPECT_EQ(state("large"), "quarantined");
  EXPECT_EQ(run(disk(200u << 20)), 0) << text;
  EXPECT_EQ(state("large"), "done");
  EXPECT_TRUE(Quarantine::load(root + "/out/quarantine.json").names().empty());
}

TEST(Quarantine, IsLiftedByMoreOfWhatWasMissing) {
  Quarantine quarantine;
  quarantine.add("a", {"print", "text", FailureClass::Resource, {}, 1, 200, 0, 100});
  using Limits = Quarantine::Limits;
  EXPECT_NE(quarantine.find("a", "print", Limits{200, 60, 100}), nullptr);
  EXPECT_NE(quarantine.find("a", "print", Limits{100, 60, 50}), nullptr);
  EXPECT_EQ(quarantine.find("a", "print", Limits{200, 60, 101}), nullptr);
  EXPECT_EQ(quarantine.find("a", "print", Limits{200, 60, 0}), nullptr) << "without a limit";
  EXPECT_EQ(quarantine.find("a", "print", Limits{201, 60, 100}), nullptr);
  EXPECT_EQ(quarantine.find("a", "other", Limits{200, 60, 100}), nullptr);
}

TEST_F(Workers, ThatDieLeaveNothingBehind) {
  scan("deep/a", "a");
  scan("deep/a.b", "b");
  work.before_end = [&](const std::string& name) {
    count_try("a");
    if (name == "deep/a" && tries("a") < 2) raise(SIGKILL);
  };
  EXPECT_EQ(run([](RunOptions& options) { options.only = {"deep/a"}; }), 0) << text;
  EXPECT_EQ(entry("deep/a")->find("attempts")->as_integer(), 2);
  for (const auto& at : std::filesystem::directory_iterator(root + "/out/scans/deep"))
    EXPECT_EQ(at.path().filename().string(), "a");
}

TEST_F(Workers, NameTheirShareOfTheCap) {
  scan("hungry", "hungry");
  EXPECT_EQ(run([](RunOptions& options) { options.memory = 128u << 20; }), 3) << text;
  EXPECT_NE(text.find("memory: 96 MiB, the worker's share of the memory cap of 128 MiB, were used up"),
            std::string::npos)
      << text;
}

TEST_F(Workers, GetMoreMemoryWhenTheyLackIt) {
  for (int i = 0; i < 4; ++i) scan("s" + std::to_string(i), "light");
  scan("t-heavy", "heavy");
  work.before_end = [&](const std::string& name) {
    count_try(name);
    if (name != "t-heavy") return;
    std::vector<std::unique_ptr<char[]>> pieces;  // small ones: large ones would be paged
    while (pieces.size() < (300u << 20) / 512) {
      pieces.push_back(std::make_unique<char[]>(512));
      std::memset(pieces.back().get(), 1, 512);
    }
  };
  EXPECT_EQ(run(), 0) << text;
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_GT(tries("t-heavy"), 1u);
  EXPECT_NE(text.find("tried again with"), std::string::npos) << text;
  EXPECT_NE(text.find(" of memory in place of "), std::string::npos) << text;
  EXPECT_GT(entry("t-heavy")->find("peak_memory_bytes")->as_integer(), 300 << 20);
  // What it needed is remembered.
  scan("t-heavy", "heavy2");
  std::filesystem::remove(root + "/tries-t-heavy");
  EXPECT_EQ(run(), 0) << text;
  EXPECT_EQ(tries("t-heavy"), 1u);
  // With a cap that is too small it fails, is not tried again there, but is with more.
  scan("t-heavy", "heavy3");
  const auto small = [](RunOptions& options) { options.memory = 200u << 20; };
  EXPECT_EQ(run(small), 3) << text;
  EXPECT_EQ(error("t-heavy", "class"), "resource");
  EXPECT_EQ(run(small), 0) << text;
  EXPECT_EQ(state("t-heavy"), "quarantined");
  EXPECT_EQ(run(), 0) << text;
  EXPECT_EQ(state("t-heavy"), "done");
#endif
}

TEST_F(Workers, ThatHadAllOfTheMemoryAreNotPromisedMore) {
  scan("only", "light");
  work.before_end = [&](const std::string& name) {
    count_try(name);
    if (tries(name) < 2) raise(SIGKILL);
  };
  // A cap that its cores do not divide: the share of all of them is a few bytes less.
  EXPECT_EQ(run([](RunOptions& options) { options.memory = (512u << 20) + 1; }), 0) << text;
  EXPECT_NE(text.find("was killed from outside"), std::string::npos) << text;
  EXPECT_NE(text.find("tried again once more"), std::string::npos) << text;
  EXPECT_EQ(text.find("of memory in place of"), std::string::npos) << text;
}

TEST_F(Workers, MakeSmallScansOneAfterTheOther) {
  for (int i = 0; i < 12; ++i) scan("s" + std::to_string(10 + i), "light");
  work.before_end = [&](const std::string& name) {
    count_try(name);
    std::ofstream(root + "/pids", std::ios::app) << getpid() << "\n";
    if (name == "s15" && tries(name) == 1) raise(SIGSEGV);
    if (name == "s18" && tries(name) == 1) raise(SIGKILL);
  };
  EXPECT_EQ(run(), 0) << text;
  for (int i = 0; i < 12; ++i) {
    const std::string name = "s" + std::to_string(10 + i);
    EXPECT_EQ(state(name), "done") << name;
    EXPECT_EQ(tries(name), i == 5 || i == 8 ? 2u : 1u) << name << ": a death costs the scan at work alone";
  }
  std::ifstream file(root + "/pids");
  std::set<std::string> processes;
  std::string line;
  std::size_t lines = 0;
  for (; std::getline(file, line); ++lines) processes.insert(line);
  EXPECT_EQ(lines, 14u);
  EXPECT_LE(processes.size(), 8u) << "two at a time, and new ones after deaths and for what is tried again";
}

TEST_F(Workers, ThatSawAFailureAreReplaced) {
  for (const char* name : {"a", "b", "c", "d"}) scan(name, "bad");
  work.before_end = [&](const std::string&) { std::ofstream(root + "/pids", std::ios::app) << getpid() << "\n"; };
  EXPECT_EQ(run(), 3) << text;
  std::ifstream file(root + "/pids");
  std::set<std::string> processes;
  for (std::string line; std::getline(file, line);) processes.insert(line);
  EXPECT_EQ(processes.size(), 4u);
}

TEST_F(Workers, ThatAreKilledWhileThereIsMemoryCountAsACrash) {
  scan("a", "one");
  scan("c", "three");
  scan("b", "two");
  work.before_end = [&](const std::string& name) {
    count_try(name);
    if (name == "c" || (name == "a" && tries("a") == 1)) raise(SIGKILL);
  };
  EXPECT_EQ(run(), 3) << text;
  EXPECT_EQ(state("a"), "done");
  EXPECT_EQ(tries("a"), 2u);
  EXPECT_EQ(state("b"), "done");
  EXPECT_EQ(tries("c"), 2u) << "once more, as retry.internal says";
  if (memory_signs().available < usable_memory() / 5) GTEST_SKIP() << "this machine is short of memory";
  EXPECT_EQ(error("c", "class"), "internal");
  EXPECT_NE(text.find("was killed from outside (SIGKILL) in stage reduce, and memory was not short"), std::string::npos)
      << text;
  EXPECT_EQ(text.find("ran out of memory"), std::string::npos) << text;
}

TEST(MemorySigns, TellALackOfMemory) {
  constexpr std::uint64_t kGiB = 1ull << 30;
  const MemorySigns before{3, 20 * kGiB};
  EXPECT_FALSE(was_short_of_memory(before, {3, 19 * kGiB}, kGiB, 24 * kGiB));
  EXPECT_TRUE(was_short_of_memory(before, {4, 19 * kGiB}, kGiB, 24 * kGiB)) << "the kernel counted one";
  EXPECT_TRUE(was_short_of_memory(before, {3, 19 * kGiB}, 18 * kGiB, 24 * kGiB)) << "free only since it is gone";
  EXPECT_TRUE(was_short_of_memory(before, {3, 0}, kGiB, 24 * kGiB)) << "not known";
}

TEST_F(Workers, WaitForFilesToSettle) {
  job_text = "scanmill: 1\narchive: archive\nsettle_s: 2\nlattice: {bin_mm: 1}\n";
  scan("a", "old");
  scan("b", "young");
  // Changed half a second before it would have settled.
  const auto began = std::chrono::steady_clock::now();
  const std::int64_t now = now_ns();
  work.changed_ns = [now](const std::string& name) { return name == "b" ? now - 1'500'000'000 : 0; };
  EXPECT_EQ(run(), 0) << text;
  EXPECT_EQ(state("b"), "done");
  EXPECT_NE(text.find("note: waiting 1 s for the files of 1 scan that changed a moment ago (settle_s)"),
            std::string::npos)
      << text;
  EXPECT_GE(std::chrono::steady_clock::now() - began, std::chrono::milliseconds(400));
}

TEST_F(Workers, WatchFilesFromTheFutureInPlaceOfTheirDates) {
  job_text = "scanmill: 1\narchive: archive\nsettle_s: 1\nlattice: {bin_mm: 1}\n";
  scan("a", "one");
  const std::int64_t tomorrow = now_ns() + 86'400'000'000'000;
  work.changed_ns = [tomorrow](const std::string&) { return tomorrow; };
  const auto began = std::chrono::steady_clock::now();
  EXPECT_EQ(run(), 0) << text;
  const auto took = std::chrono::steady_clock::now() - began;
  EXPECT_GE(took, std::chrono::milliseconds(900));
  EXPECT_LT(took, std::chrono::seconds(5)) << "ten waits are for files that change";
  EXPECT_NE(text.find("is dated 23:59:5"), std::string::npos) << text;
}

TEST_F(Workers, LeaveFilesThatKeepChangingForTheNextNight) {
  job_text = "scanmill: 1\narchive: archive\nsettle_s: 1\nlattice: {bin_mm: 1}\n";
  scan("a", "old");
  scan("b", "growing");
  work.changed_ns = [](const std::string& name) { return name == "b" ? now_ns() - 900'000'000 : 0; };
  EXPECT_EQ(run(), 75) << text;
  EXPECT_EQ(state("a"), "done");
  EXPECT_EQ(state("b"), "pending");
  EXPECT_NE(text.find("b: note: put off: its files kept changing"), std::string::npos) << text;
  work.changed_ns = {};
  EXPECT_EQ(run(), 0) << text;
  EXPECT_EQ(state("b"), "done");
}

TEST_F(Workers, LeaveAJournalOfEveryStartAndEnd) {
  for (const char* name : {"a", "b", "c"}) scan(name, name);
  ASSERT_EQ(run(), 0);
  std::size_t starts = 0, ends = 0;
  for (const document::Node& event : load_journal(root + "/out/journal", 1)) {
    starts += event.find("type")->as_string() == "start";
    ends += event.find("type")->as_string() == "end";
  }
  EXPECT_EQ(starts, 3u);
  EXPECT_EQ(ends, 3u);
  EXPECT_EQ(latest_epoch(root + "/out/journal"), 1u);
}

TEST_F(Workers, OfARunThatWasOvertakenPutNothingInPlace) {
  scan("a", "one");
  work.before_end = [&](const std::string&) { spill(root + "/out/journal/99.jsonl", ""); };
  (void)run();
  EXPECT_EQ(state("a"), "interrupted");
  EXPECT_NE(error("a", "text").find("taken over"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(root + "/out/scans/a"));
}

TEST_F(Workers, StartNothingThatWouldNotEndInTime) {
  scan("a", "one");
  std::time_t soon = std::time(nullptr) + 120;
  std::tm parts{};
  localtime_r(&soon, &parts);
  char time_of_day[8];
  std::strftime(time_of_day, sizeof time_of_day, "%H:%M", &parts);
  job_text += "# " + std::string(time_of_day) + "\n";
  EXPECT_EQ(run([&](RunOptions& o) { o.sets = {"resources.until=\"" + std::string(time_of_day) + "\""}; }), 0) << text;
  EXPECT_EQ(state("a"), "done") << "two minutes are enough for what takes no time";
}

TEST_F(Workers, SayThatTheTimeToEndHasJustGoneBy) {
  scan("a", "one");
  const std::time_t now = std::time(nullptr) - 60;
  std::tm parts{};
  localtime_r(&now, &parts);
  char time_of_day[8];
  std::strftime(time_of_day, sizeof time_of_day, "%H:%M", &parts);
  EXPECT_EQ(run([&](RunOptions& o) { o.sets = {"resources.until=\"" + std::string(time_of_day) + "\""}; }), 0) << text;
  EXPECT_NE(text.find("resources.until: this time of day has just gone by"), std::string::npos) << text;
}

TEST_F(Workers, SayWhenTheCapIsMoreThanTheMachineHas) {
  scan("a", "one");
  EXPECT_EQ(run(), 0) << text;
  EXPECT_EQ(text.find("memory cap"), std::string::npos) << text;
  EXPECT_EQ(run([](RunOptions& o) { o.memory = 1ull << 50; }), 0) << text;
  EXPECT_NE(text.find("note: memory cap: found 1024 TiB; this machine"), std::string::npos) << text;
}

TEST_F(Workers, RefuseToFillTheDisk) {
  scan("a", "one");
  EXPECT_EQ(run([](RunOptions& o) { o.sets = {"resources.disk=1"}; }), 1) << text;
  EXPECT_NE(text.find("of the 1 B of disk that resources.disk (--disk) allows the run"), std::string::npos) << text;
  EXPECT_EQ(state("a"), "pending");
  EXPECT_EQ(run(), 0) << text;
}

}  // namespace
}  // namespace scanmill::runner
