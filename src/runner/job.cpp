// SPDX-License-Identifier: Apache-2.0
#include "runner/job.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/text.hpp"
#include "runner/glob.hpp"

namespace scanmill::runner {
namespace {

using document::Node;
using document::Problems;
using document::shown;

constexpr std::string_view kOwnKeys[] = {"scanmill", "archive",  "scans", "overrides", "resources", "executor",
                                         "strict",   "settle_s", "retry", "notify",    "cluster",   "brick"};
constexpr std::string_view kTextResources[] = {"memory", "disk", "scan_time_limit", "until"};
const Field kSettle = field<How, &How::settle_s>(
    "settle_s", "", "Files changed less than this ago are waited for, ten times at most.", {0, 86400});
constexpr std::string_view kExecutors[] = {"inline", "local", "slurm"};

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

/// A scalar as it was written, or as a person would write it.
std::string scalar_of(const Node& node) {
  return !node.text.empty()  ? node.text
         : node.is_string()  ? node.as_string()
         : node.is_integer() ? std::to_string(node.as_integer())
         : node.is_number()  ? number_text(node.as_number())
                             : "";
}

/// parse(text) of one key of `resources` into `to`.
template <class Parse, class To>
void read_text(const Node& section, const char* key, Parse parse, To& to, const char* allowed, Problems& problems) {
  const Node* value = section.find(key);
  if (!value) return;
  if (const auto parsed = parse(scalar_of(*value)); parsed && *parsed >= 0)
    to = *parsed;
  else
    problems.add(value->mark, "resources." + std::string(key), "found " + shown(*value) + "; allowed " + allowed);
}

void read_resources(const Node& section, How& how, Problems& problems) {
  document::read_fields(section, "resources", resource_fields(), &how, kTextResources, problems);
  const auto size = [](const std::string& text) {
    const auto bytes = parse_size(text);
    return bytes && *bytes == 0 ? std::nullopt : bytes;
  };
  read_text(section, "memory", size, how.memory, "a size such as 512M or 2G", problems);
  read_text(section, "disk", size, how.disk, "a size such as 50G or 1T", problems);
  read_text(section, "scan_time_limit", parse_duration, how.scan_time_limit_s, "a time such as 90m or 6h", problems);
  read_text(section, "until", parse_time_of_day, how.until_minute, "a time of day such as \"05:30\"", problems);
}

void read_brick(const Node& section, How& how, Problems& problems) {
  constexpr std::string_view kByHand[] = {"edge_bins"};
  document::read_fields(section, "brick", brick_fields(), &how.brick, kByHand, problems);
  const Node* edge = section.is_map() ? section.find("edge_bins") : nullptr;
  if (!edge || (edge->is_string() && edge->as_string() == "auto")) return;
  const std::int64_t bins = edge->is_integer() ? edge->as_integer() : 0;
  if (bins >= 8 && bins <= 256 && (bins & (bins - 1)) == 0)
    how.brick.edge_bins = bins;
  else
    problems.add(edge->mark, "brick.edge_bins", "found " + shown(*edge) + "; allowed auto, 8, 16, 32, 64, 128, 256");
}

void read_executor(const Node& value, How& how, Problems& problems) {
  if (!value.is_string() || !among(value.as_string(), kExecutors)) {
    std::string sentence = "found " + shown(value) + "; allowed " + document::joined(kExecutors);
    const std::string_view nearest = value.is_string() ? nearest_name(value.as_string(), kExecutors) : "";
    if (!nearest.empty()) sentence += "; nearest " + std::string(nearest);
    problems.add(value.mark, "executor", sentence);
  } else {
    how.in_this_process = value.as_string() == "inline";
    how.on_cluster = value.as_string() == "slurm";
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
      read_executor(value, job.how, problems);
    else if (entry.key == "settle_s")
      document::read_field(value, "settle_s", kSettle, &job.how, problems);
    else if (entry.key == "retry")
      document::read_fields(value, "retry", retry_fields(), &job.how, {}, problems);
    else if (entry.key == "cluster")
      read_cluster(value, job.how.cluster, problems);
    else if (entry.key == "brick")
      read_brick(value, job.how, problems);
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
    } else if (entry.key != "scanmill" && !is_extension(entry.key)) {
      problems.add_unknown(entry, "", allowed);
    }
  }
}

}  // namespace

bool is_whole_archive_key(std::string_view key) { return key == "format" || key == "views"; }

std::span<const std::string_view> executor_words() { return kExecutors; }

std::span<const Field> resource_fields() {
  static const Field kTable[] = {
      field<How, &How::threads>("threads", "", "Threads to use; without the key all that the process may use.",
                                {1, 1024}),
  };
  return kTable;
}

std::span<const Field> retry_fields() {
  static const Field kTable[] = {
      field<How, &How::retry_transient>("transient", "", "Further attempts after a fault that may pass.", {0, 100}),
      field<How, &How::retry_internal>("internal", "", "Further attempts after a worker died.", {0, 100}),
      field<How, &How::retry_wait_s>("wait_s", "", "Before the first of them; four times as long before each next.",
                                     {0, 3600}),
  };
  return kTable;
}

std::span<const Field> brick_fields() {
  static const Field kTable[] = {
      field<BrickKeys, &BrickKeys::pieces>("pieces", "", "Of the input of a scan that is cut; 0: by its bytes.",
                                           {0, 4096}),
      field<BrickKeys, &BrickKeys::batches>("batches", "", "Of bricks, each one task; 0: by the bytes.", {0, 4096}),
  };
  return kTable;
}

const Field& settle_field() { return kSettle; }

std::optional<double> parse_duration(std::string_view text) {
  if (text.empty()) return std::nullopt;
  double unit = 1;
  const std::string_view letters = "smhd";
  static constexpr double kSeconds[] = {1, 60, 3600, 86400};
  if (const auto place = letters.find(text.back()); place != std::string_view::npos) {
    unit = kSeconds[place];
    text.remove_suffix(1);
    while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  }
  const auto value = parse_number(text);
  if (!value || !(*value > 0) || !(*value * unit < 1e9)) return std::nullopt;
  return *value * unit;
}

std::optional<std::int64_t> parse_time_of_day(std::string_view text) {
  const auto colon = text.find(':');
  if (colon == std::string_view::npos || colon == 0 || text.size() - colon != 3) return std::nullopt;
  const auto hour = parse_number(text.substr(0, colon)), minute = parse_number(text.substr(colon + 1));
  if (!hour || !minute || *hour < 0 || *hour > 23 || *minute < 0 || *minute > 59 || std::floor(*hour) != *hour ||
      std::floor(*minute) != *minute)
    return std::nullopt;
  return static_cast<std::int64_t>(*hour) * 60 + static_cast<std::int64_t>(*minute);
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
