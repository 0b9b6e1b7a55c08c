// SPDX-License-Identifier: Apache-2.0
#include "runner/job.hpp"

#include <algorithm>
#include <filesystem>

#include "base/text.hpp"
#include "runner/glob.hpp"

namespace scanmill::runner {
namespace {

using document::Node;
using document::Problems;
using document::shown;

constexpr std::string_view kOwnKeys[] = {"scanmill",  "archive",  "scans",  "overrides",
                                         "resources", "executor", "strict", "notify"};
// Keys of the contract that this version would ignore are refused by name, so that no job silently does less than it
// says.
constexpr std::string_view kLaterKeys[] = {"settle_s", "brick", "retry", "cluster"};
constexpr std::string_view kLaterResources[] = {"disk", "scan_time_limit", "until"};
constexpr std::string_view kMemoryKey[] = {"memory"};
constexpr std::string_view kExecutors[] = {"inline", "local"};

bool among(std::string_view word, std::span<const std::string_view> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

bool is_extension(std::string_view key) { return key.substr(0, 2) == "x-"; }

std::vector<std::string> read_globs(const Node& value, const std::string& key, Problems& problems) {
  std::vector<std::string> globs;
  const auto add = [&](const Node& item) {
    if (item.is_string() && !item.as_string().empty())
      globs.push_back(item.as_string());
    else if (item.is_number() && !item.text.empty())
      globs.push_back(item.text);  // a scan may be called 007
    else
      problems.add(item.mark, key, "found " + shown(item) + "; allowed a scan name or pattern such as 'part-*'");
  };
  if (value.is_sequence() && !value.items().empty())
    for (const Node& item : value.items()) add(item);
  else
    add(value);
  return globs;
}

void read_resources(const Node& section, How& how, Problems& problems) {
  Node known = section;
  if (section.is_map())
    for (const std::string_view key : kLaterResources)
      if (const Node* later = section.find(key)) {
        problems.add(later->mark, "resources." + std::string(key), "not in this version; remove the key");
        std::erase_if(known.entries(), [&](const Node::Entry& entry) { return entry.key == key; });
      }
  document::read_fields(known, "resources", resource_fields(), &how, kMemoryKey, problems);
  const Node* memory = section.find("memory");
  if (!memory) return;
  const std::string text = !memory->text.empty() ? memory->text : memory->is_string() ? memory->as_string() : "";
  const auto bytes = parse_size(memory->is_integer() && text.empty() ? std::to_string(memory->as_integer()) : text);
  if (bytes && *bytes > 0)
    how.memory = *bytes;
  else
    problems.add(memory->mark, "resources.memory", "found " + shown(*memory) + "; allowed a size such as 512M or 2G");
}

void read_executor(const Node& value, Problems& problems) {
  if (value.is_string() && value.as_string() == "slurm")
    problems.add(value.mark, "executor", "found slurm; not in this version; allowed " + document::joined(kExecutors));
  else if (!value.is_string() || !among(value.as_string(), kExecutors)) {
    std::string sentence = "found " + shown(value) + "; allowed " + document::joined(kExecutors);
    const std::string_view nearest = value.is_string() ? nearest_name(value.as_string(), kExecutors) : "";
    if (!nearest.empty()) sentence += "; nearest " + std::string(nearest);
    problems.add(value.mark, "executor", sentence);
  }
}

Override read_override(const Node& item, const Work& work, Problems& problems) {
  Override result;
  result.what = Node::map();
  result.what.mark = item.mark;
  std::vector<std::string_view> allowed{"scans"};
  for (const std::string_view key : work.what_keys())
    if (!is_whole_archive_key(key)) allowed.push_back(key);
  if (!item.is_map()) {
    problems.add(
        item.mark, "overrides",
        "found " + shown(item) + "; allowed a map of scans and " + document::joined(std::span(allowed).subspan(1)));
    return result;
  }
  for (const Node::Entry& entry : item.entries()) {
    if (entry.key == "scans")
      result.scans = read_globs(entry.value, "overrides.scans", problems);
    else if (among(entry.key, allowed))
      result.what.entries().push_back(entry);
    else if (!is_extension(entry.key))
      problems.add_unknown(entry, "overrides", allowed);
  }
  if (!item.find("scans"))
    problems.add(item.mark, "overrides", "found an entry without scans; add scans: with a name or pattern");
  work.check_part(result.what, problems);
  return result;
}

void forget_marks(Node& node) {
  node.mark = {};
  if (node.is_map())
    for (Node::Entry& entry : node.entries()) {
      entry.mark = {};
      forget_marks(entry.value);
    }
  else if (node.is_sequence())
    for (Node& item : node.items()) forget_marks(item);
}

/// "a.b=1" as {a: {b: 1}} into `tree`.
void read_set(const std::string& set, Node& tree, Problems& problems) {
  const auto equals = set.find('=');
  if (equals == std::string::npos || equals == 0)
    return problems.add({}, "--set", "found '" + set + "'; wanted key=value, such as lattice.bin_mm=0.5");
  auto value = document::parse_yaml(set.substr(equals + 1), "--set " + set);
  if (!value) return problems.add({}, "--set", "found '" + set + "'; the value is " + value.error().message);
  if (set.size() == equals + 1) *value = Node();
  forget_marks(*value);
  Node* at = &tree;
  std::string path = set.substr(0, equals);
  for (auto dot = path.find('.'); dot != std::string::npos; dot = path.find('.')) {
    const std::string key = path.substr(0, dot);
    Node* next = at->find(key);
    if (!next || !next->is_map()) next = &at->set(key, Node::map());
    at = next;
    path.erase(0, dot + 1);
  }
  at->set(path, std::move(*value));
}

void overlay_how(Node& base, const Node& over) {
  for (const Node::Entry& entry : over.entries()) {
    Node* present = base.find(entry.key);
    if (present && present->is_map() && entry.value.is_map())
      overlay_how(*present, entry.value);
    else
      base.set(entry.key, entry.value);
  }
}

void read_top(const Node& root, Job& job, const Work& work, Problems& problems) {
  std::vector<std::string_view> allowed(std::begin(kOwnKeys), std::end(kOwnKeys));
  allowed.insert(allowed.end(), work.what_keys().begin(), work.what_keys().end());
  if (const Node* version = root.find("scanmill"); !version)
    problems.add(root.mark, "scanmill", "found no version; write scanmill: 1 on top");
  else if (!version->is_integer() || version->as_integer() != 1)
    problems.add(version->mark, "scanmill", "found " + shown(*version) + "; allowed 1");
  for (const Node::Entry& entry : root.entries()) {
    const Node& value = entry.value;
    if (among(entry.key, work.what_keys()))
      job.what.entries().push_back(entry);
    else if (entry.key == "archive") {
      job.archive_mark = value.mark;
      if (value.is_string() && !value.as_string().empty())
        job.archive = value.as_string();
      else if (!value.text.empty())
        job.archive = value.text;
      else
        problems.add(value.mark, "archive", "found " + shown(value) + "; allowed the path of a folder");
    } else if (entry.key == "scans")
      job.scans = read_globs(value, "scans", problems);
    else if (entry.key == "resources")
      read_resources(value, job.how, problems);
    else if (entry.key == "executor")
      read_executor(value, problems);
    else if (entry.key == "notify")
      read_notify(value, job.how.notify, problems);
    else if (entry.key == "strict") {
      if (value.is_bool())
        job.how.strict = value.as_bool();
      else
        problems.add(value.mark, "strict", "found " + shown(value) + "; allowed true, false");
    } else if (entry.key == "overrides") {
      if (!value.is_sequence())
        problems.add(value.mark, "overrides",
                     "found " + shown(value) + "; allowed a list of {scans: PATTERN, key: value}");
      else
        for (const Node& item : value.items()) job.overrides.push_back(read_override(item, work, problems));
    } else if (among(entry.key, kLaterKeys)) {
      problems.add(entry.mark, entry.key, "not in this version; remove the key");
    } else if (entry.key != "scanmill" && !is_extension(entry.key)) {
      problems.add_unknown(entry, "", allowed);
    }
  }
}

}  // namespace

bool is_whole_archive_key(std::string_view key) {
  return key == "mesh_vertices_as_scan" || key == "format" || key == "views";
}

std::span<const std::string_view> executor_words() { return kExecutors; }

std::span<const Field> resource_fields() {
  static const Field kTable[] = {
      field<How, &How::threads>("threads", "", "Threads to use; without the key all that the process may use.",
                                {1, 1024}),
  };
  return kTable;
}

Result<Job> job_from(const std::string& text, const std::string& path, std::span<const std::string> sets,
                     const Work& work) {
  TRY_ASSIGN(Node root, document::parse_yaml(text, path));
  Problems problems(path);
  if (root.mark.line == 0) root.mark = {1, 1};  // an empty file
  if (!root.is_map()) {
    problems.add(root.mark, "", "found " + shown(root) + "; wanted a map of keys that begins with scanmill: 1");
    return problems.error();
  }
  Node given = Node::map();
  for (const std::string& set : sets) read_set(set, given, problems);
  Node what = Node::map(), how = Node::map();
  for (const Node::Entry& entry : given.entries()) {
    const bool per_scan = among(entry.key, work.what_keys()) && !is_whole_archive_key(entry.key);
    (per_scan ? what : how).entries().push_back(entry);
  }
  overlay_how(root, how);

  Job job;
  job.path = path;
  job.text = text;
  job.what = Node::map();
  job.what.mark = root.mark;
  read_top(root, job, work, problems);
  work.check_part(job.what, problems);
  if (!what.entries().empty()) {
    work.check_part(what, problems);
    job.overrides.push_back({{"*"}, std::move(what)});
  }
  if (!problems.empty()) return problems.error();
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  job.archive = (folder / job.archive).lexically_normal().string();
  if (job.archive.empty()) job.archive = ".";
  return job;
}

Node what_of(const Job& job, const std::string& scan, const Work& work) {
  Node what = job.what;
  for (const Override& entry : job.overrides)
    if (matches_any(entry.scans, scan)) what = work.overlay(std::move(what), entry.what);
  return what;
}

}  // namespace scanmill::runner
