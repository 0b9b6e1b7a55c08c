// SPDX-License-Identifier: Apache-2.0
#include "pipeline/scale_report.hpp"

#include <algorithm>

#include "base/text.hpp"

namespace scanmill::pipeline {

using document::Node;
using timing::fixed;

namespace {

constexpr double kLeastTime = 1e-3;
constexpr std::size_t kLinesShown = 5;

double rate(std::uint64_t amount, double seconds) {
  return static_cast<double>(amount) / std::max(seconds, kLeastTime);
}

/// 60,000,000 as "60 M".
std::string short_count(double value) {
  if (value >= 1e9) return fixed(value * 1e-9, 2) + " G";
  if (value >= 1e6) return fixed(value * 1e-6, 2) + " M";
  if (value >= 1e3) return fixed(value * 1e-3, 1) + " k";
  return fixed(value, 1);
}

Node row_of(const ScaleRun& run) {
  Node row = Node::map();
  row.set("points", run.points);
  row.set("bricks", run.bricks);
  row.set("threads", run.threads);
  row.set("bin_mm", run.bin_mm);
  row.set("bins", run.bins);
  row.set("kept", run.kept);
  row.set("triangles", run.triangles);
  row.set("cpu_s", run.cpu_s);
  row.set("wall_s", run.wall_s);
  row.set("points_per_cpu_s", run.points_per_cpu_s());
  row.set("kept_per_cpu_s", run.kept_per_cpu_s());
  row.set("peak_bytes", run.peak_bytes);
  row.set("peak_resident_bytes", run.peak_resident);
  row.set("stl_sha256", run.stl_sha256);
  if (!run.stages.empty()) {
    Node stages = Node::sequence();
    for (const BenchStage& stage : run.stages) stages.push(to_document(stage));
    row.set("stages", std::move(stages));
  }
  return row;
}

}  // namespace

double ScaleRun::points_per_cpu_s() const { return rate(points, cpu_s); }
double ScaleRun::kept_per_cpu_s() const { return rate(kept, cpu_s); }

std::string name_of(const ScaleRun& run) {
  return counted(run.points, "point") + " with " + counted(static_cast<std::uint64_t>(run.threads), "thread") +
         (run.bricks == 0 ? " in one piece" : " in bricks of " + std::to_string(run.bricks) + " bins");
}

Result<void> check_same_mesh(const ScaleReport& report, const ScaleRun& run) {
  for (const ScaleRun& earlier : report.runs)
    if (earlier.points == run.points && earlier.stl_sha256 != run.stl_sha256)
      return fail(Code::Internal,
                  "the run over " + name_of(earlier) + " and the run over " + name_of(run) +
                      " make STL files of different bytes (SHA-256 " + earlier.stl_sha256 + " and " + run.stl_sha256 +
                      "); they should be equal; please report this, with both output trees (--out, --keep)",
                  "mesh.stl");
  return {};
}

std::string failure_in(const std::string& said) {
  std::vector<std::string> told, plain;
  for (const std::string& line : lines_of(said)) {
    if (line.empty()) continue;
    const auto tree = document::parse_json(line, "line");
    const Node* type = tree ? tree->find("type") : nullptr;
    if (!type || !type->is_string()) {
      plain.push_back(line);
      continue;
    }
    const Node* error = tree->find("error");  // of a scan
    const Node* text = error ? error->find("text") : tree->find("text");
    if (text && text->is_string() && (error || type->as_string() == "error" || type->as_string() == "gate"))
      told.push_back(text->as_string());
  }
  if (told.empty() && plain.size() > kLinesShown) plain.erase(plain.begin(), plain.end() - kLinesShown);
  std::string sentence;
  for (const std::string& part : told.empty() ? plain : told) sentence += (sentence.empty() ? "" : "; ") + part;
  return sentence;
}

Node to_document(const ScaleReport& report) {
  Node machine = Node::map();
  machine.set("cores", report.cores);
  machine.set("model", report.processor);
  Node input = Node::map();
  input.set("seed", report.seed);
  input.set("per_bin", report.per_bin);
  input.set("files", report.as_views ? "views" : "one");
  Node made = Node::sequence();
  for (const ScaleMaking& cloud : report.made) {
    Node row = Node::map();
    row.set("points", cloud.points);
    row.set("bytes", cloud.bytes);
    row.set("cpu_s", cloud.cpu_s);
    row.set("wall_s", cloud.wall_s);
    row.set("points_per_cpu_s", rate(cloud.points, cloud.cpu_s));
    made.push(std::move(row));
  }
  Node runs = Node::sequence();
  for (const ScaleRun& run : report.runs) runs.push(row_of(run));
  Node root = Node::map();
  root.set("scanmill_scale", 1);
  root.set("version", report.version);
  root.set("machine", std::move(machine));
  root.set("memory", report.memory);
  root.set("input", std::move(input));
  root.set("made", std::move(made));
  root.set("runs", std::move(runs));
  return root;
}

std::string scale_table(const ScaleReport& report) {
  std::string text = "bumpy ball, seed " + std::to_string(report.seed) + ", " + number_text(report.per_bin) +
                     " points a bin; memory " + (report.memory.empty() ? "by default" : report.memory) + "; " +
                     counted(static_cast<std::uint64_t>(report.cores), "core") + ", " + report.processor + "\n\n";
  std::vector<std::vector<std::string>> rows{{"points", "bricks", "threads", "bins", "triangles", "CPU s", "wall s",
                                              "points per CPU s", "kept per CPU s", "peak", "with files"}};
  for (const ScaleRun& run : report.runs)
    rows.push_back({grouped(run.points), run.bricks == 0 ? "-" : std::to_string(run.bricks),
                    std::to_string(run.threads), grouped(run.bins), grouped(run.triangles), fixed(run.cpu_s, 2),
                    fixed(run.wall_s, 2), short_count(run.points_per_cpu_s()), short_count(run.kept_per_cpu_s()),
                    bytes_text(run.peak_bytes), bytes_text(run.peak_resident)});
  text += timing::aligned(rows);
  // Per stage: amount per CPU second, a column per run.
  rows.assign(1, {"stage, per CPU s"});
  for (const ScaleRun& run : report.runs) {
    rows.front().push_back(short_count(static_cast<double>(run.points)) + " x " + std::to_string(run.threads) +
                           (run.bricks == 0 ? "" : " / " + std::to_string(run.bricks)));
    for (const BenchStage& stage : run.stages) {
      const std::string name = stage.name + ", " + stage.unit;
      auto row = std::find_if(rows.begin() + 1, rows.end(), [&](const auto& r) { return r[0] == name; });
      if (row == rows.end()) row = rows.insert(rows.end(), {name});
      row->resize(rows.front().size() - 1, "-");
      row->push_back(stage.cpu_s.median < kLeastTime ? "-" : short_count(rate(stage.amount, stage.cpu_s.median)));
    }
  }
  if (rows.size() == 1) return text;  // bricks in all runs
  for (auto& row : rows) row.resize(rows.front().size(), "-");
  return text + "\n\n" + timing::aligned(rows);
}

}  // namespace scanmill::pipeline
