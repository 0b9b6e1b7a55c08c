// SPDX-License-Identifier: Apache-2.0
// Runs on a Slurm whose answers a script gives.
#pragma once
#include <algorithm>
#include <cstdio>
#include <thread>

#include "base/text.hpp"
#include "fake_work.hpp"
#include "runner/pack_tasks.hpp"
#include "runner/slurm_client.hpp"
#include "runner/slurm_executor.hpp"
#include "runner/slurm_states.hpp"
#include "runner/slurm_waves.hpp"
#include "runner/task.hpp"
#include "runner/task_result.hpp"

namespace scanmill::runner {

using std::chrono::milliseconds;

class SlurmRuns : public RunnerTest {
 protected:
  void SetUp() override {
    RunnerTest::SetUp();
    fake = root + "/fake";
    std::filesystem::create_directories(fake);
    setenv("FAKE_SLURM", fake.c_str(), 1);
    path_before = getenv("PATH");
    setenv("PATH", (std::string(FAKE_SLURM_COMMANDS) + ":" + path_before).c_str(), 1);
    keys.poll_s = 0.01;
    keys.lease_s = 0.15;
    keys.scans_per_element = 1;
  }
  void TearDown() override {
    executor.reset();
    setenv("PATH", path_before.c_str(), 1);
    RunnerTest::TearDown();
  }

  void begin(std::size_t scans, double bin = 1) {
    for (std::size_t i = 0; i < scans; ++i) spill(root + "/archive/s" + std::to_string(i) + ".txt", "fine");
    job_text = "scanmill: 1\narchive: archive\nlattice: {bin_mm: " + number_text(bin) + "}\n";
    spill(root + "/job.yaml", job_text);
    auto job = load_job(root + "/job.yaml", {}, work);
    ASSERT_TRUE(job.ok()) << job.error().text();
    auto found = select_scans(*job, {}, work);
    ASSERT_TRUE(found.ok()) << found.error().text();
    selection = *std::move(found);
    ASSERT_TRUE(tree().prepare().ok());
    entries.resize(scans);
    for (std::size_t i = 0; i < scans; ++i) entries[i].name = selection.scans[i].task.name;
    make();
  }
  void make() {
    TaskFile frame;
    frame.version = "1";
    frame.out = root + "/out";
    frame.job_path = frame.job_shown = root + "/job.yaml";
    frame.job_text = job_text;
    frame.time_limit_s = 3600;
    frame.lease_s = keys.lease_s;
    executor.reset();
    executor = make_slurm_executor(
        {keys, output, selection, stop, frame, 0, 8ull << 30, [](std::size_t) { return std::uint64_t{1000}; },
         [this](std::size_t scan) -> const ScanEntry& { return entries[scan]; },
         [this](const std::string& scan, const std::string& text) { notes += scan + ": " + text + "\n"; }});
  }
  OutputTree& tree() { return output; }
  void start(std::size_t scan) { ASSERT_TRUE(executor->start({scan, 1, 100 << 20}).ok()); }

  /// Waits, at most for so long, until `count` scans have ended.
  std::vector<Ended> wait_for(std::size_t count, milliseconds limit = milliseconds(3000)) {
    std::vector<Ended> all;
    const auto until = std::chrono::steady_clock::now() + limit;
    while (all.size() < count && std::chrono::steady_clock::now() < until)
      for (Ended& one : executor->wait(milliseconds(2))) all.push_back(std::move(one));
    return all;
  }
  void turn(milliseconds time) { EXPECT_TRUE(wait_for(1, time).empty()); }
  /// Of sbatch only those of arrays: jobs that take a number are no work.
  std::size_t calls(const std::string& command) const {
    std::size_t count = 0;
    for (const std::string& line : lines_of(slurp(fake + "/" + command + ".calls")))
      count += !line.empty() && (command != "sbatch" || line.find("--array=") != std::string::npos);
    return count;
  }
  /// Turns until sbatch was called so often.
  bool submitted(std::size_t count) {
    for (int i = 0; i < 1000 && calls("sbatch") < count; ++i) (void)executor->wait(milliseconds(2));
    return calls("sbatch") == count;
  }
  /// Turns until Slurm was asked twice more, and its second answer heard.
  void look() {
    const std::size_t before = calls("squeue");
    for (int i = 0; i < 1000 && calls("squeue") < before + 2; ++i) EXPECT_TRUE(executor->wait(milliseconds(2)).empty());
    EXPECT_GE(calls("squeue"), before + 2);
  }
  std::vector<WaveFolder> waves() { return open_waves(tree()); }

  static std::string row(const std::string& name, std::size_t index, const std::string& state, int status = 0,
                         const std::string& reason = "None", int job = 101, const std::string& node = "",
                         int restarts = 0) {
    char text[500];
    std::snprintf(text, sizeof text, "%-40s%-24s%-12d%-100s%-100s%-60s%-8d\n",
                  (std::to_string(job) + "_" + std::to_string(index)).c_str(), state.c_str(), status, name.c_str(),
                  reason.c_str(), node.c_str(), restarts);
    return text;
  }
  void queue(const std::string& text) {
    spill(fake + "/queue.new", text), std::rename((fake + "/queue.new").c_str(), (fake + "/queue").c_str());
  }
  void reply(const std::string& command, const std::string& script) { spill(fake + "/" + command + ".reply", script); }
  void no_reply(const std::string& command) { std::filesystem::remove(fake + "/" + command + ".reply"); }

  void record(const WaveFolder& wave, std::size_t index, std::size_t item, std::size_t scan,
              ScanFate fate = ScanFate::Done) {
    TaskResult result;
    result.scan = selection.scans[scan].task.name;
    Attempt attempt{entries[scan], "f", false, ""};
    attempt.entry.fate = fate;
    attempt.entry.attempts = 1;
    attempt.entry.counts = document::Node::map();
    result.ended.attempt = attempt;
    result.ended.seconds = 1.5;
    ASSERT_TRUE(save_result(wave.folder, index, item, result).ok());
  }
  void life(const WaveFolder& wave, std::size_t index, std::size_t item) {
    beat(wave.folder + "/" + heartbeat_name(index, "node", 7), {"node", "slurm 1", 7, item, "reduce", 1, 2});
  }

  /// The script's mark of an element that runs under this number.
  void begins(const WaveFolder& wave, std::size_t index, std::uint64_t number) {
    spill(wave.folder + "/" + began_name(std::to_string(index), std::to_string(number)), "");
  }
  std::size_t told(const std::string& text) const {
    std::size_t count = 0;
    for (auto at = notes.find(text); at != std::string::npos; at = notes.find(text, at + 1)) ++count;
    return count;
  }

  FakeWork work;
  ClusterKeys keys;
  Selection selection;
  Stop stop;
  std::vector<ScanEntry> entries;
  OutputTree output{""};
  std::unique_ptr<Executor> executor;
  std::string fake, path_before, notes, job_text;

  SlurmRuns() { output = OutputTree(testing::TempDir() + "unset"); }
  void begin_in_tree(std::size_t scans) {
    output = OutputTree(root + "/out");
    begin(scans);
  }
};

}  // namespace scanmill::runner
