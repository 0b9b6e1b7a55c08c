// SPDX-License-Identifier: Apache-2.0
// What stands in the tree after a run, and what the next run makes of it.
#include <cstdlib>

#include "fake_work.hpp"
#include "run_sample.hpp"
#include "runner/night.hpp"
#include "runner/run_files.hpp"

namespace scanmill::runner {
namespace {

class PageWork : public Work {
 public:
  std::span<const std::string_view> what_keys() const override { return {}; }
  void check_part(const document::Node&, document::Problems&) const override {}
  document::Node overlay(document::Node base, const document::Node&) const override { return base; }
  Result<document::Node> resolve(const document::Node& what, const std::string&) const override { return what; }
  Result<Archive> discover(const std::string&, const document::Node&,
                           const std::function<document::Node(const std::string&)>&) override {
    return Archive();
  }
  std::optional<Fingerprint> known_fingerprint(std::size_t, const document::Node&) override { return std::nullopt; }
  InputLook look_at(std::size_t) const override { return {}; }
  std::string save_hashes_of(std::size_t) const override { return {}; }
  Result<Fingerprint> fingerprint(std::size_t, const document::Node&) override { return Fingerprint(); }
  Result<Outcome> run(std::size_t, const document::Node&, const std::string&, const Context&, Progress&) override {
    return Outcome();
  }
  void load_hashes(std::string_view) override {}
  std::string save_hashes() const override { return {}; }
  std::string night_page(const Night& night) const override {
    document::Node whole = night.head, scans = document::Node::sequence();
    for (std::size_t k = 0; k < night.scans; ++k) scans.push(night.scan(k));
    whole.set("scans", std::move(scans));
    return document::to_json(whole);
  }
};

class RunFiles : public RunnerTest {
 protected:
  void SetUp() override {
    RunnerTest::SetUp();
    unsetenv("GITHUB_STEP_SUMMARY");
    ASSERT_TRUE(tree().prepare().ok());
  }
  void TearDown() override {
    unsetenv("GITHUB_STEP_SUMMARY");
    RunnerTest::TearDown();
  }
  OutputTree tree() const { return OutputTree(root + "/out"); }
  Result<void> write(const RunReport& run) { return write_run_files(run, work, tree(), notes); }
  document::Node page() const {
    auto night = document::parse_json(slurp(root + "/out/report.html"), "report.html");
    return night ? *night : document::Node();
  }

  PageWork work;
  std::vector<std::string> notes;
};

RunReport night(std::vector<std::pair<std::string, double>> errors, int loops = 1) {
  RunReport run = sample_run();
  run.scans.clear();
  run.exit_code = 0;
  for (const auto& [name, error] : errors) {
    run.scans.push_back(scan_entry(name, ScanFate::Done));
    run.scans.back().counts.set("max_error_mm", error);
    run.scans.back().counts.set("boundary_loops", loops);
  }
  return run;
}

std::string names_of(const std::vector<WorseScan>& worse) {
  std::string names;
  for (const WorseScan& scan : worse) names += scan.name + " ";
  return names;
}

TEST_F(RunFiles, AreAllThereAndNothingElse) {
  ASSERT_TRUE(write(sample_run()).ok());
  const auto files = store::list_files(root + "/out");
  ASSERT_TRUE(files.ok());
  EXPECT_EQ(*files,
            (std::vector<std::string>{"journal/night.json", "junit.xml", "report.html", "scanmill.prom", "trace.tsv"}));
  EXPECT_TRUE(notes.empty());
  const document::Node night = page();
  EXPECT_EQ(night.find("scanmill_run")->as_integer(), 1);
  EXPECT_TRUE(night.find("compared_with")->is_null());
  const auto& scans = night.find("scans")->items();
  EXPECT_TRUE(scans[0].find("new")->as_bool());
  EXPECT_EQ(scans[1].find("new"), nullptr);
  EXPECT_NE(scans[3].find("advice"), nullptr);
}

TEST_F(RunFiles, OfAPartOfTheScansAreBetterThanNone) {
  RunReport one = night({{"a", 9}});
  one.only = {"a"};
  ASSERT_TRUE(write(one).ok());
  EXPECT_TRUE(store::exists(tree().page_file()));
  EXPECT_FALSE(store::exists(tree().night_file()));
}

TEST_F(RunFiles, WithoutAPageOfTheWorkThereIsNone) {
  FakeWork plain;
  ASSERT_TRUE(write_run_files(sample_run(), plain, tree(), notes).ok());
  EXPECT_FALSE(store::exists(tree().page_file()));
  EXPECT_TRUE(store::exists(tree().junit_file()));
}

TEST_F(RunFiles, CompareWithTheLastRunThatEnded) {
  ASSERT_TRUE(write(night({{"a", 0.5}, {"b", 0.5}, {"c", 0.5}})).ok());
  // Killed, interrupted, stopped by a fault, or told to look at one scan: no night to compare with.
  for (const int code : {130, 143, 1}) {
    RunReport cut = night({{"a", 9}});
    cut.exit_code = code;
    ASSERT_TRUE(write(cut).ok());
  }
  RunReport one = night({{"a", 9}});
  one.only = {"a"};
  const std::string before = slurp(tree().page_file()) + slurp(tree().junit_file()) + slurp(tree().metrics_file());
  ASSERT_TRUE(write(one).ok());
  EXPECT_EQ(slurp(tree().page_file()) + slurp(tree().junit_file()) + slurp(tree().metrics_file()), before);

  RunReport second = night({{"a", 0.6}, {"b", 0.505}, {"new", 7}});
  second.scans.push_back(failed_entry("c", ScanFate::Stale, fail(Code::BadInput, "x")));
  ASSERT_TRUE(write(second).ok());
  const document::Node seen = page();
  ASSERT_EQ(seen.find("worse")->items().size(), 1u);
  const document::Node& worse = seen.find("worse")->items()[0];
  EXPECT_EQ(worse.find("name")->as_string(), "a");
  const document::Node& figure = worse.find("figures")->items()[0];
  EXPECT_EQ(figure.find("then")->as_number(), 0.5);
  EXPECT_EQ(figure.find("now")->as_number(), 0.6);
  EXPECT_EQ(seen.find("compared_with")->as_string(), "2026-01-31T23:15:00Z");

  // A scan that failed in between is still compared with its last figures.
  ASSERT_TRUE(write(night({{"a", 0.6}, {"c", 0.9}})).ok());
  ASSERT_EQ(page().find("worse")->items().size(), 1u);
  EXPECT_EQ(page().find("worse")->items()[0].find("name")->as_string(), "c");
}

TEST_F(RunFiles, AreTriedAllWhenOneCannotBeWritten) {
  std::filesystem::create_directories(tree().junit_file() + "/in the way");
  const auto written = write(sample_run());
  ASSERT_FALSE(written.ok());
  EXPECT_NE(written.error().text().find("junit.xml"), std::string::npos) << written.error().text();
  EXPECT_TRUE(store::exists(tree().metrics_file()));
}

TEST_F(RunFiles, StepSummaryIsAppended) {
  const std::string path = root + "/summary.md";
  spill(path, "of another step\n");
  setenv("GITHUB_STEP_SUMMARY", path.c_str(), 1);
  ASSERT_TRUE(write(sample_run()).ok());
  ASSERT_TRUE(write(sample_run()).ok());
  const std::string text = slurp(path);
  EXPECT_TRUE(text.starts_with("of another step\n## scanmill night"));
  EXPECT_NE(text.find("## scanmill"), text.rfind("## scanmill"));
  setenv("GITHUB_STEP_SUMMARY", (root + "/no/such/folder").c_str(), 1);
  ASSERT_TRUE(write(sample_run()).ok());  // a note, never a failure
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("/no/such/folder"), std::string::npos) << notes[0];
}

TEST(WriteRun, GivesTheBytesOfTheWholeDocument) {
  for (RunReport run : {sample_run(), RunReport()}) {
    std::string text;
    const auto sink = memory_sink("run.json", text);
    ASSERT_TRUE(write_run(run, *sink).ok());
    ASSERT_TRUE(sink->commit().ok());
    EXPECT_EQ(text, document::to_json(to_document(run), 1) + "\n");
  }
}

TEST(Counts, AreWhatTheyWereSetTo) {
  Counts counts;
  EXPECT_FALSE(counts.is_known());
  EXPECT_TRUE(counts.document().is_null());
  counts = document::Node::map();
  EXPECT_TRUE(counts.is_known());
  EXPECT_TRUE(counts.empty());
  counts.set("triangles", 7);
  counts.set("rms_mm", 0.5);
  counts.set("name", "no number");
  counts.set("triangles", std::int64_t{1} << 60);
  EXPECT_EQ(document::to_json(counts.document()), "{\"triangles\":1152921504606846976,\"rms_mm\":0.5}");
  EXPECT_TRUE(counts.find("triangles")->is_integer());
  EXPECT_FALSE(counts.find("points").has_value());
}

TEST(WorseScans, OrdersByFitErrorThenLoopsThenGatesThenName) {
  RunReport last = night({{"a", 1}, {"b", 1}, {"c", 1}, {"d", 1}, {"e", 1}, {"same", 1}, {"better", 1}});
  RunReport now = night({{"a", 1}, {"b", 1.1}, {"c", 3}, {"d", 1}, {"e", 1}, {"same", 1}, {"better", 0.1}});
  now.scans[0].failed_gates = {"verify.rms_mm: found 2 mm, allowed 1 mm"};
  now.scans[3].counts.set("boundary_loops", 9);
  now.scans[4].counts.set("boundary_loops", 9);
  now.scans[4].failed_gates = {"verify.rms_mm: found 2 mm, allowed 1 mm"};
  EXPECT_EQ(names_of(worse_scans(now, LastNight(to_document(last)))), "c b e d a ");
  // The gate failed then as well, with another figure: nothing new.
  last.scans[0].failed_gates = {"verify.rms_mm: found 3 mm, allowed 1 mm"};
  EXPECT_EQ(names_of(worse_scans(now, LastNight(to_document(last)))), "c b e d ");
}

TEST(WorseScans, TakesNoiseAndStrangersForNothing) {
  const RunReport last = night({{"a", 1}, {"b", 0}});
  EXPECT_EQ(names_of(worse_scans(night({{"a", 1.019}, {"b", 0}, {"new", 9}}), LastNight(to_document(last)))), "");
  EXPECT_EQ(names_of(worse_scans(night({{"a", 1.021}}), LastNight(to_document(last)))), "a ");
  EXPECT_EQ(names_of(worse_scans(night({{"b", 0.001}}), LastNight(to_document(last)))), "b ");
  for (const char* odd : {"{}", "[]", "{\"scans\": 7}", "{\"scans\": [7, {}, {\"name\": 3}, {\"name\": \"a\"}]}",
                          "{\"scans\": [{\"name\": \"a\", \"counts\": 7, \"failed_gates\": 7}]}"})
    EXPECT_EQ(names_of(worse_scans(night({{"a", 9}}), LastNight(*document::parse_json(odd, odd)))), "") << odd;
}

}  // namespace
}  // namespace scanmill::runner
