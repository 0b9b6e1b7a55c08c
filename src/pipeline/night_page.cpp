// SPDX-License-Identifier: Apache-2.0
#include "pipeline/night_page.hpp"

#include <algorithm>

#include "report/night_report.hpp"

namespace scanmill::pipeline {

using document::Node;

namespace {

constexpr std::string_view kStates[] = {"pending", "unchanged",   "done",        "failed",
                                        "stale",   "quarantined", "interrupted", "vanished"};

std::string text_of(const Node* map, const char* key) {
  const Node* value = map ? map->find(key) : nullptr;
  return value && value->is_string() ? value->as_string() : std::string();
}

std::vector<std::string> texts_of(const Node& map, const char* key) {
  std::vector<std::string> texts;
  if (const Node* list = map.find(key); list && list->is_sequence())
    for (const Node& item : list->items())
      if (item.is_string()) texts.push_back(item.as_string());
  return texts;
}

std::optional<double> number_of(const Node* map, const char* key) {
  const Node* value = map ? map->find(key) : nullptr;
  return value && value->is_number() ? std::optional(value->as_number()) : std::nullopt;
}

std::optional<std::uint64_t> count_of(const Node* map, const char* key) {
  const Node* value = map ? map->find(key) : nullptr;
  return value && value->is_integer() && value->as_integer() >= 0
             ? std::optional(static_cast<std::uint64_t>(value->as_integer()))
             : std::nullopt;
}

report::NightScan scan_of(const Node& node) {
  report::NightScan scan;
  scan.name = text_of(&node, "name");
  const auto state = std::find(std::begin(kStates), std::end(kStates), text_of(&node, "state"));
  if (state != std::end(kStates)) scan.state = static_cast<report::NightState>(state - std::begin(kStates));
  const Node* is_new = node.find("new");
  scan.is_new = is_new && is_new->is_bool() && is_new->as_bool();
  scan.why = texts_of(node, "why");
  scan.failed_gates = texts_of(node, "failed_gates");
  const Node* error = node.find("error");
  scan.failure = text_of(error, "class");
  if (scan.failure == "none") scan.failure.clear();
  scan.stage = text_of(error, "stage");
  scan.error = text_of(error, "text");
  scan.repeat = text_of(error, "repeat");
  scan.advice = text_of(&node, "advice");
  const Node* counts = node.find("counts");
  scan.max_error_mm = number_of(counts, "max_error_mm");
  scan.rms_mm = number_of(counts, "rms_mm");
  scan.points = count_of(counts, "points_read");
  scan.triangles = count_of(counts, "triangles");
  scan.loops = count_of(counts, "boundary_loops");
  scan.seconds = number_of(&node, "seconds").value_or(0);
  scan.cpu_seconds = number_of(&node, "cpu_seconds").value_or(0);
  scan.peak_bytes = count_of(&node, "peak_memory_bytes").value_or(0);
  for (const std::string& file : texts_of(node, "files")) {
    if (file.ends_with("/report.html")) scan.page = file;
    if (file.ends_with("/preview-error.png")) scan.error_picture = file;
    if (file.ends_with("/preview-shaded.png")) scan.picture = file;
  }
  if (count_of(&node, "attempts").value_or(0) > 0) scan.log = "logs/" + scan.name + ".log";
  return scan;
}

report::NightWorse worse_of(const Node& node) {
  report::NightWorse worse{text_of(&node, "name"), {}, texts_of(node, "new_gates")};
  if (const Node* figures = node.find("figures"); figures && figures->is_sequence())
    for (const Node& figure : figures->items())
      worse.figures.push_back({text_of(&figure, "name"), text_of(&figure, "unit"),
                               number_of(&figure, "then").value_or(0), number_of(&figure, "now").value_or(0)});
  return worse;
}

void add_stages(const Node& scan, std::vector<std::pair<std::string, double>>& sums) {
  const Node* stages = scan.find("stage_seconds");
  if (!stages || !stages->is_map()) return;
  for (const Node::Entry& stage : stages->entries()) {
    if (!stage.value.is_number()) continue;
    const auto at = std::find_if(sums.begin(), sums.end(), [&](const auto& sum) { return sum.first == stage.key; });
    if (at == sums.end())
      sums.emplace_back(stage.key, stage.value.as_number());
    else
      at->second += stage.value.as_number();
  }
}

}  // namespace

std::string night_page(const Node& night, std::size_t scans, const std::function<Node(std::size_t)>& scan_at) {
  report::NightReport report;
  const Node* job = night.find("job");
  const std::string path = text_of(job, "path");
  report.job = path.substr(path.rfind('/') + 1);
  report.archive = text_of(job, "archive");
  report.host = text_of(&night, "host");
  report.tool = "scanmill " + text_of(&night, "version");
  report.started = text_of(&night, "started");
  report.ended = text_of(&night, "ended");
  report.verdict = text_of(&night, "verdict");
  report.compared_with = text_of(&night, "compared_with");
  report.exit_code = static_cast<int>(count_of(&night, "exit").value_or(0));
  report.threads = static_cast<int>(count_of(&night, "threads").value_or(0));
  report.memory_cap = count_of(&night, "memory_cap_bytes").value_or(0);
  report.seconds = number_of(&night, "seconds").value_or(0);
  report.notes = texts_of(night, "notes");
  report.scans.reserve(scans);
  for (std::size_t k = 0; k < scans; ++k) {
    const Node scan = scan_at(k);
    report.scans.push_back(scan_of(scan));
    if (report.scans.back().state == report::NightState::Done) add_stages(scan, report.stage_seconds);
  }
  if (const Node* worse = night.find("worse"); worse && worse->is_sequence())
    for (const Node& row : worse->items()) report.worse.push_back(worse_of(row));
  return report::night_page(report);
}

}  // namespace scanmill::pipeline
