// SPDX-License-Identifier: Apache-2.0
// What a controller forgets, what waits, what dies, and who goes on.
#include "slurm_runs.hpp"

namespace scanmill::runner {
namespace {

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
    look();
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

}  // namespace
}  // namespace scanmill::runner
