// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/file.h>

#include <csignal>

#include "fake_work.hpp"
#include "runner/driver.hpp"
#include "runner/quarantine.hpp"

namespace scanmill::runner {
namespace {

class RunJob : public RunnerTest {
 protected:
  struct Seen {
    int code = -1;
    std::string out, err, last;
    document::Node report;
    std::string state(const std::string& scan) const { return find(scan, "state"); }
    std::string find(const std::string& scan, const char* key) const {
      const document::Node* scans = report.find("scans");
      if (scans)
        for (const document::Node& entry : scans->items())
          if (entry.find("name")->as_string() == scan) return entry.find(key)->as_string();
      return "";
    }
  };

  void scan(const std::string& name, const std::string& text) { spill(root + "/archive/" + name + ".txt", text); }

  Seen run(std::function<void(RunOptions&)> change = {}) {
    spill(root + "/job.yaml", job_text);
    RunOptions options;
    options.job = root + "/job.yaml";
    options.out = root + "/out";
    options.threads = 1;
    options.executor = "inline";
    if (change) change(options);
    std::FILE* out = std::tmpfile();
    std::FILE* err = std::tmpfile();
    Seen seen;
    work.runs.clear();
    {
      Console console({ProgressStyle::None, false, false}, out, err);
      seen.code = run_job(options, work, console, stop);
    }
    seen.out = drain(out);
    seen.err = drain(err);
    const auto end = seen.out.find_last_not_of('\n');
    const auto begin = seen.out.rfind('\n', end);
    seen.last = seen.out.substr(begin == std::string::npos ? 0 : begin + 1, end - begin);
    if (auto report = document::parse_json(slurp(root + "/out/run.json"), "run.json")) seen.report = *report;
    return seen;
  }

  static std::string drain(std::FILE* file) {
    std::string text(static_cast<std::size_t>(std::ftell(file)), '\0');
    std::rewind(file);
    text.resize(std::fread(text.data(), 1, text.size(), file));
    std::fclose(file);
    return text;
  }

  std::string scans_tree() const {
    std::string text;
    if (const auto files = store::list_files(root + "/out/scans"))
      for (const std::string& file : *files) text += file + " ";
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root + "/out/scans"))
      if (entry.is_directory() && entry.path().filename().string().front() == '.') text += "LEFTOVER ";
    return text;
  }

  FakeWork work;
  Stop stop;
  std::string job_text = "scanmill: 1\narchive: archive\nlattice: {bin_mm: 1}\n";
};

TEST_F(RunJob, MakesEveryScanAndEndsWithTheLastLine) {
  scan("a", "one");
  scan("deep/b", "two");
  const Seen seen = run();
  EXPECT_EQ(seen.code, 0) << seen.err;
  EXPECT_EQ(scans_tree(), "a/mesh.stl a/record.h5 deep/b/mesh.stl deep/b/record.h5 ");
  EXPECT_EQ(seen.last.rfind("2 scans: 0 unchanged, 2 done, 0 failed, 0 quarantined | gates: 0 | 00:00:", 0), 0u)
      << seen.last;
  EXPECT_NE(seen.last.find("h | " + root + "/out/run.json | exit 0"), std::string::npos) << seen.last;
  EXPECT_NE(
      seen.out.find("a: done | " + root + "/out/scans/a/mesh.stl | " + root + "/out/scans/a/record.h5 | 7 triangles"),
      std::string::npos)
      << seen.out;
  EXPECT_EQ(seen.state("deep/b"), "done");
  EXPECT_NE(seen.err.find("note: 1 file of the suffix .las"), std::string::npos) << seen.err;
  EXPECT_EQ(seen.report.find("exit")->as_integer(), 0);
  EXPECT_TRUE(store::exists(root + "/out/logs/deep/b.log"));
}

TEST_F(RunJob, SkipsWhatIsDoneAndRedoesWhatChanged) {
  scan("a", "one");
  scan("b", "two");
  run();
  Seen seen = run([](RunOptions& o) { o.explain = true; });
  EXPECT_TRUE(work.runs.empty());
  EXPECT_NE(seen.out.find("a: skipped: unchanged"), std::string::npos) << seen.out;
  scan("b", "three");
  std::filesystem::remove(root + "/out/scans/a/mesh.stl");
  seen = run([](RunOptions& o) { o.explain = true; });
  EXPECT_EQ(work.runs, (std::vector<std::string>{"b", "a"}));  // heaviest first
  EXPECT_NE(seen.out.find("a: run: mesh.stl is missing"), std::string::npos) << seen.out;
  EXPECT_NE(seen.out.find("b: run: input b.txt changed"), std::string::npos) << seen.out;
  EXPECT_EQ(slurp(root + "/out/scans/b/mesh.stl"), "mesh of three");
  spill(root + "/out/scans/a/record.h5", "cut");
  seen = run([](RunOptions& o) {
    o.explain = true;
    o.sets = {"lattice.bin_mm=2"};
  });
  EXPECT_NE(seen.out.find("a: run: lattice.bin_mm 1 -> 2; record.h5 has 3 bytes, not 13"), std::string::npos)
      << seen.out;
}

TEST_F(RunJob, KeepsTheFilesOfAFailedGateAndEndsWithFour) {
  scan("a", "rough");
  scan("b", "two");
  for (const char* state : {"done", "unchanged"}) {  // a rejected result stays rejected until it is made again
    const Seen seen = run();
    EXPECT_EQ(seen.code, kExitGate);
    EXPECT_NE(seen.last.find("| gates: 1 |"), std::string::npos) << seen.last;
    EXPECT_NE(seen.err.find("scan a: rejected: max_error_mm: found 2, allowed 1"), std::string::npos) << seen.err;
    EXPECT_EQ(seen.state("a"), state);
    const document::Node& entry = seen.report.find("scans")->items()[0];
    EXPECT_TRUE(entry.find("rejected")->as_bool());
    EXPECT_TRUE(store::exists(root + "/out/scans/a/mesh.stl"));
  }
  scan("c", "bad");
  EXPECT_EQ(run().code, kExitScans);  // 3 before 4
  std::filesystem::remove(root + "/archive/c.txt");
  scan("a", "smooth");
  EXPECT_EQ(run().code, kExitGood);
}

TEST_F(RunJob, LogsWhenWithWhatAndWhatCameOut) {
  scan("a", "one");
  scan("b", "broken");
  run();
  const std::string good = slurp(root + "/out/logs/a.log"), bad = slurp(root + "/out/logs/b.log");
  for (const char* part :
       {"scan a, 20", "why: new", "what: {\"lattice\"", "stage reduce, 2 to do", "triangles 7", "done, record id-one"})
    EXPECT_NE(good.find(part), std::string::npos) << part << " in\n" << good;
  EXPECT_NE(bad.find("failed: its description is broken"), std::string::npos) << bad;
}

TEST_F(RunJob, NamesNoReportWhereNoneWasWritten) {
  scan("a", "one");
  job_text = "scanmill: 1\narchive: nowhere\nlattice: {bin_mm: 1}\n";
  Seen seen = run();
  EXPECT_EQ(seen.code, kExitUsage);
  EXPECT_NE(seen.last.find("| nothing written | exit 2"), std::string::npos) << seen.last;
  EXPECT_NE(seen.err.find("job.yaml:2:10: archive: found no folder"), std::string::npos) << seen.err;
  job_text = "";
  seen = run();
  EXPECT_NE(seen.err.find("job.yaml:1:1: "), std::string::npos) << seen.err;
}

TEST_F(RunJob, DryRunWritesNothing) {
  scan("a", "one");
  const Seen seen = run([](RunOptions& o) { o.dry_run = true; });
  EXPECT_EQ(seen.code, 0);
  EXPECT_NE(seen.out.find("a: would run: new"), std::string::npos) << seen.out;
  EXPECT_FALSE(store::exists(root + "/out"));
  EXPECT_TRUE(work.runs.empty());
}

TEST_F(RunJob, ReportsABadScanAndGoesOn) {
  scan("a", "bad");
  scan("b", "two");
  const Seen seen = run();
  EXPECT_EQ(seen.code, 3);
  EXPECT_EQ(scans_tree(), "b/mesh.stl b/record.h5 ");
  EXPECT_NE(seen.err.find("scan a: failed: a.txt:1: found 'bad'; wanted numbers | again: scanmill run " + root +
                          "/job.yaml --out " + root + "/out --only a"),
            std::string::npos)
      << seen.err;
  EXPECT_EQ(seen.state("a"), "failed");
  EXPECT_EQ(seen.state("b"), "done");
}

TEST_F(RunJob, QuarantinesBadInputUntilItChangesOrIsNamed) {
  scan("a", "bad");
  run();
  Seen seen = run();
  EXPECT_EQ(seen.code, 0);
  EXPECT_TRUE(work.runs.empty());
  EXPECT_EQ(seen.state("a"), "quarantined");
  EXPECT_NE(seen.err.find("found 'bad'"), std::string::npos);
  EXPECT_EQ(run([](RunOptions& o) { o.sets = {"strict=true"}; }).code, 3);
  EXPECT_EQ(run([](RunOptions& o) { o.only = {"a"}; }).code, 3);
  EXPECT_EQ(work.runs.size(), 1u);
  scan("a", "good");
  EXPECT_EQ(run().state("a"), "done");
}

TEST_F(RunJob, EndsTheQuarantineOfAScanWhoseGoodFileIsBack) {
  scan("a", "good");
  scan("b", "good");
  EXPECT_EQ(run().code, 0);
  scan("a", "bad");
  EXPECT_EQ(run().code, 3);
  EXPECT_EQ(Quarantine::load(root + "/out/quarantine.json").names(), std::vector<std::string>{"a"});
  scan("a", "good");
  EXPECT_EQ(run().code, 0);
  EXPECT_TRUE(Quarantine::load(root + "/out/quarantine.json").names().empty());
}

TEST_F(RunJob, KeepsTheLastGoodResultAsStale) {
  scan("a", "good");
  run();
  scan("a", "bad");
  const Seen seen = run();
  EXPECT_EQ(seen.code, 3);
  EXPECT_EQ(seen.state("a"), "stale");
  EXPECT_EQ(slurp(root + "/out/scans/a/mesh.stl"), "mesh of good");
  scan("a", "good");
  EXPECT_EQ(run().state("a"), "unchanged");
}

TEST_F(RunJob, ExceptionsAndMemoryFailOneScanOnly) {
  scan("a", "throws");
  scan("b", "hungry");
  scan("c", "fine");
  scan("d", "broken");
  const Seen seen = run();
  EXPECT_EQ(seen.code, 3);
  EXPECT_NE(seen.err.find("surprise"), std::string::npos);
  EXPECT_NE(seen.err.find("the memory cap of"), std::string::npos);
  EXPECT_NE(seen.err.find("scan d: failed: its description is broken"), std::string::npos);
  EXPECT_EQ(seen.state("c"), "done");
  EXPECT_EQ(scans_tree(), "c/mesh.stl c/record.h5 ");
}

TEST_F(RunJob, InputThatChangesWhileItIsMeshedFailsTheScan) {
  scan("a", "one");
  work.before_end = [&](const std::string&) { scan("a", "other"); };
  const Seen seen = run();
  EXPECT_EQ(seen.code, 3);
  EXPECT_NE(seen.err.find("changed while"), std::string::npos) << seen.err;
  EXPECT_EQ(scans_tree(), "");
}

TEST_F(RunJob, StopsOnSignalWithTheReportWritten) {
  scan("a", "one");
  scan("b", "two");
  scan("c", "six");
  work.before_end = [&](const std::string& name) {
    if (name != "b") return;
    stop.signal.store(SIGTERM);
    stop.flag.set();
  };
  const Seen seen = run();
  EXPECT_EQ(seen.code, 143);
  EXPECT_EQ(seen.state("a"), "done");
  EXPECT_EQ(seen.state("b"), "interrupted");
  EXPECT_EQ(seen.state("c"), "pending");
  EXPECT_EQ(scans_tree(), "a/mesh.stl a/record.h5 ");
  EXPECT_EQ(seen.report.find("exit")->as_integer(), 143);
}

TEST_F(RunJob, SecondRunOnTheSameTreeIsSentAway) {
  scan("a", "one");
  std::filesystem::create_directories(root + "/out/journal");
  const int file = open((root + "/out/journal/lock").c_str(), O_RDWR | O_CREAT, 0644);
  ASSERT_EQ(flock(file, LOCK_EX), 0);
  ASSERT_EQ(write(file, "pid 1 on elsewhere\n", 19), 19);
  const Seen seen = run();
  close(file);
  EXPECT_EQ(seen.code, 75);
  EXPECT_NE(seen.err.find("pid 1 on elsewhere"), std::string::npos) << seen.err;
  EXPECT_TRUE(work.runs.empty());
  EXPECT_EQ(run().code, 0);
}

TEST_F(RunJob, RemovesAttemptsOfDeadRuns) {
  scan("deep/a", "one");
  spill(root + "/out/scans/deep/.a.1/mesh.stl", "half");
  spill(root + "/out/scans/.gone.3/mesh.stl", "half");
  run();
  EXPECT_EQ(scans_tree(), "deep/a/mesh.stl deep/a/record.h5 ");
}

TEST_F(RunJob, KeepsTheResultOfAVanishedSource) {
  scan("a", "one");
  scan("b", "two");
  run();
  std::filesystem::remove(root + "/archive/a.txt");
  const Seen seen = run();
  EXPECT_EQ(seen.code, 0);
  EXPECT_EQ(seen.state("a"), "vanished");
  EXPECT_EQ(seen.last.rfind("1 scan: 1 unchanged", 0), 0u) << seen.last;
  EXPECT_TRUE(store::exists(root + "/out/scans/a/mesh.stl"));
}

TEST_F(RunJob, RefusesJobsThatSelectNothing) {
  EXPECT_EQ(run().code, 2);  // an empty archive
  scan("alpha", "one");
  Seen seen = run([](RunOptions& o) { o.only = {"alpah"}; });
  EXPECT_EQ(seen.code, 2);
  EXPECT_NE(seen.err.find("nearest alpha"), std::string::npos) << seen.err;
  job_text += "scans: [beta*, gamma]\n";
  seen = run();
  EXPECT_EQ(seen.code, 2);
  EXPECT_NE(seen.err.find("scans: found no scan that matches 'gamma'"), std::string::npos) << seen.err;
  job_text = "scanmill: 1\narchive: archive\n";
  EXPECT_EQ(run().code, 2);
  job_text = "scanmill: 1\narchive: nowhere\nlattice: {bin_mm: 1}\n";
  EXPECT_EQ(run().code, 2);
  EXPECT_FALSE(store::exists(root + "/out"));
}

TEST_F(RunJob, GoesOnWherePatternsMatchNothing) {
  scan("alpha", "one");
  scan("beta", "two");
  job_text += "scans: [alpha, bete]\noverrides: [{scans: \"*/castings/*\", lattice: {bin_mm: 2}}]\n";
  const Seen seen = run();
  EXPECT_EQ(seen.code, 0) << seen.err;
  EXPECT_EQ(work.runs, std::vector<std::string>{"alpha"});
  for (const char* note : {"scans: found no scan that matches 'bete'; the archive holds alpha, beta; nearest beta",
                           "overrides.scans: found no scan that matches '*/castings/*'"}) {
    EXPECT_NE(seen.err.find(note), std::string::npos) << seen.err;
    EXPECT_NE(document::to_json(*seen.report.find("notes")).find(note), std::string::npos) << note;
  }
  const JobCheck check = check_job(root + "/job.yaml", {}, work);
  EXPECT_TRUE(check.problems.empty()) << check.problems.front();
  EXPECT_EQ(check.notes.size(), 2u);
}

TEST_F(RunJob, ChecksTheScansThatTheJobItselfDescribes) {
  scan("alpha", "broken");
  spill(root + "/job.yaml", job_text);
  EXPECT_TRUE(check_job(root + "/job.yaml", {}, work).problems.empty()) << "a file of the archive fails alone";
  work.of_job = "alpha";
  EXPECT_EQ(check_job(root + "/job.yaml", {}, work).problems,
            std::vector<std::string>{root + "/job.yaml: its description is broken"});
}

TEST_F(RunJob, RefusesToWriteAmongTheScans) {
  scan("scans/a", "one");
  std::filesystem::create_directory_symlink("archive", root + "/link");
  for (const char* out : {"/archive", "/link/", "/archive/scans/..", "/link/../archive/."}) {
    const Seen seen = run([&](RunOptions& o) { o.out = root + out; });
    EXPECT_EQ(seen.code, 2) << out;
    EXPECT_NE(seen.err.find("choose another --out"), std::string::npos) << seen.err;
  }
  job_text =
      "scanmill: 1\narchive: archive/scans\nlattice: {bin_mm: 1}\n";  // --out archive would write to archive/scans
  EXPECT_EQ(run([&](RunOptions& o) { o.out = root + "/archive"; }).code, 2);
  EXPECT_EQ(store::list_files(root + "/archive")->size(), 1u);
  EXPECT_FALSE(store::exists(root + "/archive/journal"));
  EXPECT_EQ(run().code, 0);
}

TEST_F(RunJob, SaysOnceWhatVanishedWithoutAResult) {
  scan("a", "one");
  scan("b", "bad");
  scan("c", "bad");
  EXPECT_EQ(run().code, kExitScans);
  run([](RunOptions& o) { o.only = {"a"}; });  // run.json knows a alone now
  std::filesystem::remove(root + "/archive/b.txt");
  Seen seen = run();
  EXPECT_NE(seen.err.find("note: 1 scan without a result vanished from the archive: b"), std::string::npos) << seen.err;
  EXPECT_EQ(seen.last.rfind("2 scans: 1 unchanged, 0 done, 0 failed, 1 quarantined |", 0), 0u) << seen.last;
  seen = run();
  EXPECT_EQ(seen.err.find("vanished"), std::string::npos) << seen.err;
}

TEST_F(RunJob, CountsWhatIsNotMadeAndWhatVanished) {
  for (const char* name : {"a", "b", "c", "d"}) scan(name, "one");
  run([](RunOptions& o) { o.only = {"d"}; });
  std::filesystem::remove(root + "/archive/d.txt");
  EXPECT_EQ(run([](RunOptions& o) {
              o.dry_run = true;
            }).last.rfind("3 scans: 0 unchanged, 0 done, 0 failed, 0 quarantined, 1 vanished |", 0),
            0u);
  work.before_end = [&](const std::string&) { (void)stop.request(SIGTERM); };
  const Seen seen = run();
  EXPECT_EQ(seen.code, 143);
  EXPECT_EQ(seen.last.rfind("3 scans: 0 unchanged, 0 done, 0 failed, 0 quarantined, 3 not made, 1 vanished |", 0), 0u)
      << seen.last;
}

TEST_F(RunJob, RefusesScansWhoseFoldersWouldLieInEachOther) {
  scan("a", "one");
  scan("a/b", "two");
  const Seen seen = run();
  EXPECT_EQ(seen.code, 2);
  EXPECT_NE(seen.err.find("found both a and a/b"), std::string::npos) << seen.err;
}

TEST_F(RunJob, UnwritableOutputIsOneLineNamingThePath) {
  scan("a", "one");
  spill(root + "/file", "");
  const Seen seen = run([&](RunOptions& o) { o.out = root + "/file/out"; });
  EXPECT_EQ(seen.code, 1);
  EXPECT_NE(seen.err.find(root + "/file/out"), std::string::npos) << seen.err;
  EXPECT_EQ(std::count(seen.err.begin(), seen.err.end(), '\n'), 1) << seen.err;
}

TEST_F(RunJob, CapBelowTheProcessItselfIsRefused) {
  scan("a", "one");
  EXPECT_EQ(run([](RunOptions& o) { o.memory = 1 << 20; }).code, 2);
  const auto local = [](std::int64_t threads, std::uint64_t memory) {
    return [=](RunOptions& o) {
      o.executor = "local";
      o.threads = threads;
      o.memory = memory << 20;
    };
  };
  const Seen seen = run(local(1, 117));
  EXPECT_EQ(seen.code, 2);
  EXPECT_NE(seen.err.find("memory cap: found 117 MiB; a run with 1 thread needs 118 MiB"), std::string::npos)
      << seen.err;
  EXPECT_EQ(run(local(7, 118)).code, 2) << "threads cost memory";
  EXPECT_EQ(run(local(1, 118)).code, 0);
}

}  // namespace
}  // namespace scanmill::runner
