// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>

#include "fake_work.hpp"
#include "run_sample.hpp"
#include "runner/job.hpp"
#include "runner/notify.hpp"

namespace scanmill::runner {
namespace {

using std::chrono::milliseconds;

class Notify : public RunnerTest {
 protected:
  void SetUp() override {
    RunnerTest::SetUp();
    ASSERT_TRUE(tree().prepare().ok());
    run = sample_run();
    run.job_path = root + "/job.yaml";
    run.out = root + "/out";
    run.written = true;
  }
  OutputTree tree() const { return OutputTree(root + "/out"); }
  std::vector<std::string> tell(const std::string& command, NotifyOn on = NotifyOn::Always,
                                milliseconds limit = milliseconds(20000)) {
    return notify({{on, command}}, run, tree(), limit);
  }
  RunReport run;
};

TEST_F(Notify, GivesTheCommandWhatItNeeds) {
  setenv("SCANMILL_EXIT", "of an outer run", 1);
  setenv("SCANMILL_TEST_KEPT", "kept", 1);
  const auto notes = tell(
      "printf '%s\\n' \"$SCANMILL_RUN\" \"$SCANMILL_EXIT\" \"$SCANMILL_OUT\" \"$SCANMILL_SUMMARY\" "
      "\"$SCANMILL_VERDICT\" \"$SCANMILL_TEST_KEPT\" \"$(pwd)\" > told; cat; ulimit -d >> told; echo shown");
  unsetenv("SCANMILL_EXIT");
  EXPECT_TRUE(notes.empty()) << notes[0];
  const std::string folder = std::filesystem::canonical(root).string();
  EXPECT_TRUE(slurp(root + "/told")
                  .starts_with(root + "/out/run.json\n3\n" + root + "/out\n" + last_line(run) +
                               "\n4 scans failed, 1 scan rejected by a gate, 2 scans not finished\n"
                               "kept\n" +
                               folder + "\n"))
      << slurp(root + "/told");
  EXPECT_NE(slurp(root + "/out/journal/notify.log").find("\nshown\n"), std::string::npos);
}

TEST_F(Notify, RunsWhatTheExitCodeCallsFor) {
  const std::vector<NotifyRule> rules{{NotifyOn::Always, "printf always, >> told"},
                                      {NotifyOn::Failure, "printf failure, >> told"},
                                      {NotifyOn::Success, "printf success, >> told"}};
  for (const auto& [code, want] : {std::pair(0, "always,success,"), {3, "always,failure,"}, {130, "always,failure,"}}) {
    run.exit_code = code;
    std::filesystem::remove(root + "/told");
    EXPECT_TRUE(notify(rules, run, tree()).empty());
    EXPECT_EQ(slurp(root + "/told"), want);
  }
}

TEST_F(Notify, SaysWhatWentWrongAndGoesOn) {
  const auto notes = notify({{NotifyOn::Always, "echo no such \x1b host >&2; exit 7"},
                             {NotifyOn::Always, "kill -9 $$"},
                             {NotifyOn::Always, "/no/such/program"},
                             {NotifyOn::Always, "echo yes > told"}},
                            run, tree());
  ASSERT_EQ(notes.size(), 3u);
  EXPECT_TRUE(
      notes[0].starts_with("notify: echo no such \\x1b host >&2; exit 7: ended with exit code 7: no such \\x1b host"))
      << notes[0];
  EXPECT_NE(notes[1].find("ended by signal 9"), std::string::npos) << notes[1];
  EXPECT_EQ(notes[1].find("no such"), std::string::npos) << "that is the first command's: " << notes[1];
  EXPECT_NE(notes[2].find("exit code 127"), std::string::npos) << notes[2];
  EXPECT_EQ(slurp(root + "/told"), "yes\n");
  run.job_path = root + "/gone/job.yaml";
  EXPECT_NE(tell("true").at(0).find("could not be started: No such file"), std::string::npos);
}

TEST_F(Notify, EndsACommandThatHangsWithAllItStarted) {
  // The shell, and a child that does not take the first signal.
  const auto notes = tell("(trap '' TERM; echo $$ > child; sleep 300) & sleep 300; echo never > told", NotifyOn::Always,
                          milliseconds(200));
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("was ended after 0.2 s"), std::string::npos) << notes[0];
  EXPECT_FALSE(store::exists(root + "/told"));
}

TEST_F(Notify, NeedsNoTree) {
  run.written = false;
  std::filesystem::remove_all(root + "/out");
  EXPECT_TRUE(tell("test -z \"$SCANMILL_RUN\" && echo yes > told").empty());
  EXPECT_EQ(slurp(root + "/told"), "yes\n");
  EXPECT_FALSE(store::exists(root + "/out"));
}

TEST(ReadNotify, TakesAListOfCommandsAndRefusesTheRest) {
  const FakeWork work;
  const auto read = [&](const std::string& text) {
    return job_from("scanmill: 1\narchive: a\nlattice: {bin_mm: 1}\nnotify: " + text + "\n", "job.yaml", {}, work);
  };
  const auto good = read("[{run: a b}, {on: failure, run: 'mail -s x', x-why: y}, {on: success, run: c}]");
  ASSERT_TRUE(good.ok()) << good.error().text();
  ASSERT_EQ(good->how.notify.size(), 3u);
  EXPECT_EQ(good->how.notify[0].on, NotifyOn::Always);
  EXPECT_EQ(good->how.notify[1].on, NotifyOn::Failure);
  EXPECT_EQ(good->how.notify[1].run, "mail -s x");
  EXPECT_EQ(good->how.notify[2].on, NotifyOn::Success);
  for (const auto& [text, sentence] : {std::pair("mail me", "job.yaml:4:9: notify: found mail me"),
                                       {"[mail me]", "notify: found mail me"},
                                       {"[{on: failure}]", "without run"},
                                       {"[{run: ''}]", "notify.run: found"},
                                       {"[{run: [a]}]", "notify.run: found"},
                                       {"[{on: faliure, run: a}]", "nearest failure"},
                                       {"[{runn: a}]", "allowed on, run; nearest run"},
                                       {"[{webhook: 'https://example.org'}]", "curl"}}) {
    const auto bad = read(text);
    ASSERT_FALSE(bad.ok()) << text;
    EXPECT_NE(bad.error().text().find(sentence), std::string::npos) << bad.error().text();
  }
}

}  // namespace
}  // namespace scanmill::runner
