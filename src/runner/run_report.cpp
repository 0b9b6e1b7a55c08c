// SPDX-License-Identifier: Apache-2.0
#include "runner/run_report.hpp"

#include <algorithm>

#include "runner/machine.hpp"

namespace scanmill::runner {

using document::Node;

const char* name_of(ScanFate fate) {
  static constexpr const char* kNames[] = {"pending", "unchanged",   "done",        "failed",
                                           "stale",   "quarantined", "interrupted", "vanished"};
  return kNames[static_cast<std::size_t>(fate)];
}

const char* name_of(FailureClass failure) {
  static constexpr const char* kNames[] = {"none", "bad_input", "resource", "transient", "cancelled", "internal"};
  return kNames[static_cast<std::size_t>(failure)];
}

FailureClass class_of(const Error& error) {
  switch (error.code) {
    case Code::BadInput:
    case Code::BadParameter:
    case Code::BadUsage:
    case Code::Unsupported:
      return FailureClass::BadInput;
    case Code::NoSpace:
      return error.where == "memory" || error.where == "disk" ? FailureClass::Resource : FailureClass::Transient;
    case Code::IoFailed:
      return FailureClass::Transient;
    case Code::Cancelled:
      return FailureClass::Cancelled;
    default:
      return FailureClass::Internal;
  }
}

std::uint64_t RunReport::count(ScanFate fate) const {
  return static_cast<std::uint64_t>(
      std::count_if(scans.begin(), scans.end(), [&](const ScanEntry& entry) { return entry.fate == fate; }));
}

std::uint64_t RunReport::rejected() const {
  return static_cast<std::uint64_t>(
      std::count_if(scans.begin(), scans.end(), [](const ScanEntry& entry) { return !entry.failed_gates.empty(); }));
}

namespace {

Node stages_node(const std::vector<std::pair<std::string, double>>& stages) {
  Node node = Node::map();
  for (const auto& [stage, seconds] : stages) node.set(stage, seconds);
  return node;
}

void read_stages(const Node* node, std::vector<std::pair<std::string, double>>& stages) {
  if (!node || !node->is_map()) return;
  for (const Node::Entry& stage : node->entries())
    if (stage.value.is_number()) stages.emplace_back(stage.key, stage.value.as_number());
}

Node texts(const std::vector<std::string>& list) {
  Node node = Node::sequence();
  for (const std::string& text : list) node.push(text);
  return node;
}

std::string folder_of(const ScanEntry& entry) { return "scans/" + entry.name + "/"; }

}  // namespace

std::vector<std::string> paths_of(const ScanEntry& entry) {
  std::vector<std::string> paths;
  paths.reserve(entry.files.size());
  for (const Word& file : entry.files) paths.push_back(folder_of(entry) + file.text());
  return paths;
}

Node to_document(const ScanEntry& entry) {
  Node node = Node::map();
  node.set("name", entry.name);
  node.set("state", name_of(entry.fate));
  node.set("why", texts(entry.why));
  if (!entry.error.message.empty()) {
    Node error = Node::map();
    error.set("code", scanmill::name_of(entry.error.code));
    error.set("text", entry.error.text());
    error.set("class", name_of(entry.failure));
    if (!entry.failed_stage.empty()) error.set("stage", entry.failed_stage);
    error.set("repeat", entry.repeat);
    node.set("error", std::move(error));
  }
  node.set("notes", texts(entry.notes));
  if (!entry.failed_gates.empty()) {
    node.set("rejected", true);
    node.set("failed_gates", texts(entry.failed_gates));
  }
  node.set("files", texts(paths_of(entry)));
  if (!entry.record_identity.empty()) node.set("record", entry.record_identity);
  if (entry.counts.is_known()) node.set("counts", entry.counts.document());
  if (entry.attempts > 0) node.set("attempts", entry.attempts);
  if (!entry.started.empty()) {  // without an attempt: parts of it were made
    node.set("started", entry.started);
    node.set("ended", entry.ended);
  }
  node.set("seconds", entry.seconds);
  node.set("cpu_seconds", entry.cpu_seconds);
  node.set("stage_seconds", stages_node(entry.stage_seconds));
  node.set("stage_cpu_seconds", stages_node(entry.stage_cpu_seconds));
  node.set("peak_memory_bytes", entry.peak_memory);
  return node;
}

namespace {

/// Values of a map, with a default where they are not there or of another kind.
std::string text_in(const Node& map, std::string_view key) {
  const Node* value = map.find(key);
  return value && value->is_string() ? value->as_string() : std::string();
}
double number_in(const Node& map, std::string_view key) {
  const Node* value = map.find(key);
  return value && value->is_number() ? value->as_number() : 0;
}
std::vector<std::string> texts_in(const Node& map, std::string_view key) {
  std::vector<std::string> list;
  if (const Node* value = map.find(key); value && value->is_sequence())
    for (const Node& item : value->items())
      if (item.is_string()) list.push_back(item.as_string());
  return list;
}

/// The enumerator whose name this is, or the first.
template <class Enum>
Enum named(const std::string& name, Enum last) {
  for (int i = 0; i <= static_cast<int>(last); ++i)
    if (name == name_of(static_cast<Enum>(i))) return static_cast<Enum>(i);
  return static_cast<Enum>(0);
}

}  // namespace

FailureClass failure_named(const std::string& name) { return named(name, FailureClass::Internal); }

Result<ScanEntry> entry_from(const Node& tree) {
  ScanEntry entry;
  entry.name = text_in(tree, "name");
  if (entry.name.empty()) return fail(Code::Internal, "found a scan without a name");
  entry.fate = named(text_in(tree, "state"), ScanFate::Vanished);
  entry.why = texts_in(tree, "why");
  entry.notes = texts_in(tree, "notes");
  entry.failed_gates = texts_in(tree, "failed_gates");
  const std::string folder = folder_of(entry);
  for (const std::string& file : texts_in(tree, "files"))
    if (file.starts_with(folder)) entry.files.emplace_back(std::string_view(file).substr(folder.size()));
  entry.record_identity = text_in(tree, "record");
  if (const Node* counts = tree.find("counts")) entry.counts = *counts;
  if (const Node* error = tree.find("error")) {
    entry.error = {named(text_in(*error, "code"), Code::Internal), text_in(*error, "text"), {}};
    entry.failure = failure_named(text_in(*error, "class"));
    entry.failed_stage = text_in(*error, "stage");
    entry.repeat = text_in(*error, "repeat");
  }
  entry.attempts = static_cast<int>(number_in(tree, "attempts"));
  entry.started = text_in(tree, "started");
  entry.ended = text_in(tree, "ended");
  entry.seconds = number_in(tree, "seconds");
  entry.cpu_seconds = number_in(tree, "cpu_seconds");
  entry.peak_memory = static_cast<std::uint64_t>(number_in(tree, "peak_memory_bytes"));
  read_stages(tree.find("stage_seconds"), entry.stage_seconds);
  read_stages(tree.find("stage_cpu_seconds"), entry.stage_cpu_seconds);
  return entry;
}

namespace {

std::uint64_t in_this_run(const RunReport& report) { return report.scans.size() - report.count(ScanFate::Vanished); }

/// In need of work, and left for the next run. A dry run makes nothing anyway.
std::uint64_t not_made(const RunReport& report) {
  return report.dry_run ? 0 : report.count(ScanFate::Pending) + report.count(ScanFate::Interrupted);
}

}  // namespace

Node head_of(const RunReport& report) {
  Node node = Node::map();
  node.set("scanmill_run", 1);
  node.set("version", report.version);
  node.set("libraries", report.libraries);
  node.set("host", report.host);
  node.set("pid", report.pid);
  node.set("started", report.started);
  node.set("ended", report.ended.empty() ? Node() : Node(report.ended));
  node.set("seconds", report.seconds);
  node.set("exit", report.exit_code < 0 ? Node() : Node(report.exit_code));
  node.set("threads", report.threads);
  node.set("memory_cap_bytes", report.memory_cap);
  Node job = Node::map();
  job.set("path", report.job_path);
  job.set("absolute", report.job_absolute);
  job.set("archive", report.archive);
  if (!report.archive_absolute.empty()) job.set("archive_absolute", report.archive_absolute);
  job.set("set", texts(report.sets));
  job.set("only", texts(report.only));
  job.set("text", report.job_text);
  node.set("job", std::move(job));
  node.set("notes", texts(report.notes));
  return node;
}

Node to_document(const RunReport& report) {
  Node node = head_of(report);
  Node scans = Node::sequence();
  for (const ScanEntry& entry : report.scans) scans.push(to_document(entry));
  node.set("scans", std::move(scans));
  return node;
}

Result<void> write_run(const RunReport& report, ByteSink& sink) {
  constexpr std::size_t kPiece = 1 << 16;  // bytes written at once
  std::string text = document::to_json(head_of(report), 1);
  text.resize(text.size() - 2);  // "\n}"
  text += ",\n \"scans\": [";
  const char* before = "\n  ";
  for (const ScanEntry& entry : report.scans) {
    text += before;
    for (const char c : document::to_json(to_document(entry), 1)) {
      text += c;
      if (c == '\n') text += "  ";  // it stands two levels down; no string holds a line feed as it is
    }
    before = ",\n  ";
    if (text.size() < kPiece) continue;
    TRY(sink.write(std::string_view(text)));
    text.clear();
  }
  text += report.scans.empty() ? "]\n}\n" : "\n ]\n}\n";
  return sink.write(std::string_view(text));
}

std::string last_line(const RunReport& report) {
  const auto number = [&](ScanFate fate) { return std::to_string(report.count(fate)); };
  const auto some = [](std::uint64_t count, const char* word) {
    return count > 0 ? ", " + std::to_string(count) + " " + word : std::string();
  };
  const std::uint64_t scans = in_this_run(report);
  return std::to_string(scans) + (scans == 1 ? " scan: " : " scans: ") + number(ScanFate::Unchanged) + " unchanged, " +
         number(ScanFate::Done) + " done, " +
         std::to_string(report.count(ScanFate::Failed) + report.count(ScanFate::Stale)) + " failed, " +
         number(ScanFate::Quarantined) + " quarantined" + some(not_made(report), "not made") +
         some(report.count(ScanFate::Vanished), "vanished") + " | gates: " + std::to_string(report.rejected()) + " | " +
         clock_text(report.seconds) + " h | " +
         (report.has_page  ? report.out + "/report.html"
          : report.written ? report.out + "/run.json"
                           : "nothing written") +
         " | exit " + std::to_string(report.exit_code);
}

Node last_event(const RunReport& report) {
  Node node = Node::map();
  node.set("type", "summary");
  node.set("scans", in_this_run(report));
  node.set("unchanged", report.count(ScanFate::Unchanged));
  node.set("done", report.count(ScanFate::Done));
  node.set("failed", report.count(ScanFate::Failed) + report.count(ScanFate::Stale));
  node.set("stale", report.count(ScanFate::Stale));
  node.set("quarantined", report.count(ScanFate::Quarantined));
  node.set("not_made", not_made(report));
  node.set("vanished", report.count(ScanFate::Vanished));
  node.set("gates", report.rejected());
  node.set("seconds", report.seconds);
  if (report.written) node.set("run", report.out + "/run.json");
  if (report.has_page) node.set("report", report.out + "/report.html");
  node.set("exit", report.exit_code);
  return node;
}

}  // namespace scanmill::runner
