// SPDX-License-Identifier: Apache-2.0
// The schema files, our own checker and an independent validator (python3-jsonschema) must agree.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "cli/pipeline_work.hpp"
#include "cli/schemas.hpp"
#include "pipeline/bench_report.hpp"
#include "plan/plan.hpp"
#include "runner/bench_job.hpp"
#include "runner/job.hpp"
#include "runner/run_report.hpp"
#include "runner/task_file.hpp"
#include "runner/task_result.hpp"

namespace scanmill {
namespace {

const std::string kSchemas = SCANMILL_SOURCE "/schemas/";

std::string slurp(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// The verdict of jsonschema: 0 valid, 1 invalid, anything else: no verdict.
int judge(const std::string& schema, const document::Node& instance) {
  const std::string path = testing::TempDir() + "scanmill-instance-" + std::to_string(getpid()) + ".json";
  std::ofstream(path) << document::to_json(instance);
  const std::string program =
      "import json,sys,jsonschema as j;s=json.load(open(sys.argv[1]));j.Draft7Validator.check_schema(s);"
      "e=list(j.Draft7Validator(s).iter_errors(json.load(open(sys.argv[2]))));print(*[x.message for x in "
      "e],sep=chr(10));sys.exit(1 if e else 0)";
  const int status =
      std::system((std::string(PYTHON3) + " -c '" + program + "' '" + kSchemas + schema + "' '" + path + "'").c_str());
  unlink(path.c_str());
  return WEXITSTATUS(status);
}

document::Node example(const std::string& name) {
  auto tree = document::parse_yaml(slurp(kSchemas + "examples/" + name), name);
  EXPECT_TRUE(tree.ok()) << (tree ? "" : tree.error().text());
  return tree ? *tree : document::Node();
}

Result<runner::Job> checked(const std::string& name) {
  const cli::PipelineWork work;
  return runner::job_from(slurp(kSchemas + "examples/" + name), name, {}, work);
}

TEST(ReplaySchema, TellsTheExamplesApart) {
  EXPECT_EQ(judge("replay.schema.json", example("replay.valid.json")), 0);
  EXPECT_EQ(judge("replay.schema.json", example("replay.invalid.json")), 1);
}

TEST(RefinementAndTruthSchemas, TellTheExamplesApart) {
  for (const std::string name : {"refinement", "truth"}) {
    EXPECT_EQ(judge(name + ".schema.json", example(name + ".valid.json")), 0) << name;
    EXPECT_EQ(judge(name + ".schema.json", example(name + ".invalid.json")), 1) << name;
  }
}

TEST(PlanSchema, TakesTheMachinesOfJobs) {
  for (const char* name : {"bradley", "turntable", "gantry", "fixed"}) {
    const std::string path = SCANMILL_SOURCE "/jobs/machines/" + std::string(name) + ".yaml";
    const auto tree = document::parse_yaml(slurp(path), path);
    ASSERT_TRUE(tree.ok()) << tree.error().text();
    EXPECT_EQ(judge("plan.schema.json", *tree), 0) << name;
    const auto plan = plan::plan_from(*tree, path);
    ASSERT_TRUE(plan.ok()) << plan.error().text();
    EXPECT_EQ(judge("plan.schema.json", plan::to_document(*plan)), 0) << name;
    document::Node wrong = *tree;
    wrong.find("machine")->set("joint", 1);
    EXPECT_EQ(judge("plan.schema.json", wrong), 1) << name;
  }
}

TEST(JobSchema, FileIsWhatTheTablesSay) {
  EXPECT_EQ(slurp(kSchemas + "job.schema.json"),
            document::to_json(runner::job_schema(pipeline::what_schema()), 2) + "\n")
      << "write it again: scanmill schema job > schemas/job.schema.json";
}

TEST(JobSchema, ValidExamplePassesBothCheckers) {
  EXPECT_EQ(judge("job.schema.json", example("job.valid.yaml")), 0);
  const auto job = checked("job.valid.yaml");
  ASSERT_TRUE(job.ok()) << job.error().text();
  const cli::PipelineWork work;
  for (const char* scan : {"figurine", "handset"}) {
    const auto what = work.resolve(runner::what_of(*job, scan, work), "job.valid.yaml");
    EXPECT_TRUE(what.ok()) << what.error().text();
  }
}

TEST(RunnerSchemas, AgreeWithTheirExamples) {
  for (const std::string name : {"journal", "worklist", "tasks", "result", "quarantine"}) {
    EXPECT_EQ(judge(name + ".schema.json", example(name + ".valid.json")), 0) << name;
    EXPECT_EQ(judge(name + ".schema.json", example(name + ".invalid.json")), 1) << name;
  }
}

TEST(TasksSchema, OurOwnReaderAndWriterAgreeWithIt) {
  const auto file = runner::task_file_from(example("tasks.valid.json"), "tasks.valid.json");
  ASSERT_TRUE(file.ok()) << file.error().text();
  ASSERT_EQ(file->tasks.size(), 2u);
  EXPECT_EQ(file->tasks[0].items[1].scan, "handset");
  EXPECT_EQ(judge("tasks.schema.json", runner::to_document(*file)), 0);
  EXPECT_TRUE(document::same_values(runner::to_document(*file), example("tasks.valid.json")));
  const auto wrong = runner::task_file_from(example("tasks.invalid.json"), "tasks.invalid.json");
  ASSERT_FALSE(wrong.ok());
  EXPECT_NE(wrong.error().text().find("tasks[0].kind: found 'dreams'"), std::string::npos) << wrong.error().text();
}

TEST(ResultSchema, OurOwnReaderAndWriterAgreeWithIt) {
  const auto death = runner::task_result_from(example("result.valid.json"));
  ASSERT_TRUE(death.ok()) << death.error().text();
  EXPECT_EQ(death->ended.death, "signal 11 (Segmentation fault)");
  EXPECT_TRUE(document::same_values(runner::to_document(*death), example("result.valid.json")));
  EXPECT_FALSE(runner::task_result_from(example("result.invalid.json")).ok());
  runner::TaskResult result = *death;
  runner::Attempt attempt;
  attempt.entry.name = "figurine";
  attempt.entry.counts = document::Node::map();
  result.ended.attempt = attempt;
  EXPECT_EQ(judge("result.schema.json", runner::to_document(result)), 0);
}

TEST(JobSchema, InvalidExampleFailsInBothWithEveryMistake) {
  EXPECT_EQ(judge("job.schema.json", example("job.invalid.yaml")), 1);
  const auto job = checked("job.invalid.yaml");
  ASSERT_FALSE(job.ok());
  const std::string text = job.error().text();
  for (const char* key : {":2:11: scanmill:", ":3:10: archive:", ":5:3: lattice.bin_m:",
                          ":7:19: reduce.representative:", ":9:15: grow.range_bins:", ":10:11: outputs:",
                          ":12:5: overrides:", ":14:12: resources.threads:", ":16:10: notify.on:"})
    EXPECT_NE(text.find(key), std::string::npos) << key << "\n" << text;
}

TEST(RunSchema, ExamplesAndOurOwnReportsAreJudgedRight) {
  EXPECT_EQ(judge("run.schema.json", example("run.valid.json")), 0);
  EXPECT_EQ(judge("run.schema.json", example("run.invalid.json")), 1);
  runner::RunReport report;
  report.version = "1";
  report.libraries = document::Node::map();
  report.pid = 1;
  report.started = "2026-01-31T08:15:00Z";
  for (int fate = 0; fate <= static_cast<int>(runner::ScanFate::Vanished); ++fate) {
    runner::ScanEntry entry;
    entry.name = "s";
    entry.fate = static_cast<runner::ScanFate>(fate);
    entry.error = fail(Code::BadInput, "found x", "file");
    entry.counts = document::Node::map();
    entry.counts.set("triangles", 3);
    entry.record_identity = "abc";
    report.scans.push_back(entry);
  }
  EXPECT_EQ(judge("run.schema.json", runner::to_document(report)), 0);
  report.ended = report.started;
  report.exit_code = 143;
  EXPECT_EQ(judge("run.schema.json", runner::to_document(report)), 0);
}

TEST(StreamSchema, ExamplesAreJudgedRight) {
  EXPECT_EQ(judge("stream.schema.json", example("stream.valid.json")), 0);
  EXPECT_EQ(judge("stream.schema.json", example("stream.invalid.json")), 1);
}

TEST(BenchSchema, ExamplesAndOurOwnReportsAreJudgedRight) {
  EXPECT_EQ(judge("bench.schema.json", example("bench.valid.json")), 0);
  EXPECT_EQ(judge("bench.schema.json", example("bench.invalid.json")), 1);
  const auto read = pipeline::bench_report_from(example("bench.valid.json"), "bench.valid.json");
  ASSERT_TRUE(read.ok()) << read.error().text();
  EXPECT_EQ(judge("bench.schema.json", pipeline::to_document(*read)), 0);
  EXPECT_FALSE(pipeline::bench_report_from(example("bench.invalid.json"), "bench.invalid.json").ok());
}

TEST(ScaleSchema, TellsTheExamplesApart) {
  EXPECT_EQ(judge("scale.schema.json", example("scale.valid.json")), 0);
  EXPECT_EQ(judge("scale.schema.json", example("scale.invalid.json")), 1);
}

TEST(ThroughputSchema, ExamplesAndOurOwnReportsAreJudgedRight) {
  EXPECT_EQ(judge("throughput.schema.json", example("throughput.valid.json")), 0);
  EXPECT_EQ(judge("throughput.schema.json", example("throughput.invalid.json")), 1);
  const auto read = runner::job_bench_from(example("throughput.valid.json"), "throughput.valid.json");
  ASSERT_TRUE(read.ok()) << read.error().text();
  EXPECT_EQ(judge("throughput.schema.json", runner::to_document(*read)), 0);
  EXPECT_EQ(document::to_canonical_json(runner::to_document(*read)),
            document::to_canonical_json(example("throughput.valid.json")));
  EXPECT_FALSE(runner::job_bench_from(example("throughput.invalid.json"), "throughput.invalid.json").ok());
  EXPECT_FALSE(runner::job_bench_from(example("bench.valid.json"), "bench.valid.json").ok());
}

TEST(Schemas, AreInsideTheProgramAsTheyStandInTheSource) {
  for (const std::string_view name : cli::schema_names()) {
    const auto text = cli::schema_text(std::string(name));
    ASSERT_TRUE(text.ok());
    EXPECT_EQ(*text, slurp(kSchemas + std::string(name) + ".schema.json"));
  }
  const auto unknown = cli::schema_text("strem");
  ASSERT_FALSE(unknown.ok());
  EXPECT_NE(unknown.error().message.find("nearest stream"), std::string::npos);
}

}  // namespace
}  // namespace scanmill
