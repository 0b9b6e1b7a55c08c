// SPDX-License-Identifier: Apache-2.0
#include "pipeline/bench_report.hpp"

#include <algorithm>

#include "base/text.hpp"

namespace scanmill::pipeline {

using document::Node;
using timing::band_text;
using timing::fixed;
using timing::Keys;

namespace {

constexpr double kClockStep = 1e-6;  // of getrusage: no stage takes less

std::string rate_text(double rate) {
  if (rate >= 1e6) return fixed(rate * 1e-6, 2) + " M";
  if (rate >= 1e3) return fixed(rate * 1e-3, 1) + " k";
  return fixed(rate, 1);
}

BenchStage stage_from(const Keys& keys) {
  BenchStage stage;
  keys.read("name", stage.name);
  keys.read("unit", stage.unit);
  keys.read_whole("amount", stage.amount);
  keys.read("cpu_s", stage.cpu_s);
  keys.read("wall_s", stage.wall_s);
  keys.read_whole("peak_bytes", stage.peak_bytes);
  return stage;
}

}  // namespace

double BenchStage::per_cpu_s() const { return static_cast<double>(amount) / std::max(cpu_s.median, kClockStep); }

Node to_document(const BenchStage& stage) {
  Node row = Node::map();
  row.set("name", stage.name);
  row.set("unit", stage.unit);
  row.set("amount", stage.amount);
  row.set("cpu_s", timing::to_document(stage.cpu_s));
  row.set("wall_s", timing::to_document(stage.wall_s));
  row.set("per_cpu_s", stage.per_cpu_s());
  row.set("peak_bytes", stage.peak_bytes);
  return row;
}

Node to_document(const BenchReport& report) {
  Node machine = Node::map();
  machine.set("cores", report.cores);
  machine.set("model", report.processor);
  Node input = Node::map();
  input.set("name", report.input.name);
  input.set("profile", report.input.profile);
  input.set("bin_mm", report.input.bin_mm);
  input.set("points", report.input.points);
  input.set("bins", report.input.bins);
  input.set("kept", report.input.kept);
  input.set("triangles", report.input.triangles);
  Node stages = Node::sequence();
  for (const BenchStage& stage : report.stages) stages.push(to_document(stage));
  Node root = Node::map();
  root.set("scanmill_bench", 1);
  root.set("version", report.version);
  root.set("machine", std::move(machine));
  root.set("threads", report.threads);
  root.set("repeats", report.repeats);
  root.set("input", std::move(input));
  root.set("stages", std::move(stages));
  return root;
}

Result<BenchReport> bench_report_from(const Node& root, const std::string& name) {
  const Node* mark = root.find("scanmill_bench");
  if (!mark || !mark->is_integer() || mark->as_integer() != 1)
    return fail(Code::BadParameter,
                "found no \"scanmill_bench\": 1; wanted a document that `scanmill bench --out` wrote", name);
  BenchReport report;
  std::string problem;
  const Keys keys(&root, "", problem);
  keys.read("version", report.version);
  keys.map("machine").read_whole("cores", report.cores);
  keys.map("machine").read("model", report.processor);
  keys.read_whole("threads", report.threads);
  keys.read_whole("repeats", report.repeats);
  const Keys input = keys.map("input");
  input.read("name", report.input.name);
  input.read("profile", report.input.profile);
  input.read("bin_mm", report.input.bin_mm);
  input.read_whole("points", report.input.points);
  input.read_whole("bins", report.input.bins);
  input.read_whole("kept", report.input.kept);
  input.read_whole("triangles", report.input.triangles);
  if (problem.empty())
    for (const Keys& stage : keys.list("stages")) report.stages.push_back(stage_from(stage));
  if (!problem.empty()) return fail(Code::BadParameter, problem + "; measure again with `scanmill bench --out`", name);
  return report;
}

bool is_slower(const BenchStage& now, const BenchStage& then) {
  return now.cpu_s.least > kSlower * then.cpu_s.greatest;
}

Result<void> check_same_input(const BenchInput& now, const BenchInput& then, const std::string& name) {
  const auto told = [](const BenchInput& input) {
    return counted(input.points, "point") + " with bins of " + number_text(input.bin_mm) + " mm, profile " +
           input.profile;
  };
  if (now.points == then.points && now.bin_mm == then.bin_mm && now.profile == then.profile) return {};
  return fail(Code::BadUsage,
              "was measured on " + told(then) + ", this bench on " + told(now) +
                  "; give the same --file, --bin-mm and --profile, or measure both again",
              name);
}

const BenchStage* stage_named(const BenchReport& report, const std::string& name) {
  for (const BenchStage& stage : report.stages)
    if (stage.name == name) return &stage;
  return nullptr;
}

BenchComparison compare(const BenchReport& now, const BenchReport& then) {
  BenchComparison found;
  if (now.processor != then.processor || now.cores != then.cores)
    found.notes.push_back("the earlier bench ran on another machine: " + then.processor + ", " +
                          counted(static_cast<std::uint64_t>(then.cores), "core"));
  if (now.threads != then.threads)
    found.notes.push_back("the earlier bench ran with " + counted(static_cast<std::uint64_t>(then.threads), "thread"));
  for (const BenchStage& stage : then.stages)
    if (!stage_named(now, stage.name)) found.notes.push_back(stage.name + ": in the earlier bench only");
  for (const BenchStage& stage : now.stages) {
    const BenchStage* earlier = stage_named(then, stage.name);
    if (!earlier)
      found.notes.push_back(stage.name + ": not in the earlier bench");
    else if (is_slower(stage, *earlier))
      found.slowdowns.push_back("bench." + stage.name + ": found at least " + fixed(stage.cpu_s.least, 4) +
                                " CPU s, confirmed by a second round; allowed 1.1 times the " +
                                fixed(earlier->cpu_s.greatest, 4) + " CPU s of version " + then.version);
  }
  return found;
}

std::string bench_table(const BenchReport& report, const BenchReport* then) {
  const BenchInput& in = report.input;
  std::string text = (in.name.empty() ? "made for this bench: sphere along scan lines" : in.name) + ", " +
                     counted(in.points, "point") + ", bins of " + number_text(in.bin_mm) +
                     " mm: " + counted(in.bins, "bin") + ", " + grouped(in.kept) + " kept";
  if (in.triangles > 0) text += ", " + counted(in.triangles, "triangle");
  text += "\n" + counted(static_cast<std::uint64_t>(report.threads), "thread") + ", " +
          counted(static_cast<std::uint64_t>(report.cores), "core") + ", " + report.processor + "; median [least, " +
          "greatest] of " + counted(static_cast<std::uint64_t>(report.repeats), "repeat") + "\n\n";
  using Row = std::vector<std::string>;
  std::vector<Row> rows{{"stage", "amount", "CPU s", "wall s", "per CPU s", "peak"}};
  if (then) rows.front().push_back("CPU s before");
  for (const BenchStage& stage : report.stages) {
    Row row{stage.name,
            grouped(stage.amount) + " " + stage.unit,
            band_text(stage.cpu_s),
            band_text(stage.wall_s),
            rate_text(stage.per_cpu_s()),
            bytes_text(stage.peak_bytes)};
    if (then) {
      const BenchStage* earlier = stage_named(*then, stage.name);
      row.push_back(!earlier ? "-" : band_text(earlier->cpu_s) + (is_slower(stage, *earlier) ? " slower" : ""));
    }
    rows.push_back(std::move(row));
  }
  text += timing::aligned(rows);
  return text;
}

}  // namespace scanmill::pipeline
