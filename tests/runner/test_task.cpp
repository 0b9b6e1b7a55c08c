// SPDX-License-Identifier: Apache-2.0
// One task of a worklist file: what it leaves, and that it may run again, twice at once, or in vain.
#include <sys/wait.h>

#include <csignal>
#include <thread>

#include "fake_work.hpp"
#include "runner/machine.hpp"
#include "runner/task.hpp"
#include "runner/task_result.hpp"
#include "runner/task_signs.hpp"
#include "runner/write_worklist.hpp"

namespace scanmill::runner {
namespace {

class Tasks : public RunnerTest {
 protected:
  void scan(const std::string& name, const std::string& words) { spill(root + "/archive/" + name + ".txt", words); }
  void write(std::int64_t tasks = 1) {
    spill(root + "/job.yaml", "scanmill: 1\narchive: archive\nlattice: {bin_mm: 1}\n" + more);
    WorklistOptions options;
    options.run.job = root + "/job.yaml";
    options.run.out = root + "/out";
    options.run.version = "1";
    options.tasks = tasks;
    ASSERT_EQ(write_worklist(options, work, console), 0);
    path = root + "/out/work/by-hand/tasks.json";
  }
  int task(std::size_t index = 0, const std::string& version = "1") {
    const auto file = load_task_file(path);
    EXPECT_TRUE(file.ok()) << (file ? "" : file.error().text());
    FakeWork fresh;
    fresh.before_end = work.before_end;
    Stop stop;
    return file ? run_task({path, index, version, 0, 0}, *file, fresh, console, stop) : -1;
  }
  std::optional<TaskResult> result(std::size_t index, std::size_t item) const {
    return load_result(result_path(root + "/out/work/by-hand", index, item));
  }
  std::size_t tries(const std::string& name) const { return slurp(root + "/tries-" + name).size(); }
  void count_tries() {
    work.before_end = [this](const std::string& name) { std::ofstream(root + "/tries-" + name, std::ios::app) << "."; };
  }

  FakeWork work;
  std::FILE* sink = std::tmpfile();
  Console console{{ProgressStyle::None, false, false}, sink, sink};
  std::string path, more;
};

TEST_F(Tasks, LeaveAResultARecordAndNothingElse) {
  scan("a", "fine");
  scan("b", "good");
  write(2);
  EXPECT_EQ(task(0), 0);
  EXPECT_EQ(task(1), 0);
  EXPECT_EQ(slurp(root + "/out/scans/a/mesh.stl"), "mesh of fine");
  for (std::size_t index = 0; index < 2; ++index) {
    const auto made = result(index, 0);
    ASSERT_TRUE(made.has_value());
    ASSERT_TRUE(made->ended.attempt.has_value());
    EXPECT_EQ(made->ended.attempt->entry.fate, ScanFate::Done);
    EXPECT_EQ(made->ended.attempt->entry.attempts, 1);
    EXPECT_FALSE(made->host.empty());
  }
  std::vector<std::string> left;
  for (const auto& entry : std::filesystem::directory_iterator(root + "/out/work/by-hand"))
    left.push_back(entry.path().filename().string());
  std::sort(left.begin(), left.end());
  EXPECT_EQ(left, (std::vector<std::string>{"0-0.json", "1-0.json", "tasks.json"}));
}

TEST_F(Tasks, AreNotDoneTwice) {
  scan("a", "fine");
  scan("bad", "bad");
  count_tries();
  write();
  EXPECT_EQ(task(), 3) << "a scan failed for good";
  EXPECT_EQ(task(), 3);
  EXPECT_EQ(tries("a"), 1u);
  EXPECT_EQ(tries("bad"), 1u);
}

TEST_F(Tasks, TryAgainWhatDied) {
  scan("a", "fine");
  work.before_end = [&](const std::string& name) {
    std::ofstream(root + "/tries-" + name, std::ios::app) << ".";
    if (tries(name) == 1) raise(SIGABRT);
  };
  write();
  EXPECT_EQ(task(), 1);
  ASSERT_TRUE(result(0, 0).has_value());
  EXPECT_NE(result(0, 0)->ended.death.find("signal 6"), std::string::npos);
  EXPECT_FALSE(is_final(*result(0, 0)));
  EXPECT_EQ(task(), 0);
  EXPECT_EQ(result(0, 0)->ended.attempt->entry.fate, ScanFate::Done);
}

TEST_F(Tasks, MayRunTwiceAtOnce) {
  for (const char* name : {"a", "b", "c", "d"}) scan(name, "fine");
  work.before_end = [](const std::string&) { std::this_thread::sleep_for(std::chrono::milliseconds(20)); };
  write();
  const pid_t other = fork();
  if (other == 0) _exit(task());
  const int mine = task();
  int status = 0;
  ASSERT_EQ(waitpid(other, &status, 0), other);
  EXPECT_EQ(mine, 0);
  EXPECT_EQ(status, 0);
  for (const char* name : {"a", "b", "c", "d"}) {
    EXPECT_EQ(slurp(root + "/out/scans/" + name + "/mesh.stl"), "mesh of fine");
    EXPECT_TRUE(store::exists(root + "/out/scans/" + name + "/.state.json"));
  }
  for (const auto& entry : std::filesystem::directory_iterator(root + "/out/scans"))
    EXPECT_NE(entry.path().filename().string().front(), '.') << "attempts are put away: " << entry.path();
}

TEST_F(Tasks, PutNothingInPlaceOnceTheyAreTakenBack) {
  scan("a", "fine");
  work.before_end = [&](const std::string&) { spill(root + "/out/work/by-hand/" + kRevokedFile, "\n"); };
  write();
  EXPECT_EQ(task(), 75);
  EXPECT_FALSE(result(0, 0).has_value());
  EXPECT_FALSE(store::exists(root + "/out/scans/a"));
  EXPECT_EQ(task(), 75) << "and nothing is begun";
}

TEST_F(Tasks, StopBetweenScansWhenTheRunDrains) {
  scan("a", "fine");
  scan("b", "fine");
  work.before_end = [&](const std::string&) { spill(root + "/out/work/by-hand/" + kDrainFile, "\n"); };
  write();
  EXPECT_EQ(task(), 75);
  EXPECT_TRUE(result(0, 0).has_value());
  EXPECT_FALSE(result(0, 1).has_value());
}

TEST_F(Tasks, AreRefusedWhenTheyCannotBeThese) {
  scan("a", "fine");
  write();
  EXPECT_EQ(task(7), 2);
  EXPECT_EQ(task(0, "2"), 2) << "another version might make other bytes";
  EXPECT_FALSE(store::exists(root + "/out/scans/a"));
}

TEST_F(Tasks, SayWhenTheScanIsGone) {
  scan("a", "fine");
  scan("b", "fine");
  write();
  std::filesystem::remove(root + "/archive/b.txt");
  EXPECT_EQ(task(), 3);
  EXPECT_NE(result(0, 1)->ended.attempt->entry.error.text().find("no longer holds"), std::string::npos);
}

TEST_F(Tasks, EndWithTheGatesCode) {
  scan("rough", "rough");
  write();
  EXPECT_EQ(task(), 4);
}

TEST_F(Tasks, KeepTheFirstRecordOfTwo) {
  scan("a", "fine");
  write();
  ASSERT_EQ(task(), 0);
  TaskResult late = *result(0, 0);
  late.host = "another";
  const auto saved = save_result(root + "/out/work/by-hand", 0, 0, late);
  ASSERT_TRUE(saved.ok());
  EXPECT_FALSE(*saved);
  EXPECT_NE(result(0, 0)->host, "another");
}

TEST_F(Tasks, AWorklistIsRefusedWhileItsTasksAreAtWork) {
  scan("a", "fine");
  write();
  beat(root + "/out/work/by-hand/" + heartbeat_name(0, "node", 1), {"node", "", 1, 0, "reduce", 0, 0});
  WorklistOptions options;
  options.run.job = root + "/job.yaml";
  options.run.out = root + "/out";
  options.run.version = "1";
  EXPECT_EQ(write_worklist(options, work, console), 75);
}

TEST_F(Tasks, ThatWereKilledHoldNobodyUp) {
  scan("a", "fine");
  write();
  ASSERT_EQ(task(), 0);
  const std::string folder = root + "/out/work/by-hand/";
  beat(folder + heartbeat_name(0, "node", 1), {"node", "", 1, 0, "reduce", 0, 0, "elsewhere", 5});
  EXPECT_TRUE(wait_for_no_task(OutputTree(root + "/out")).ok()) << "its records are there";
  EXPECT_FALSE(store::exists(folder + heartbeat_name(0, "node", 1)));
}

TEST_F(Tasks, OfThisMachineAreNotWaitedForOnceTheirProcessIsGone) {
  scan("a", "fine");
  write();
  const std::string folder = root + "/out/work/by-hand/";
  const OutputTree tree(root + "/out");
  const auto leave_sign = [&](int pid, const std::string& space, std::uint64_t began) {
    const std::string sign = folder + heartbeat_name(0, host_name(), pid);
    beat(sign, {host_name(), "", pid, 0, "reduce", 0, 0, space, began});
    return sign;
  };
  const pid_t child = fork();
  if (child == 0) _exit(0);
  siginfo_t ended;
  ASSERT_EQ(waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOWAIT), 0);
  (void)leave_sign(child, process_space(), 0);
  EXPECT_TRUE(wait_for_no_task(tree).ok()) << "ended, though its parent has not asked";
  ASSERT_EQ(waitpid(child, nullptr, 0), child);

  const std::uint64_t began = look_at_process(getpid())->began;
  (void)leave_sign(getpid(), process_space(), began + 1);
  EXPECT_TRUE(wait_for_no_task(tree).ok()) << "another process has the number now";

  for (const auto& [pid, space] : {std::pair(static_cast<int>(getpid()), process_space()),
                                   std::pair(static_cast<int>(child), std::string("another start of the machine"))}) {
    const std::string sign = leave_sign(pid, space, began);
    const auto rested = wait_for_no_task(tree);
    ASSERT_FALSE(rested.ok());
    EXPECT_EQ(rested.error().code, Code::Cancelled);
    EXPECT_NE(rested.error().message.find("pid " + std::to_string(pid) + " on "), std::string::npos);
    EXPECT_NE(rested.error().message.find("last sign 0 s ago"), std::string::npos) << rested.error().message;
    EXPECT_NE(rested.error().message.find("count as dead from 20"), std::string::npos) << rested.error().message;
    std::filesystem::remove(sign);
  }
}

TEST(TaskFiles, AreRefusedWithThePlaceOfTheMistake) {
  const auto broken = [](const std::string& text) {
    const auto tree = document::parse_json(text, "t");
    EXPECT_TRUE(tree.ok());
    const auto file = task_file_from(*tree, "tasks.json");
    return file ? std::string() : file.error().text();
  };
  EXPECT_NE(broken("{}").find("tasks.json: scanmill_tasks: wanted"), std::string::npos) << broken("{}");
  EXPECT_NE(broken("{\"scanmill_tasks\": 2}").find("wanted 1"), std::string::npos);
  EXPECT_EQ(result_numbers("12-3.json"), (std::pair<std::size_t, std::size_t>(12, 3)));
  for (const char* name : {"12-3.json.whole-x-1", "12.json", "-3.json", "x-3.json", "tasks.json"})
    EXPECT_FALSE(result_numbers(name).has_value()) << name;
  EXPECT_EQ(heartbeat_index("7.node.12.alive"), 7u);
  EXPECT_FALSE(heartbeat_index("7.node.12").has_value());
}

}  // namespace
}  // namespace scanmill::runner
