// SPDX-License-Identifier: Apache-2.0
#include "slurm_runs.hpp"

namespace scanmill::runner {
namespace {

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
