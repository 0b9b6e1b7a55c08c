// SPDX-License-Identifier: Apache-2.0
// The Slurm executor against commands whose replies are scripted. The test plays the nodes: it writes records and signs
// of life where tasks would.
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
namespace {

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

TEST_F(SlurmRuns, EndWithTheRecordWhateverSlurmSays) {
  begin_in_tree(1);
  for (const char* word : {"PENDING", "RUNNING", "FAILED", "NODE_FAIL", "CANCELLED", "OUT_OF_MEMORY", "WHATEVER"}) {
    const std::size_t before = calls("sbatch");
    start(0);
    ASSERT_TRUE(submitted(before + 1)) << word;
    ASSERT_EQ(waves().size(), 1u);
    const WaveFolder wave = waves()[0];
    record(wave, 0, 0, 0);
    queue(row(wave.name, 0, word));
    const auto ended = wait_for(1);
    ASSERT_EQ(ended.size(), 1u) << word;
    ASSERT_TRUE(ended[0].attempt.has_value()) << word;
    EXPECT_EQ(ended[0].attempt->entry.fate, ScanFate::Done);
    EXPECT_EQ(ended[0].seconds, 1.5);
    EXPECT_TRUE(executor->running().empty());
    for (int i = 0; i < 5; ++i) (void)executor->wait(milliseconds(0));
    EXPECT_TRUE(waves().empty()) << "a wave without open scans is put away";
  }
  EXPECT_EQ(notes.find("again"), std::string::npos) << notes;
}

TEST_F(SlurmRuns, KnowEveryWordOfTheStates) {
  begin_in_tree(1);
  for (const JobWord& known : job_words()) {
    {
      const std::string word(known.word);
      EXPECT_EQ(job_word(known.short_word), &known);
      make();
      notes.clear();
      const std::size_t before = calls("sbatch");
      start(0);
      ASSERT_TRUE(submitted(before + 1)) << word;
      const WaveFolder wave = waves()[0];
      life(wave, 0, 0);
      queue(row(wave.name, 0, word, word == "FAILED" ? 7 << 8 : 0));
      switch (known.phase) {
        case JobPhase::Waiting:
        case JobPhase::Running:
          look();
          EXPECT_EQ(executor->running().size(), 1u) << word;
          EXPECT_EQ(calls("sbatch"), before + 1) << word;
          break;
        case JobPhase::Ended:
        case JobPhase::OutOfMemory: {
          const auto ended = wait_for(1);
          ASSERT_EQ(ended.size(), 1u) << word;
          EXPECT_FALSE(ended[0].attempt.has_value()) << word;
          EXPECT_EQ(ended[0].killed_by_system, known.phase == JobPhase::OutOfMemory) << word;
          EXPECT_EQ(ended[0].death.empty(), known.phase == JobPhase::OutOfMemory) << ended[0].death;
          EXPECT_EQ(ended[0].stage, "reduce");
          break;
        }
        case JobPhase::TimeLimit:
        case JobPhase::Lost:
        case JobPhase::Cancelled:
          EXPECT_TRUE(submitted(before + 2)) << word;
          EXPECT_NE(notes.find("submitted again"), std::string::npos) << word << notes;
          break;
      }
      queue("");
    }
  }
}

TEST_F(SlurmRuns, TakeAnUnknownWordForAliveAndWarnOnce) {
  begin_in_tree(1);
  start(0);
  ASSERT_TRUE(submitted(1));
  queue(row(waves()[0].name, 0, "LEVITATING"));
  turn(milliseconds(300));  // longer than the lease
  EXPECT_EQ(executor->running().size(), 1u);
  EXPECT_EQ(calls("sbatch"), 1u);
  EXPECT_NE(notes.find("LEVITATING"), std::string::npos);
  EXPECT_EQ(notes.find("LEVITATING"), notes.rfind("LEVITATING"));
}

TEST_F(SlurmRuns, TakeNothingFromGarbage) {
  begin_in_tree(1);
  start(0);
  ASSERT_TRUE(submitted(1));
  for (const char* garbage : {"echo garbage", "printf '\\000\\377\\n'", "echo '101_0 RUNNING'",
                              "echo 'slurm_load_jobs error: x' >&2; exit 1", "kill -9 $$", "sleep 0.1; exit 1"}) {
    reply("squeue", garbage);
    turn(milliseconds(180));  // longer than the lease
    EXPECT_EQ(executor->running().size(), 1u) << garbage;
    EXPECT_EQ(calls("sbatch"), 1u) << garbage << ": an answer that says nothing is no absence";
  }
  EXPECT_EQ(notes.find("going on by the tasks"), notes.rfind("going on by the tasks")) << notes;
  record(waves()[0], 0, 0, 0);
  EXPECT_EQ(wait_for(1).size(), 1u) << "records count while the controller is down";
}

TEST_F(SlurmRuns, SubmitAgainWhatVanishedWithoutASign) {
  begin_in_tree(1);
  start(0);
  ASSERT_TRUE(submitted(1));
  const WaveFolder wave = waves()[0];
  queue("");
  for (int i = 0; i < 8; ++i) {  // life goes on while Slurm has forgotten the job
    life(wave, 0, 0);
    turn(milliseconds(40));
  }
  EXPECT_EQ(calls("sbatch"), 1u);
  ASSERT_TRUE(submitted(2)) << notes;
  EXPECT_NE(notes.find("vanished without a sign; submitted again"), std::string::npos) << notes;
  EXPECT_NE(slurp(fake + "/sbatch.calls").find(wave.name), std::string::npos);
  EXPECT_EQ(waves().size(), 1u);
  EXPECT_NE(waves()[0].name, wave.name) << "each submission has a name of its own";
}

TEST_F(SlurmRuns, GiveUpOnAScanWhoseNodesKeepDying) {
  keys.resubmits = 1;
  begin_in_tree(1);
  start(0);
  for (std::size_t i = 1; i <= 2; ++i) {
    ASSERT_TRUE(submitted(i));
    queue(row(waves()[0].name, 0, "NODE_FAIL"));
  }
  const auto ended = wait_for(1);
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].attempt->entry.failure, FailureClass::Transient);
  EXPECT_NE(ended[0].attempt->entry.error.text().find("lost 2 times"), std::string::npos);
}

TEST_F(SlurmRuns, SubmitWhatOthersCancelledTwiceMore) {
  begin_in_tree(1);
  start(0);
  for (std::size_t i = 1; i <= 3; ++i) {
    ASSERT_TRUE(submitted(i)) << i;
    queue(row(waves()[0].name, 0, "CANCELLED by 1000"));
  }
  const auto ended = wait_for(1);
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].attempt->entry.failure, FailureClass::Cancelled);
  EXPECT_EQ(calls("sbatch"), 3u);
}

TEST_F(SlurmRuns, LookANameUpBeforeTheySubmitItAgain) {
  begin_in_tree(1);
  // Taken, but the reply was lost.
  reply("sbatch",
        "name=$(expr \"$*\" : '.*--job-name=\\([^ ]*\\)')\n"
        "printf '%-40s%-24s%-12d%-100s%-60s\\n' 77_0 PENDING 0 \"$name\" None >\"$FAKE_SLURM/queue\"\n"
        "echo 'sbatch: error: Batch job submission failed: Socket timed out on send/recv operation' >&2; exit 1");
  start(0);
  turn(milliseconds(100));
  EXPECT_EQ(calls("sbatch"), 1u) << slurp(fake + "/sbatch.calls");
  EXPECT_NE(notes.find("Socket timed out"), std::string::npos);
  record(waves()[0], 0, 0, 0);
  EXPECT_EQ(wait_for(1).size(), 1u);
}

TEST_F(SlurmRuns, SubmitAgainUnderTheSameNameWhenItIsNotThere) {
  begin_in_tree(1);
  reply("sbatch",
        "[ \"$(wc -l <\"$FAKE_SLURM/sbatch.calls\")\" -gt 2 ] && echo '105;cluster' && exit\n"
        "[ \"$(wc -l <\"$FAKE_SLURM/sbatch.calls\")\" -gt 1 ] && echo hello && exit\n"
        "echo 'sbatch: error: Unable to contact slurm controller (connect failure)' >&2; exit 1");
  start(0);
  ASSERT_TRUE(submitted(3));
  turn(milliseconds(50));
  std::string text = slurp(fake + "/sbatch.calls");
  const std::string name = waves()[0].name;
  int found = 0;
  for (auto at = text.find(name); at != std::string::npos; at = text.find(name, at + 1)) ++found;
  EXPECT_EQ(found, 3) << text;
  EXPECT_FALSE(executor->broken().has_value());
}

TEST_F(SlurmRuns, EndWithSlurmsOwnWordsWhenItRefuses) {
  begin_in_tree(2);
  reply("sbatch", "echo 'sbatch: error: invalid partition specified: nowhere' >&2; exit 1");
  start(0);
  start(1);
  (void)executor->wait(milliseconds(0));
  ASSERT_TRUE(executor->broken().has_value());
  EXPECT_NE(executor->broken()->text().find("invalid partition specified: nowhere"), std::string::npos);
  EXPECT_EQ(calls("sbatch"), 1u);
  executor->kill_all();
  EXPECT_EQ(wait_for(2).size(), 2u);
  EXPECT_TRUE(executor->running().empty());
  EXPECT_TRUE(waves().empty());
}

TEST_F(SlurmRuns, EndAtOnceForAnOptionThatSbatchDoesNotKnow) {
  for (const char* words :
       {"sbatch: unrecognized option '--frobnicate'", "sbatch: error: Invalid --mem specification"}) {
    begin_in_tree(1);
    reply("sbatch", std::string("echo \"") + words + "\" >&2; exit 255");
    start(0);
    (void)executor->wait(milliseconds(0));
    ASSERT_TRUE(executor->broken().has_value()) << words;
    EXPECT_NE(executor->broken()->text().find(words), std::string::npos) << executor->broken()->text();
    executor->kill_all();
  }
  EXPECT_EQ(calls("sbatch"), 2u) << "none was tried again";
}

TEST_F(SlurmRuns, TryAgainWhenSbatchIsKilledOrSaysNothingThatHelps) {
  begin_in_tree(1);
  reply("sbatch",
        "case $(wc -l <\"$FAKE_SLURM/sbatch.calls\") in 1) kill -9 $$ ;; 2) exit 137 ;; 3) printf '\\000\\377\\n' ;;\n"
        "4) sleep 0.1; echo 'sbatch: error: Socket timed out' >&2; exit 1 ;; *) echo 110 ;; esac");
  start(0);
  ASSERT_TRUE(submitted(5)) << notes;
  turn(milliseconds(20));
  EXPECT_FALSE(executor->broken().has_value());
  EXPECT_EQ(calls("sbatch"), 5u);
  EXPECT_NE(notes.find("submitted after 4 tries in vain"), std::string::npos) << notes;
  record(waves()[0], 0, 0, 0);
  EXPECT_EQ(wait_for(1).size(), 1u);
}

TEST_F(SlurmRuns, MakeThePausesGrowForAllArraysTogether) {
  keys.chunk = 1;
  keys.poll_s = 0.05;
  begin_in_tree(3);
  reply("sbatch", "echo 'sbatch: error: Unable to contact slurm controller' >&2; exit 1");
  reply("squeue", "echo 'slurm_load_jobs error: Unable to contact slurm controller' >&2; exit 1");
  for (std::size_t i = 0; i < 3; ++i) start(i);
  turn(milliseconds(500));  // 0.05, 0.1, 0.2, 0.4: three arrays alone would have asked twelve times
  EXPECT_EQ(calls("sbatch"), 1u);
  EXPECT_LE(calls("squeue"), 4u);
  EXPECT_GE(calls("squeue"), 2u);
}

TEST_F(SlurmRuns, TakeBackWhatTheControllerForgotToHaveStarted) {
  keys.lease_s = 0.5;
  begin_in_tree(3);
  for (std::size_t i = 0; i < 3; ++i) start(i);
  ASSERT_TRUE(submitted(1));
  const WaveFolder wave = waves()[0];
  queue(row(wave.name, 0, "RUNNING") + row(wave.name, 1, "RUNNING") + row(wave.name, 2, "PENDING"));
  for (const std::size_t e : {0, 1}) begins(wave, e, 102 + e), life(wave, e, 0);
  turn(milliseconds(30));
  reply("squeue", "echo 'Unable to contact slurm controller' >&2; exit 1");
  turn(milliseconds(30));
  record(wave, 0, 0, 0);
  ASSERT_EQ(wait_for(1).size(), 1u);
  // It comes back with what it had saved before anything began, and its numbers begin where they were then.
  queue(row(wave.name, 0, "PENDING") + row(wave.name, 1, "PENDING") + row(wave.name, 2, "PENDING"));
  reply("sbatch", "echo $((100 + $(wc -l <\"$FAKE_SLURM/sbatch.calls\")))");
  no_reply("squeue");
  for (int i = 0; i < 200 && calls("scancel") == 0; ++i) (void)executor->wait(milliseconds(1));
  EXPECT_NE(slurp(fake + "/scancel.calls").find("--name=" + wave.name + " --state=PENDING"), std::string::npos);
  EXPECT_NE(notes.find("Slurm forgot that 2 elements of array 101 began"), std::string::npos) << notes;
  queue(row(wave.name, 0, "CANCELLED") + row(wave.name, 1, "CANCELLED") + row(wave.name, 2, "CANCELLED"));
  for (int i = 0; i < 5; ++i) {  // the second one's task is at it all the while
    life(wave, 1, 0);
    turn(milliseconds(40));
  }
  ASSERT_EQ(calls("sbatch"), 2u) << "only what never began is submitted again";
  ASSERT_EQ(waves().size(), 2u);
  const std::string text = slurp(fake + "/sbatch.calls");
  EXPECT_NE(text.find("--hold"), std::string::npos) << "numbers up to 103 are known to nodes: " << text;
  EXPECT_EQ(told("3 are skipped"), 1u) << notes;
  record(wave, 1, 0, 1);
  const auto ended = wait_for(1);
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].order.scan, 1u);
  EXPECT_EQ(told("submitted again"), 1u) << notes;
}

TEST_F(SlurmRuns, BelieveSlurmThatItPutAnElementBack) {
  begin_in_tree(1);
  start(0);
  ASSERT_TRUE(submitted(1));
  const WaveFolder wave = waves()[0];
  begins(wave, 0, 102);
  life(wave, 0, 0);
  turn(milliseconds(20));
  queue(row(wave.name, 0, "PENDING", 0, "BeginTime", 101, "", 1));
  turn(milliseconds(200));
  EXPECT_EQ(calls("scancel"), 0u) << notes;
  EXPECT_EQ(calls("sbatch"), 1u);
  ASSERT_EQ(executor->running().size(), 1u);
}

TEST_F(SlurmRuns, ChargeNoScanWithAnEndThatMayBeAnothersOne) {
  begin_in_tree(1);
  for (const std::string end : {"COMPLETED", "FAILED", "NODE_FAIL", "CANCELLED"}) {
    make();
    notes.clear();
    const std::size_t before = calls("sbatch");
    start(0);
    ASSERT_TRUE(submitted(before + 1)) << end << notes;
    const WaveFolder wave = waves()[0];
    reply("squeue", "exit 1");
    turn(milliseconds(20));
    queue(row(wave.name, 0, end, end == "FAILED" ? 9 : 0, "None", 101, "n2"));
    no_reply("squeue");
    ASSERT_TRUE(submitted(before + 2)) << end << notes;
    EXPECT_EQ(told("job 101_0 on n2 ended without a record (" + end + ")"), 1u) << notes;
    EXPECT_EQ(told("it counts against nothing"), 1u) << notes;
    queue("");
  }
}

TEST_F(SlurmRuns, TakeTheEndOfWhatNeverBeganForNoCrash) {
  begin_in_tree(1);
  start(0);
  ASSERT_TRUE(submitted(1));
  queue(row(waves()[0].name, 0, "COMPLETED"));  // of another job, which had the same number before
  ASSERT_TRUE(submitted(2)) << notes;
  EXPECT_EQ(told("was lost (COMPLETED)"), 1u) << notes;
}

TEST_F(SlurmRuns, SayWhatTheRestWaitsForOnce) {
  begin_in_tree(4);
  for (std::size_t i = 0; i < 4; ++i) start(i);
  ASSERT_TRUE(submitted(1));
  const WaveFolder wave = waves()[0];
  const char* why = "Nodes_required_for_job_are_DOWN,_DRAINED_or_reserved_for_jobs_in_higher_priority_partitions";
  reply("sinfo", "echo 'drained*|n[1-4]|Duplicate jobid'");
  begins(wave, 0, 102);
  life(wave, 0, 0);
  queue(row(wave.name, 0, "RUNNING", 0, "None", 101, "n2") + row(wave.name, 1, "PENDING", 0, why) +
        row(wave.name, 2, "PENDING", 0, why) + row(wave.name, 3, "PENDING", 0, "Priority"));
  turn(milliseconds(60));
  EXPECT_EQ(executor->waits_for().find("2 Nodes required for job are DOWN, DRAINED, 1 Priority"), 0u)
      << executor->waits_for();
  EXPECT_EQ(told("n[1-4] drained: Duplicate jobid"), 1u) << notes;
  EXPECT_EQ(told("scontrol update nodename=n[1-4] state=resume"), 1u) << notes;
  std::size_t queued = 0;
  for (const Running& one : executor->running()) {
    queued += one.is_queued;
    if (one.order.scan == 0) {
      EXPECT_EQ(one.place, "job 101_0 on n2");
    }
  }
  EXPECT_EQ(queued, 3u);
  int job = 101;
  for (const char* word : {"PENDING", "REQUEUE_HOLD", "SPECIAL_EXIT", "RESV_DEL_HOLD"}) {
    notes.clear();
    queue(row(wave.name, 0, "RUNNING") + row(wave.name, 1, word, 0, "job_requeued_in_held_state", ++job));
    turn(milliseconds(30));
    EXPECT_EQ(told("scontrol release"), 1u) << word << notes;
  }
}

TEST_F(SlurmRuns, SayWhenTasksDoNotComeUpAtAll) {
  begin_in_tree(3);
  for (std::size_t i = 0; i < 3; ++i) start(i);
  ASSERT_TRUE(submitted(1));
  const WaveFolder wave = waves()[0];
  spill(wave.folder + "/0.log", "apptainer: no such image\n");
  queue(row(wave.name, 0, "FAILED", 127 << 8) + row(wave.name, 1, "FAILED", 127 << 8) +
        row(wave.name, 2, "FAILED", 127 << 8));
  for (int i = 0; i < 500 && !executor->broken(); ++i) (void)executor->wait(milliseconds(2));
  ASSERT_TRUE(executor->broken().has_value());
  EXPECT_NE(notes.find("apptainer: no such image"), std::string::npos) << notes;
  EXPECT_NE(executor->broken()->text().find("cluster.wrap"), std::string::npos);
}

TEST_F(SlurmRuns, TakeTheLivingOneOfTwoArraysWithOneName) {
  begin_in_tree(1);
  start(0);
  ASSERT_TRUE(submitted(1));
  const std::string name = waves()[0].name;
  queue(row(name, 0, "CANCELLED", 0, "None", 101) + row(name, 0, "RUNNING", 0, "None", 102));
  turn(milliseconds(180));  // longer than the lease
  queue(row(name, 0, "RUNNING", 0, "None", 102) + row(name, 0, "FAILED", 256, "None", 101));
  turn(milliseconds(180));
  EXPECT_EQ(calls("sbatch"), 1u) << notes;
}

TEST_F(SlurmRuns, BlameOnlyTheScanThatWasAtWork) {
  keys.scans_per_element = 3;
  begin_in_tree(3);
  for (std::size_t i = 0; i < 3; ++i) start(i);
  ASSERT_TRUE(submitted(1));
  const WaveFolder wave = waves()[0];
  record(wave, 0, 0, 0);
  life(wave, 0, 1);
  ASSERT_EQ(wait_for(1).size(), 1u);
  queue(row(wave.name, 0, "OUT_OF_MEMORY", 0, "OutOfMemory"));
  const auto ended = wait_for(1);
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].order.scan, 1u);
  EXPECT_TRUE(ended[0].killed_by_system);
  ASSERT_TRUE(submitted(2)) << "the third was not reached";
  ASSERT_EQ(executor->running().size(), 1u);
  EXPECT_EQ(executor->running()[0].order.scan, 2u);
}

TEST_F(SlurmRuns, TakeAKillForALackOfMemory) {
  begin_in_tree(1);
  start(0);
  ASSERT_TRUE(submitted(1));
  life(waves()[0], 0, 0);
  queue(row(waves()[0].name, 0, "FAILED", 9, "JobLaunchFailure"));
  const auto ended = wait_for(1);
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_TRUE(ended[0].killed_by_system);
  EXPECT_EQ(ended[0].order.memory, 128u << 20) << "what it was given, so that twice as much is more";
}

TEST_F(SlurmRuns, GiveMoreTimeUpToTheLimitOfAScan) {
  begin_in_tree(1);
  start(0);
  std::vector<std::string> times;
  for (std::size_t i = 1; i <= 5; ++i) {  // 300, 600, 1200, 2400, 3600 s, and a minute for the start
    ASSERT_TRUE(submitted(i)) << i << notes;
    life(waves()[0], 0, 0);
    queue(row(waves()[0].name, 0, "TIMEOUT", 15));
  }
  const auto ended = wait_for(1);
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_TRUE(ended[0].over_time);
  const std::string text = slurp(fake + "/sbatch.calls");
  for (const char* time : {"--time=6 ", "--time=11 ", "--time=21 ", "--time=41 ", "--time=61 "})
    EXPECT_NE(text.find(time), std::string::npos) << time << text;
}

TEST_F(SlurmRuns, KeepToAnElementTimeThatTheJobSets) {
  keys.time_s = 60;
  begin_in_tree(1);
  start(0);
  ASSERT_TRUE(submitted(1));
  EXPECT_NE(slurp(fake + "/sbatch.calls").find("--time=1 "), std::string::npos);
  life(waves()[0], 0, 0);
  queue(row(waves()[0].name, 0, "TIMEOUT", 15));
  const auto ended = wait_for(1);
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].attempt->entry.failure, FailureClass::Internal);
  EXPECT_NE(ended[0].attempt->entry.error.text().find("cluster.time"), std::string::npos);
}

TEST_F(SlurmRuns, AreTakenOverByTheNextDriver) {
  begin_in_tree(2);
  start(0);
  start(1);
  ASSERT_TRUE(submitted(1));
  const WaveFolder wave = waves()[0];
  queue(row(wave.name, 0, "RUNNING") + row(wave.name, 1, "PENDING"));
  // The driver dies: what it leaves is the wave's folder.
  std::filesystem::copy(wave.folder, root + "/kept", std::filesystem::copy_options::recursive);
  executor.reset();
  ASSERT_EQ(calls("scancel"), 1u) << "a driver that ends in peace takes its work back";
  std::filesystem::create_directories(root + "/out/work");
  std::filesystem::rename(root + "/kept", wave.folder);
  record(wave, 1, 0, 1);

  make();
  start(0);
  start(1);
  const auto first = wait_for(1);
  ASSERT_EQ(first.size(), 1u);
  EXPECT_EQ(first[0].order.scan, 1u);
  record(wave, 0, 0, 0);
  EXPECT_EQ(wait_for(1).size(), 1u);
  EXPECT_EQ(calls("sbatch"), 1u) << "nothing is done twice";
  EXPECT_NE(notes.find("taking over 2 elements of 1 array"), std::string::npos) << notes;
}

TEST_F(SlurmRuns, DoNotTakeOverWhatWasMadeWithOtherKeys) {
  begin_in_tree(1);
  start(0);
  ASSERT_TRUE(submitted(1));
  const WaveFolder wave = waves()[0];
  std::filesystem::copy(wave.folder, root + "/kept", std::filesystem::copy_options::recursive);
  executor.reset();
  std::filesystem::create_directories(root + "/out/work");
  std::filesystem::rename(root + "/kept", wave.folder);
  begin(1, 2);  // other bins
  start(0);
  ASSERT_TRUE(submitted(2));
  EXPECT_FALSE(store::exists(wave.worklist()));
}

TEST_F(SlurmRuns, DrainAndStopOnRequest) {
  begin_in_tree(3);
  for (std::size_t i = 0; i < 3; ++i) start(i);
  ASSERT_TRUE(submitted(1));
  const WaveFolder wave = waves()[0];
  life(wave, 0, 0);
  queue(row(wave.name, 0, "RUNNING") + row(wave.name, 1, "PENDING") + row(wave.name, 2, "PENDING"));
  turn(milliseconds(60));
  executor->drain();
  EXPECT_TRUE(store::exists(wave.folder + "/" + kDrainFile));
  EXPECT_NE(slurp(fake + "/scancel.calls").find("--state=PENDING"), std::string::npos);
  std::string rest = row(wave.name, 0, "CANCELLED");
  rest.replace(0, 40, "101" + std::string(37, ' '));  // squeue shows what never began in one row
  queue(row(wave.name, 0, "RUNNING") + rest);
  for (const Ended& one : wait_for(2)) {
    EXPECT_EQ(one.attempt->entry.fate, ScanFate::Pending);
    EXPECT_NE(one.order.scan, 0u);
  }
  EXPECT_EQ(executor->running().size(), 1u) << "what is at work comes to its end";
  executor->stop_all();
  queue(row(wave.name, 0, "CANCELLED"));
  EXPECT_EQ(wait_for(1).size(), 1u);
  EXPECT_EQ(calls("sbatch"), 1u);
}

TEST_F(SlurmRuns, CutArraysToWhatTheClusterTakes) {
  keys.chunk = 4;
  begin_in_tree(10);
  for (std::size_t i = 0; i < 10; ++i) start(i);
  ASSERT_TRUE(submitted(3));
  EXPECT_EQ(waves().size(), 3u);
  const std::string text = slurp(fake + "/sbatch.calls");
  EXPECT_NE(text.find("--array=0-3"), std::string::npos);
  EXPECT_NE(text.find("--array=0-1"), std::string::npos);
  EXPECT_NE(text.find("--no-requeue"), std::string::npos);
  EXPECT_NE(text.find("--mem=224M"), std::string::npos) << text;
}

TEST(SlurmAnswers, AreReadInWholeOrNotAtAll) {
  const auto rows =
      queue_rows("12_3                                    RUNNING                 0           scanmill-a-b" +
                 std::string(88, ' ') + "Resources\n\n");
  ASSERT_TRUE(rows.has_value());
  ASSERT_EQ(rows->size(), 1u);
  EXPECT_EQ((*rows)[0].job, "12");
  EXPECT_EQ((*rows)[0].index, 3u);
  EXPECT_EQ((*rows)[0].reason, "Resources");
  EXPECT_FALSE((*rows)[0].is_rest);
  for (const std::string element : {"12", "12_[4-9%2]"}) {  // as squeue shows what never began
    const auto rest = queue_rows(element + std::string(40 - element.size(), ' ') +
                                 "CANCELLED               0           scanmill-a-b" + std::string(88, ' ') + "None\n");
    ASSERT_TRUE(rest.has_value()) << element;
    EXPECT_TRUE((*rest)[0].is_rest);
    EXPECT_EQ((*rest)[0].job, "12");
  }
  const auto full = queue_rows(
      "12_3                                    PENDING                 0           scanmill-a-b" +
      std::string(88, ' ') + "Resources" + std::string(91, ' ') + "n[1-2]" + std::string(54, ' ') + "2       \n");
  ASSERT_TRUE(full.has_value());
  EXPECT_EQ((*full)[0].reason, "Resources");
  EXPECT_EQ((*full)[0].node, "n[1-2]");
  EXPECT_EQ((*full)[0].restarts, 2);
  EXPECT_EQ((*rows)[0].restarts, -1) << "not told";
  EXPECT_FALSE(queue_rows("12 RUNNING").has_value());
  EXPECT_TRUE(queue_rows("").has_value());
}

TEST(SlurmComplaints, PassOrDoNot) {
  EXPECT_TRUE(
      is_passing("sbatch: error: Batch job submission failed: Unable to contact slurm controller (connect failure)"));
  EXPECT_TRUE(is_passing("Job violates accounting/QOS policy (job submit limit, user's size and/or time limits)"));
  EXPECT_FALSE(is_passing("Batch job submission failed: Invalid account or account/partition combination specified"));
  EXPECT_FALSE(is_passing("invalid partition specified: nowhere"));
}

TEST(PackTasks, FillsTheLeastFirstAndIsFair) {
  std::vector<ScanLoad> loads;
  for (std::size_t i = 0; i < 10; ++i) loads.push_back({i, static_cast<double>(10 * (i + 1))});
  const auto tasks = pack_tasks(loads, {100, 2, 0});  // 550 s in all
  ASSERT_EQ(tasks.size(), 6u);
  EXPECT_EQ(tasks[0].front(), 9u);
  std::size_t all = 0;
  for (const auto& task : tasks) all += task.size();
  EXPECT_EQ(all, 10u);
  EXPECT_EQ(pack_tasks(loads, {100000, 4, 0}).size(), 4u) << "all nodes get some";
  EXPECT_EQ(pack_tasks(loads, {1, 100, 0}).size(), 10u) << "no task without a scan";
  for (const auto& task : pack_tasks(loads, {1, 1, 3})) EXPECT_LE(task.size(), 3u);
  EXPECT_TRUE(pack_tasks({}, {}).empty());
}

TEST(MemoryClass, IsNoLessThanAskedAndFew) {
  EXPECT_EQ(memory_class(1, 0), 128u << 20);
  EXPECT_EQ(memory_class(129u << 20, 0), 192u << 20);
  EXPECT_EQ(memory_class(200u << 20, 0), 256u << 20);
  EXPECT_EQ(memory_class(200u << 20, 210u << 20), 210u << 20);
}

}  // namespace
}  // namespace scanmill::runner
