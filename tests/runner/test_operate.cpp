// SPDX-License-Identifier: Apache-2.0
// What `scanmill status` says of a run that goes on.
#include <sys/wait.h>

#include <csignal>

#include "fake_work.hpp"
#include "runner/console.hpp"
#include "runner/machine.hpp"
#include "runner/operate.hpp"
#include "runner/output_tree.hpp"
#include "runner/run_view.hpp"
#include "runner/worklist.hpp"

namespace scanmill::runner {
namespace {

class Status : public RunnerTest {
 protected:
  /// live.json of a run by this process with one scan at work.
  void live(const std::string& heartbeat, int worker, double silent_s, bool stopping, int driver = getpid()) {
    const OutputTree tree(root + "/out");
    ASSERT_TRUE(tree.prepare().ok());
    spill(tree.live_file(), "{\"scanmill_live\":1,\"host\":\"" + host_name() + "\",\"pid\":" + std::to_string(driver) +
                                ",\"job\":\"job.yaml\",\"heartbeat\":\"" + heartbeat +
                                "\",\"seconds\":3,\"stopping\":" + (stopping ? "true" : "false") +
                                ",\"counts\":{\"done\":1},\"running\":[{\"scan\":\"a\",\"stage\":\"grow\"," +
                                "\"seconds\":2,\"silent_s\":" + std::to_string(silent_s) +
                                ",\"pid\":" + std::to_string(worker) + ",\"threads\":1}]}");
  }
  std::string status() const {
    return said_by([&](Console& console) { return show_status(root + "/out", console); });
  }
  static std::string said_by(const std::function<int(Console&)>& command) {
    std::FILE* out = std::tmpfile();
    {
      Console console({ProgressStyle::None, false, false}, out, out);
      EXPECT_EQ(command(console), 0);
    }
    std::string text(static_cast<std::size_t>(std::ftell(out)), '\0');
    std::rewind(out);
    text.resize(std::fread(text.data(), 1, text.size(), out));
    std::fclose(out);
    return text;
  }
};

TEST_F(Status, IsPlainOfARunThatGoesOn) {
  live(utc_now(), getpid(), 0.5, false);
  const std::string text = status();
  EXPECT_TRUE(text.starts_with("running for 00:00:0")) << text;
  EXPECT_EQ(text.find("no sign"), std::string::npos) << text;
  EXPECT_EQ(text.find("stopp"), std::string::npos) << text;
}

TEST_F(Status, TellsOfSilence) {
  live("2026-01-31T08:15:00Z", getpid(), 0.5, false);
  std::string text = status();
  EXPECT_NE(text.find("job job.yaml, no sign for "), std::string::npos) << text;
  EXPECT_EQ(text.find("running for 00:00:0"), std::string::npos) << "it runs since longer than it wrote: " << text;
  live(utc_now(), getpid(), 20.4, false);
  text = status();
  EXPECT_EQ(text.find("job job.yaml, no sign for "), std::string::npos) << text;
  EXPECT_NE(text.find("1 thread, no sign for 2"), std::string::npos) << text;
}

TEST_F(Status, TellsOfARunThatIsStopping) {
  live(utc_now(), getpid(), 0.5, true);
  EXPECT_TRUE(status().starts_with("stopping, running for ")) << status();
}

TEST_F(Status, TakesADriverThatNobodyWaitedForForDead) {
  const pid_t child = fork();
  if (child == 0) _exit(0);
  siginfo_t info{};
  ASSERT_EQ(waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOWAIT), 0);
  ASSERT_EQ(kill(child, 0), 0) << "its number is still taken";
  live(utc_now(), 0, 0.5, false, child);
  EXPECT_TRUE(status().starts_with("the run was killed, last sign ")) << status();
  const std::string text = said_by([&](Console& console) { return cancel_run(root + "/out", console); });
  EXPECT_NE(text.find("no run to stop"), std::string::npos) << text;
  EXPECT_FALSE(std::filesystem::exists(OutputTree(root + "/out").cancel_file())) << "there is nobody to read it";
  waitpid(child, nullptr, 0);
}

/// An output whose run was killed: parts of scans of every fate.
class Garbage : public Status {
 protected:
  void SetUp() override {
    Status::SetUp();
    ASSERT_TRUE(tree().prepare().ok());
    for (const char* scan : {"at/work", "not-yet", "made", "gone", "lost"})
      spill(tree().parts(scan) + "/map-0.part", std::string(1024, 'p'));
    spill(tree().names_file(), R"({"scanmill_names":1,"scans":["at/work","made","not-yet"]})");
    spill(tree().run_file(), R"({"scans":[{"name":"at/work","state":"pending"},{"name":"made","state":"done"},)"
                             R"({"name":"gone","state":"vanished"}]})");
  }
  OutputTree tree() const { return OutputTree(root + "/out"); }
  bool has_parts(const std::string& scan) const { return std::filesystem::exists(tree().parts(scan)); }
  std::string collect(bool dry_run) const {
    return said_by([&](Console& console) { return collect_garbage(root + "/out", dry_run, console); });
  }
};

TEST_F(Garbage, LeavesThePartsOfScansThatAreToBeMade) {
  const std::string dry = collect(true);
  EXPECT_NE(dry.find("2 KiB of parts of 2 scans to be made"), std::string::npos) << dry;
  EXPECT_TRUE(has_parts("made")) << dry;
  const std::string text = collect(false);
  EXPECT_NE(text.find("2 KiB of parts of 2 scans to be made"), std::string::npos) << text;
  EXPECT_TRUE(has_parts("at/work") && has_parts("not-yet")) << text;
  EXPECT_FALSE(has_parts("made") || has_parts("gone") || has_parts("lost")) << text;
  EXPECT_NE(collect(false).find("nothing to remove"), std::string::npos);
}

TEST_F(Garbage, IsNoneForStatusWhereTheNextRunGoesOn) {
  const std::string text = status();
  EXPECT_NE(text.find("\npartly made: at/work (1 part, 1 KiB), not-yet (1 part, 1 KiB); the next run goes on"),
            std::string::npos)
      << text;
}

TEST_F(Garbage, TakesAllPartsWhenNoScanWantsThem) {
  spill(tree().run_file(), R"({"scans":[{"name":"at/work","state":"done"},{"name":"made","state":"done"},)"
                           R"({"name":"not-yet","state":"unchanged"}]})");
  EXPECT_EQ(collect(false).find("to be made"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(tree().parts()));
}

TEST_F(Status, TellsOfAProcessThatWasStopped) {
  const pid_t child = fork();
  if (child == 0) {
    raise(SIGSTOP);
    _exit(0);
  }
  int how = 0;
  ASSERT_EQ(waitpid(child, &how, WUNTRACED), child);
  live(utc_now(), child, 0.5, false);
  EXPECT_NE(status().find("its process is stopped (kill -CONT"), std::string::npos) << status();
  kill(child, SIGKILL);
  waitpid(child, &how, 0);
}

TEST(Waiting, CountsScansNotParts) {
  Worklist list;
  for (const char* part : {"map 0", "map 1", "map 2"}) {
    WorkItem item;
    item.part = part;
    list.add(item);
  }
  for (std::size_t scan : {1, 2}) {
    WorkItem item;
    item.scan = scan;
    list.add(item);
  }
  EXPECT_EQ(list.scans_beside({}), 3u);
  EXPECT_EQ(list.scans_beside({0}), 2u);
}

TEST(RunLine, CountsThePartsOfACutScan) {
  const RunReport report;
  const std::vector<std::string> names{"bun"};
  std::vector<Running> running(1);
  running[0].order.part = "frame 3";
  running[0].stage = "pick";
  running[0].began = std::chrono::steady_clock::now();
  RunPicture picture{report, running, names, 2, 500, 1000, {}, 70};
  EXPECT_EQ(line_of(picture).find("part"), std::string::npos);
  const std::map<std::size_t, PartCount> parts{{0, {19, 36, 1000}}};
  picture.parts = &parts;
  EXPECT_NE(line_of(picture).find("(bun frame 3 pick 0:00, 19 of 36 parts done)"), std::string::npos)
      << line_of(picture);
  EXPECT_NE(block_of(picture).front().find(", 19 of 36 parts done"), std::string::npos) << block_of(picture).front();
  const document::Node tree = to_document(picture, 1);
  const document::Node& row = tree.find("running")->items()[0];
  EXPECT_EQ(row.find("parts_done")->as_integer(), 19);
  EXPECT_EQ(row.find("parts")->as_integer(), 36);
  running.push_back(running[0]);
  running[1].order.part = "frame 4";
  picture.running = running;
  EXPECT_TRUE(line_of(picture).starts_with("0 done, 1 running (")) << line_of(picture);
  EXPECT_NE(line_of(picture).find(" done), 2 waiting"), std::string::npos) << line_of(picture);
  EXPECT_EQ(to_document(picture, 1).find("counts")->find("running")->as_integer(), 1);
  running[1].is_queued = true;
  EXPECT_NE(line_of(picture).find(", 1 part pending, 2 waiting"), std::string::npos) << line_of(picture);
  running.pop_back();
  picture.running = running;
  running[0].order.part.clear();  // the scan itself is put together
  EXPECT_EQ(line_of(picture).find("parts"), std::string::npos);
}

TEST(TimeLeft, CountsCoreTimeAndWhatIsBegun) {
  const RunReport report;
  RunPicture picture{report, {}, {}, 3, 100, 500, {}, 70};
  EXPECT_EQ(seconds_left(picture), 280) << "elsewhere: by the clock alone";
  picture.cores = 2;
  picture.core_seconds = 10;  // the other 60 seconds of the clock were waits
  EXPECT_EQ(seconds_left(picture), 20);
  picture.bytes_begun = 100;
  EXPECT_EQ(seconds_left(picture), 15);
  picture.bytes_begun = 1000;
  EXPECT_EQ(seconds_left(picture), 0);
  picture.bytes_begun = 0;
  picture.bytes_found = 60;  // the ten seconds made the other 40
  EXPECT_EQ(seconds_left(picture), 50);
}

}  // namespace
}  // namespace scanmill::runner
