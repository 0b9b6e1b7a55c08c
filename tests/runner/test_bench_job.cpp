// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>

#include "fake_work.hpp"
#include "runner/bench_job.hpp"

namespace scanmill::runner {
namespace {

class BenchJob : public RunnerTest {
 protected:
  void SetUp() override {
    RunnerTest::SetUp();
    std::filesystem::create_directories(root + "/tmp");
    setenv("TMPDIR", (root + "/tmp").c_str(), 1);
    spill(root + "/archive/a.txt", "one");
    spill(root + "/archive/b.txt", "rough");  // a failed gate is no reason not to time it
    spill(root + "/job.yaml",
          "scanmill: 1\narchive: archive\nexecutor: inline\nlattice: {bin_mm: 1}\nnotify: [{run: touch told}]\n");
  }
  void TearDown() override {
    unsetenv("TMPDIR");
    RunnerTest::TearDown();
  }
  struct Seen {
    int code = -1;
    std::string text;
  };
  Seen bench(const std::string& against = "", const std::string& out = "") {
    BenchJobOptions options;
    options.job = root + "/job.yaml";
    options.against = against;
    options.out = out;
    options.repeats = repeats;
    options.threads = threads;
    options.version = "0.1.0";
    options.work = [this] {
      auto work = std::make_unique<FakeWork>();
      work->before_end = [this](const std::string&) { ++runs; };
      return work;
    };
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), std::fclose);
    Console console({ProgressStyle::None, false, false}, file.get(), file.get());
    Seen seen;
    runs = 0;
    seen.code = bench_job(options, console, stop);
    std::rewind(file.get());
    char buffer[65536];
    seen.text.assign(buffer, std::fread(buffer, 1, sizeof buffer, file.get()));
    return seen;
  }
  /// The document at `path` with every cost changed by a factor.
  void doctor(const std::string& path, double factor) {
    auto bench = job_bench_from(*document::parse_json(slurp(path), path), path);
    ASSERT_TRUE(bench.ok());
    for (JobTiming& run : bench->runs)
      for (double* cost : {&run.yardsticks.median, &run.yardsticks.least}) *cost *= factor;
    spill(path, document::to_json(to_document(*bench)));
  }
  int runs = 0, repeats = 2, threads = 2;
  Stop stop;
};

TEST_F(BenchJob, RepeatsTheJobAtEveryNumberOfThreadsAndLeavesNothing) {
  const Seen seen = bench("", root + "/bench.json");
  EXPECT_EQ(seen.code, 0) << seen.text;
  EXPECT_EQ(runs, 2 * (1 + 2 * 2));  // scans of one run to warm up, then two repeats at one and at two threads
  EXPECT_NE(seen.text.find("2 scans"), std::string::npos) << seen.text;
  EXPECT_NE(seen.text.find("scans/h"), std::string::npos) << seen.text;
  EXPECT_TRUE(std::filesystem::is_empty(root + "/tmp"));
  EXPECT_FALSE(store::exists(root + "/told"));
  const auto bench = job_bench_from(*document::parse_json(slurp(root + "/bench.json"), "b"), "b");
  ASSERT_TRUE(bench.ok()) << bench.error().text();
  ASSERT_EQ(bench->runs.size(), 2u);
  EXPECT_EQ(bench->runs[1].threads, 2);
  EXPECT_GT(bench->runs[0].yardsticks.least, 0);
  EXPECT_GT(bench->yardstick_s.least, 0.01);
  EXPECT_LT(bench->yardstick_s.least, 1);
}

TEST_F(BenchJob, EndsWithFourOnASlowdownThatStays) {
  repeats = threads = 1;
  ASSERT_EQ(bench("", root + "/bench.json").code, 0);
  doctor(root + "/bench.json", 0.01);  // it was a hundred times faster then
  const Seen seen = bench(root + "/bench.json");
  EXPECT_EQ(seen.code, 4) << seen.text;
  EXPECT_EQ(runs, 2 * (1 + 5));  // four more rounds
  EXPECT_NE(seen.text.find("with 1 thread: found "), std::string::npos) << seen.text;
  EXPECT_NE(seen.text.find("confirmed by 4 more rounds"), std::string::npos) << seen.text;
  doctor(root + "/bench.json", 1e6);
  EXPECT_EQ(bench(root + "/bench.json").code, 0);
  EXPECT_EQ(runs, 2 * (1 + 1));
}

TEST_F(BenchJob, RefusesWhatCannotBeCompared) {
  repeats = threads = 1;
  ASSERT_EQ(bench("", root + "/bench.json").code, 0);
  spill(root + "/archive/c.txt", "three");
  Seen seen = bench(root + "/bench.json");
  EXPECT_EQ(seen.code, 2);
  EXPECT_NE(seen.text.find("was measured on 2 scans"), std::string::npos) << seen.text;
  EXPECT_EQ(runs, 3);
  spill(root + "/other.json", "{\"scanmill_bench\": 1}");
  seen = bench(root + "/other.json");
  EXPECT_EQ(seen.code, 2);
  EXPECT_NE(seen.text.find("scanmill bench JOB --out"), std::string::npos) << seen.text;
}

TEST_F(BenchJob, NeedsAJobWhoseScansAreAllMade) {
  spill(root + "/archive/a.txt", "bad");
  const Seen seen = bench();
  EXPECT_EQ(seen.code, 3);
  EXPECT_NE(seen.text.find("found 'bad'; wanted numbers"), std::string::npos) << seen.text;
  EXPECT_TRUE(std::filesystem::is_empty(root + "/tmp"));
  stop.signal.store(15);
  stop.flag.set();
  EXPECT_EQ(bench().code, 143);
}

TEST(IsSlower, ComparesMediansInYardsticks) {
  JobTiming then, now;
  then.yardsticks = {10, 9, 20};
  now.yardsticks = {12.5, 10.5, 13};
  EXPECT_TRUE(is_slower(now, then));
  now.yardsticks = {12.5, 9.2, 13};  // some repeats were as fast as before: a busy machine
  EXPECT_FALSE(is_slower(now, then));
  now.yardsticks = {11, 10.9, 30};
  now.cpu_s = {9, 9, 9};  // seconds alone may come from the machine
  EXPECT_FALSE(is_slower(now, then));
}

TEST(ThreadCounts, GoUpToTheGreatest) {
  EXPECT_EQ(thread_counts(1), (std::vector<int>{1}));
  EXPECT_EQ(thread_counts(2), (std::vector<int>{1, 2}));
  EXPECT_EQ(thread_counts(4), (std::vector<int>{1, 2, 3, 4}));
  EXPECT_EQ(thread_counts(6), (std::vector<int>{1, 2, 3, 4, 6}));
  EXPECT_EQ(thread_counts(64), (std::vector<int>{1, 2, 3, 4, 8, 16, 32, 64}));
}

}  // namespace
}  // namespace scanmill::runner
