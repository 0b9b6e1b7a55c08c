// SPDX-License-Identifier: Apache-2.0
#include "runner/job_scans.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "base/text.hpp"
#include "runner/glob.hpp"
#include "runner/scan_messages.hpp"
#include "store/files.hpp"

namespace scanmill::runner {
namespace {

constexpr std::uint64_t kJobLimit = 16ull << 20;

std::string names_text(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < 8; ++i) text += (i ? ", " : "") + names[i];
  if (names.size() > 8) text += ", ... (" + std::to_string(names.size()) + " in all)";
  return text;
}

std::string no_match(const std::string& pattern, const std::vector<std::string>& names, bool list_names) {
  std::string text = "found no scan that matches '" + pattern + "'";
  if (list_names) text += "; the archive holds " + names_text(names);
  const std::vector<std::string_view> words(names.begin(), names.end());
  const std::string_view nearest = nearest_name(pattern, words);
  if (!nearest.empty()) text += "; nearest " + std::string(nearest);
  return text;
}

bool any_matches(const std::string& pattern, const std::vector<std::string>& names) {
  return std::any_of(names.begin(), names.end(), [&](const std::string& name) { return matches(pattern, name); });
}

/// Lines of several errors, each once.
struct Lines {
  std::vector<std::string> list;
  void add(const std::string& text) {
    for (std::string& line : lines_of(text))
      if (std::find(list.begin(), list.end(), line) == list.end()) list.push_back(std::move(line));
  }
  std::string text() const {
    std::string all;
    for (const std::string& line : list) all += (all.empty() ? "" : "\n") + line;
    return all;
  }
};

/// A scan's folder must not lie inside another's: replacing the outer one would take the inner one with it.
void check_nesting(const std::vector<SelectedScan>& scans, const std::string& job, Lines& lines) {
  std::set<std::string> names;
  for (const SelectedScan& scan : scans) names.insert(scan.task.name);
  for (const std::string& name : names)
    for (auto slash = name.find('/'); slash != std::string::npos; slash = name.find('/', slash + 1))
      if (names.contains(name.substr(0, slash)))
        lines.add(job + ": scans: found both " + name.substr(0, slash) + " and " + name +
                  "; their results would lie inside each other: rename one, or select one with scans or --only");
}

/// Patterns that match no scan, a sentence each. Archives change from night to night: they say less than they did, and
/// stop nothing while there is a scan to make.
struct Idle {
  std::vector<std::string> selecting;  // of scans and --only
  std::vector<std::string> changing;   // of overrides
  std::vector<std::string> all() const {
    std::vector<std::string> list = selecting;
    list.insert(list.end(), changing.begin(), changing.end());
    return list;
  }
};

Idle idle_patterns(const Job& job, std::span<const std::string> only, const std::vector<std::string>& names) {
  Idle idle;
  const auto check = [&](std::span<const std::string> patterns, const std::string& place, auto& list, bool list_names) {
    for (const std::string& pattern : patterns)
      if (!any_matches(pattern, names)) list.push_back(place + ": " + no_match(pattern, names, list_names));
  };
  check(job.scans, job.path + ": scans", idle.selecting, true);
  check(only, "command line: --only", idle.selecting, true);
  for (const Override& entry : job.overrides)
    check(entry.scans, document::place(job.path, entry.what.mark) + ": overrides.scans", idle.changing,
          false);  // each night, once it vanished
  return idle;
}

/// Which overrides a scan meets: with the same ones the keys are the same.
std::vector<bool> overrides_of(const Job& job, const std::string& scan) {
  std::vector<bool> met;
  for (const Override& entry : job.overrides) met.push_back(matches_any(entry.scans, scan));
  return met;
}

std::string archive_place(const Job& job) {
  return job.archive_mark.line > 0 ? document::place(job.path, job.archive_mark) : job.path;
}

}  // namespace

Result<Job> load_job(const std::string& path, std::span<const std::string> sets, const Work& work) {
  TRY_ASSIGN(const auto source, store::open_file(path, path));
  TRY_ASSIGN(const std::string text, read_all(*source, kJobLimit));
  return job_from(text, path, sets, work);
}

Result<Selection> select_scans(const Job& job, std::span<const std::string> only, Work& work) {
  if (!store::is_folder(job.archive))
    return fail(Code::BadParameter, "archive: found no folder " + job.archive + "; make it, or correct the key",
                archive_place(job));
  TRY_ASSIGN(Archive archive,
             work.discover(job.archive, job.what, [&](const std::string& scan) { return what_of(job, scan, work); }));
  const std::vector<ScanTask>& tasks = archive.scans;
  Selection selection;
  selection.notes = std::move(archive.notes);
  selection.all_names.reserve(tasks.size());
  for (const ScanTask& task : tasks) selection.all_names.push_back(task.name);
  if (tasks.empty())
    return fail(Code::BadParameter,
                "archive: found no scan in " + job.archive + "; wanted point files, .conf files or scan plans" +
                    (selection.notes.empty() ? "" : "; found " + joined_lines(selection.notes, "; ")),
                archive_place(job));

  Lines lines;
  const Idle idle = idle_patterns(job, only, selection.all_names);
  std::map<std::vector<bool>, std::shared_ptr<const document::Node>> resolved;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    if (!matches_any(job.scans, tasks[i].name) || !matches_any(only, tasks[i].name)) continue;
    std::shared_ptr<const document::Node>& what = resolved[overrides_of(job, tasks[i].name)];
    if (!what) {
      auto keys = work.resolve(what_of(job, tasks[i].name, work), job.path);
      if (!keys) {
        lines.add(keys.error().text());
        continue;
      }
      what = std::make_shared<const document::Node>(*std::move(keys));
    }
    selection.scans.push_back({i, tasks[i], what});
  }
  selection.scans.shrink_to_fit();
  check_nesting(selection.scans, job.path, lines);
  if (!lines.list.empty()) return fail(Code::BadParameter, lines.text());
  selection.idle = idle.all();
  selection.notes.insert(selection.notes.end(), selection.idle.begin(), selection.idle.end());
  if (selection.scans.empty() && !idle.selecting.empty())
    return fail(Code::BadParameter, joined_lines(idle.selecting, "\n"));
  if (selection.scans.empty())
    return fail(Code::BadParameter,
                "found no scan that both the job's scans and --only select; the archive holds " +
                    names_text(selection.all_names),
                job.path);
  return selection;
}

}  // namespace scanmill::runner
