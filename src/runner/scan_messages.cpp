// SPDX-License-Identifier: Apache-2.0
#include "runner/scan_messages.hpp"

#include <algorithm>
#include <cstdio>

#include "base/text.hpp"
#include "runner/output_tree.hpp"
#include "store/files.hpp"

namespace scanmill::runner {

using document::Node;

namespace {

/// A word as a shell takes it.
std::string quoted(const std::string& word) {
  if (!word.empty() &&
      word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=,:%+@") ==
          std::string::npos)
    return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? "'\\''" : std::string(1, c);
  return text + "'";
}

Node texts(const std::vector<std::string>& list) {
  Node node = Node::sequence();
  for (const std::string& text : list) node.push(text);
  return node;
}

Node event_of(const ScanEntry& entry, const std::string& out) {
  Node event = Console::event("scan");
  event.set("name", entry.name);
  event.set("state", name_of(entry.fate));
  event.set("seconds", entry.seconds);
  event.set("why", texts(entry.why));
  Node files = Node::sequence();
  for (const std::string& file : paths_of(entry)) files.push(out + "/" + file);
  event.set("files", std::move(files));
  if (!entry.failed_gates.empty()) event.set("failed_gates", texts(entry.failed_gates));
  if (entry.counts.is_known()) event.set("counts", entry.counts.document());
  return event;
}

void explain_scan(const ScanEntry& entry, bool dry_run, Console& console) {
  const char* verb = entry.fate == ScanFate::Unchanged || entry.fate == ScanFate::Quarantined ? "skipped"
                     : dry_run                                                                ? "would run"
                                                                                              : "run";
  Node event = Console::event("explain");
  event.set("name", entry.name);
  event.set("verb", verb);
  event.set("why", texts(entry.why));
  const std::string why = entry.fate == ScanFate::Quarantined ? "quarantined"
                          : entry.why.empty()                 ? "unchanged"
                                                              : joined_lines(entry.why, "; ");
  console.result(entry.name + ": " + verb + ": " + why, event);
}

std::string good_line(const ScanEntry& entry, const std::string& out) {
  std::string line =
      entry.name + ": " + name_of(entry.fate) + (entry.failed_gates.empty() ? "" : ", but rejected by a gate");
  for (const std::string& file : paths_of(entry))
    if (!file.ends_with(".png")) line += " | " + out + "/" + file;  // pictures are in the report as well
  for (const auto& [key, thing] : {std::pair("triangles", "triangle"), std::pair("boundary_loops", "open loop")})
    if (const auto value = entry.counts.find(key); value && value->is_integer())
      line += " | " + counted(static_cast<std::uint64_t>(value->as_integer()), thing);
  return line + " | " + seconds_text(entry.seconds);
}

}  // namespace

std::string joined_lines(const std::vector<std::string>& lines, const char* between) {
  std::string all;
  for (const std::string& line : lines) all += (all.empty() ? "" : between) + line;
  return all;
}

std::string seconds_text(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f s", seconds);
  return text;
}

std::string repeat_command(const RunOptions& options, const std::string& scan) {
  std::string text = "scanmill run " + quoted(options.job);
  if (!options.out.empty()) text += " --out " + quoted(options.out);
  for (const std::string& set : options.sets) text += " --set " + quoted(set);
  return text + " --only " + quoted(scan);
}

std::string missing_part(const ScanEntry& entry, const OutputTree& tree, const std::string& maker) {
  if (entry.error.code != Code::IoFailed || entry.failure != FailureClass::Transient) return {};
  const std::string folder = std::string("/") + kPartsFolder + "/" + entry.name + "/", suffix = ".part";
  const std::size_t at = entry.error.where.rfind(folder);
  if (at == std::string::npos) return {};
  std::string part = entry.error.where.substr(at + folder.size());
  if (!part.ends_with(suffix) || store::exists(tree.parts(entry.name) + "/" + part)) return {};
  part.resize(part.size() - suffix.size());
  std::replace(part.begin(), part.end(), '-', ' ');
  return part == maker ? std::string() : part;
}

void show_scan(const ScanEntry& entry, const std::string& out, bool explain, bool dry_run, bool quiet_unchanged,
               Console& console) {
  Node event = event_of(entry, out);
  if (explain || dry_run) explain_scan(entry, dry_run, console);
  if (entry.fate != ScanFate::Unchanged)
    for (const std::string& note : entry.notes) console.note(entry.name, note);
  if (entry.fate == ScanFate::Unchanged && quiet_unchanged) {
    console.event_only(event);
  } else if (entry.fate == ScanFate::Done || entry.fate == ScanFate::Unchanged) {
    console.result(good_line(entry, out), event);
  } else if (!entry.error.message.empty()) {
    Node error = Node::map();
    error.set("code", scanmill::name_of(entry.error.code));
    error.set("text", entry.error.text());
    error.set("repeat", entry.repeat);
    event.set("error", std::move(error));
    console.problem("scan " + entry.name + ": " + name_of(entry.fate) + ": " + entry.error.text() +
                        (entry.fate == ScanFate::Stale ? " (the last good result is kept)" : "") +
                        " | again: " + entry.repeat,
                    event);
  }
  for (const std::string& gate : entry.failed_gates) {
    Node failed = Console::event("gate");
    failed.set("scan", entry.name);
    failed.set("text", gate);
    console.problem("scan " + entry.name + ": rejected: " + gate, failed);
  }
}

}  // namespace scanmill::runner
