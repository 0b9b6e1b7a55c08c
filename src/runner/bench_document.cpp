// SPDX-License-Identifier: Apache-2.0
// The bench of a job as a document and back.
#include "runner/bench_job.hpp"

namespace scanmill::runner {

using document::Node;

Node to_document(const JobBench& bench) {
  Node machine = Node::map();
  machine.set("cores", bench.cores);
  machine.set("model", bench.processor);
  Node input = Node::map();
  input.set("job", bench.job);
  input.set("scans", bench.scans);
  input.set("points", bench.points);
  input.set("bins", bench.bins);
  Node runs = Node::sequence();
  for (const JobTiming& run : bench.runs) {
    Node stages = Node::sequence();
    for (const auto& [name, wall] : run.stages) {
      Node stage = Node::map();
      stage.set("name", name);
      stage.set("wall_s", timing::to_document(wall));
      stages.push(std::move(stage));
    }
    Node row = Node::map();
    row.set("threads", run.threads);
    row.set("scans_per_hour", run.scans_per_hour(bench.scans));
    row.set("cpu_s", timing::to_document(run.cpu_s));
    row.set("yardsticks", timing::to_document(run.yardsticks));
    row.set("wall_s", timing::to_document(run.wall_s));
    row.set("peak_bytes", run.peak_bytes);
    row.set("stages", std::move(stages));
    runs.push(std::move(row));
  }
  Node root = Node::map();
  root.set("scanmill_throughput", 1);
  root.set("version", bench.version);
  root.set("machine", std::move(machine));
  root.set("repeats", bench.repeats);
  root.set("input", std::move(input));
  root.set("yardstick_s", timing::to_document(bench.yardstick_s));
  root.set("runs", std::move(runs));
  return root;
}

Result<JobBench> job_bench_from(const Node& root, const std::string& name) {
  const Node* mark = root.find("scanmill_throughput");
  if (!mark || !mark->is_integer() || mark->as_integer() != 1)
    return fail(Code::BadParameter,
                "found no \"scanmill_throughput\": 1; wanted a document that `scanmill bench JOB --out` wrote", name);
  JobBench bench;
  std::string problem;
  const timing::Keys keys(&root, "", problem);
  keys.read("version", bench.version);
  keys.map("machine").read_whole("cores", bench.cores);
  keys.map("machine").read("model", bench.processor);
  keys.read_whole("repeats", bench.repeats);
  const timing::Keys input = keys.map("input");
  input.read("job", bench.job);
  input.read_whole("scans", bench.scans);
  input.read_whole("points", bench.points);
  input.read_whole("bins", bench.bins);
  keys.read("yardstick_s", bench.yardstick_s);
  for (const timing::Keys& row : keys.list("runs")) {
    JobTiming run;
    row.read_whole("threads", run.threads);
    row.read("cpu_s", run.cpu_s);
    row.read("yardsticks", run.yardsticks);
    row.read("wall_s", run.wall_s);
    row.read_whole("peak_bytes", run.peak_bytes);
    for (const timing::Keys& stage : row.list("stages")) {
      run.stages.emplace_back();
      stage.read("name", run.stages.back().first);
      stage.read("wall_s", run.stages.back().second);
    }
    bench.runs.push_back(std::move(run));
  }
  if (!problem.empty())
    return fail(Code::BadParameter, problem + "; measure again with `scanmill bench JOB --out`", name);
  return bench;
}

}  // namespace scanmill::runner
