// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/context.hpp"
#include "pipeline/bench_report.hpp"
#include "pipeline/bench_stages.hpp"

namespace scanmill::pipeline {
namespace {

BenchReport report() {
  BenchReport made;
  made.version = "1";
  made.processor = "some";
  made.cores = made.threads = 2;
  made.input = {"a.ply", "scan", 1000, 100, 90, 160, 0.5};
  made.stages = {{"reduce", "points", 1000, {2, 1, 3}, {1.5, 1, 2}, 4096},
                 {"mesh", "kept points", 90, {0.5, 0.4, 0.6}, {0.3, 0.2, 0.4}, 8192}};
  return made;
}

TEST(BenchReport, ReadsBackWhatItWrote) {
  const auto text = document::to_json(to_document(report()), 2);
  const auto tree = document::parse_json(text, "b.json");
  ASSERT_TRUE(tree.ok());
  const auto read = bench_report_from(*tree, "b.json");
  ASSERT_TRUE(read.ok()) << read.error().text();
  EXPECT_EQ(document::to_json(to_document(*read), 2), text);
  EXPECT_EQ(read->stages[1].per_cpu_s(), 180);
}

TEST(BenchReport, NamesTheFirstKeyThatIsWrong) {
  document::Node root = to_document(report());
  root.find("stages")->items()[1].find("cpu_s")->set("least", "fast");
  auto read = bench_report_from(root, "b.json");
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().code, Code::BadParameter);
  EXPECT_EQ(read.error().text().find("b.json: stages[1].cpu_s.least: wanted a number"), 0u) << read.error().text();
  read = bench_report_from(document::Node::map(), "b.json");
  ASSERT_FALSE(read.ok());
  EXPECT_NE(read.error().text().find("scanmill_bench"), std::string::npos);
}

TEST(BenchReport, BandOfRepeats) {
  const BenchBand band = band_of({3, 1, 2});
  EXPECT_EQ(band.median, 2);
  EXPECT_EQ(band.least, 1);
  EXPECT_EQ(band.greatest, 3);
}

TEST(BenchComparison, BelievesOnlyWhatLiesTenPercentBeyondTheBand) {
  const BenchReport then = report();
  BenchReport now = report();
  EXPECT_TRUE(compare(now, then).slowdowns.empty());
  EXPECT_TRUE(compare(now, then).notes.empty());
  now.stages[0].cpu_s = {9, 3.2, 10};  // a median thrice as high says nothing while the least is within
  EXPECT_TRUE(compare(now, then).slowdowns.empty());
  now.stages[0].cpu_s.least = 3.4;
  const auto found = compare(now, then).slowdowns;
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].find("bench.reduce: found at least 3.4000 CPU s"), 0u) << found[0];
  EXPECT_NE(bench_table(now, &then).find("3.0000] slower"), std::string::npos);
}

TEST(BenchComparison, NamesStagesOnOneSideAndOtherMachines) {
  BenchReport then = report(), now = report();
  then.stages.erase(then.stages.begin());
  now.stages.pop_back();
  then.processor = "other";
  then.threads = 1;
  const auto notes = compare(now, then).notes;
  ASSERT_EQ(notes.size(), 4u);
  EXPECT_EQ(notes[0], "the earlier bench ran on another machine: other, 2 cores");
  EXPECT_EQ(notes[1], "the earlier bench ran with 1 thread");
  EXPECT_EQ(notes[2], "mesh: in the earlier bench only");
  EXPECT_EQ(notes[3], "reduce: not in the earlier bench");
}

TEST(BenchComparison, RefusesAnotherInput) {
  BenchInput now = report().input;
  EXPECT_TRUE(check_same_input(now, report().input, "b.json").ok());
  now.bin_mm = 0.6;
  const auto refused = check_same_input(now, report().input, "b.json");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, Code::BadUsage);
  EXPECT_NE(refused.error().text().find("bins of 0.5 mm"), std::string::npos);
}

TEST(BenchStages, UnknownStageNamesTheNearest) {
  const ChunkLoop loop(1);
  const CancelFlag cancel;
  NoProgress quiet;
  BenchChoice choice;
  choice.stage = "reduc";
  const auto refused = bench_stages(choice, {}, {loop, cancel}, quiet);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, Code::BadUsage);
  EXPECT_NE(refused.error().message.find("nearest reduce"), std::string::npos);
}

}  // namespace
}  // namespace scanmill::pipeline
