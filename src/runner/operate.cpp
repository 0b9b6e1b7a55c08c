// SPDX-License-Identifier: Apache-2.0
#include "runner/operate.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <map>
#include <set>

#include "base/text.hpp"
#include "runner/glob.hpp"
#include "runner/journal.hpp"
#include "runner/known_names.hpp"
#include "runner/machine.hpp"
#include "runner/output_lock.hpp"
#include "runner/output_tree.hpp"
#include "runner/quarantine.hpp"
#include "runner/run_report.hpp"
#include "runner/run_texts.hpp"
#include "runner/run_view.hpp"
#include "runner/slurm_waves.hpp"
#include "runner/task_file.hpp"
#include "runner/task_result.hpp"
#include "runner/task_signs.hpp"
#include "store/files.hpp"

namespace scanmill::runner {
namespace {

using document::Node;

constexpr std::size_t kKeptJournals = 10, kShownPending = 10;

std::optional<Node> read_tree(const std::string& path) {
  const auto source = store::open_file(path, path);
  if (!source) return std::nullopt;
  const auto text = read_all(**source, 1ull << 30);
  if (!text) return std::nullopt;
  auto tree = document::parse_json(*text, path);
  if (!tree || !tree->is_map()) return std::nullopt;
  return *std::move(tree);
}

std::string text_in(const Node& tree, const char* key) {
  const Node* value = tree.find(key);
  return value && value->is_string() ? value->as_string() : "";
}
double number_in(const Node& tree, const char* key) {
  const Node* value = tree.find(key);
  return value && value->is_number() ? value->as_number() : 0;
}

/// What a run writes about itself while it goes on, and whether its process is there.
struct Live {
  std::optional<Node> tree;
  bool is_here = false;  // this host can tell
  bool is_alive = false;
};

Live look_at_run(const OutputTree& tree) {
  Live live{read_tree(tree.live_file()), false, false};
  if (!live.tree) return live;
  live.is_here = text_in(*live.tree, "host") == host_name();
  const auto pid = static_cast<int>(number_in(*live.tree, "pid"));
  live.is_alive = live.is_here && is_process_alive(pid);
  return live;
}

/// "5 done, 1 running, 3 waiting"
std::string count_line(const Node& counts, bool was_killed = false) {
  std::string line;
  for (const Node::Entry& entry : counts.entries())
    if (entry.value.as_integer() > 0 || entry.key == "done")
      line += (line.empty() ? "" : ", ") + std::to_string(entry.value.as_integer()) + " " +
              (was_killed && entry.key == "running" ? "not finished" : entry.key);
  return line;
}

bool is_stopping(const Node& live) {
  const Node* stopping = live.find("stopping");
  return stopping && stopping->is_bool() && stopping->as_bool();
}

/// Seconds since the run wrote about itself; it does so every two.
double silence_of(const Live& live) {
  const auto told = unix_seconds(text_in(*live.tree, "heartbeat"));
  return told ? std::max(0.0, static_cast<double>(std::time(nullptr) - *told)) : 0;
}

/// Of a process of this machine: that somebody stopped it (SIGSTOP, Ctrl-Z, a debugger).
std::string stopped_text(const Node& row) {
  const auto sign = look_at_process(static_cast<int>(number_in(row, "pid")));
  return sign && (sign->state == 'T' || sign->state == 't') ? ", its process is stopped (kill -CONT lets it go on)"
                                                            : "";
}

/// `silence`: of the run itself, which the row is older by.
std::string running_line(const Node& row, double silence) {
  std::string line = "  " + text_in(row, "scan");
  const std::string part = text_in(row, "part"), stage = text_in(row, "stage");
  if (!part.empty() && part != stage) line += " " + part;
  const Node* queued = row.find("queued");
  const bool is_queued = queued && queued->is_bool() && queued->as_bool();
  line += (is_queued ? "  pending: " : "  ") + stage;
  if (const double total = number_in(row, "total"); total > 0)
    line += "  " + std::to_string(static_cast<int>(100 * number_in(row, "done") / total)) + " %";
  line += "  for " + clock_text(number_in(row, "seconds") + silence) + " h";
  if (const double parts = number_in(row, "parts"); parts > 0)
    line += ", " + number_text(number_in(row, "parts_done")) + " of " +
            counted(static_cast<std::uint64_t>(parts), "part") + " done";
  if (const std::string place = text_in(row, "place"); !place.empty()) line += ", " + place;
  if (number_in(row, "pid") > 0) line += ", pid " + std::to_string(static_cast<long>(number_in(row, "pid")));
  return line + ", " + counted(static_cast<std::uint64_t>(number_in(row, "threads")), "thread") +
         silence_text(number_in(row, "silent_s")) + (text_in(row, "place").empty() ? stopped_text(row) : "");
}

/// At work first; of those that wait not all, since the remark below them tells of all.
std::string running_lines(const Node& rows, double silence) {
  std::string text;
  std::size_t left_out = 0, queued = 0;
  for (const Node& row : rows.items())
    if (row.find("queued") && ++queued > kShownPending)
      ++left_out;
    else
      text += "\n" + running_line(row, silence);
  if (left_out > 0) text += "\n  and " + std::to_string(left_out) + " more pending";
  return text;
}

/// What works without a driver: arrays of one that died, worklists that others work on.
std::string text_of_waves(const OutputTree& tree, const std::string& out) {
  std::string text;
  for (const WaveFolder& wave : open_waves(tree)) {
    const auto file = load_task_file(wave.worklist());
    if (!file) continue;
    std::size_t items = 0, recorded = 0;
    for (std::size_t t = 0; t < file->tasks.size(); ++t)
      for (std::size_t i = 0; i < file->tasks[t].items.size(); ++i, ++items)
        recorded += store::exists(result_path(wave.folder, t, i));
    std::int64_t latest = 0;
    for (const SignOfLife& sign : signs_of(wave)) latest = std::max(latest, sign.time_ns);
    text += "\n" +
            (wave.name.empty()
                 ? "worklist " + wave.worklist() + " of " + counted(file->tasks.size(), "task")
                 : "array " + wave.name + " of " + counted(file->tasks.size(), "element") + " is on the cluster") +
            ": " + std::to_string(recorded) + " of " + std::to_string(items) + " recorded" +
            (latest > 0 ? ", last sign of life " + number_text(std::ceil(age_by_folder(wave, latest))) + " s ago" : "");
    text += wave.name.empty() ? "; the next run of the job finds what is made"
                              : "; the next run takes it over, scanmill cancel " + out + " takes it back";
  }
  return text;
}

int no_output(const std::string& out, Console& console) {
  console.complain(fail(Code::BadUsage, "found no run here; name the output folder of a run", out));
  return kExitUsage;
}

bool is_output(const OutputTree& tree) { return store::is_folder(tree.journal()); }

/// Scans that the next run may go on with: known to the last runs, and neither done nor gone nor given up.
std::set<std::string> unmade_scans(const OutputTree& tree) {
  std::set<std::string> names = load_names(tree);
  if (const auto run = read_tree(tree.run_file()))
    if (const Node* scans = run->find("scans"); scans && scans->is_sequence())
      for (const Node& scan : scans->items()) {
        const std::string state = text_in(scan, "state");
        if (state == "done" || state == "unchanged" || state == "vanished")
          names.erase(text_in(scan, "name"));
        else
          names.insert(text_in(scan, "name"));
      }
  for (const std::string& name : Quarantine::load(tree.quarantine_file()).names()) names.erase(name);
  return names;
}

/// Parts of large scans, by scan.
struct KeptParts {
  std::vector<std::string> wanted, rest;  // folders
  std::vector<std::string> texts;         // "bun (19 parts, 12 MiB)", of those that are wanted
  std::uint64_t bytes = 0;                // of these
};

KeptParts look_at_parts(const OutputTree& tree) {
  KeptParts parts;
  struct Folder {
    std::uint64_t parts = 0, bytes = 0;
  };
  std::map<std::string, Folder> folders;
  std::error_code error;
  for (std::filesystem::recursive_directory_iterator it(tree.parts(), error), end; !error && it != end;
       it.increment(error)) {
    std::error_code unknown;
    if (!it->is_regular_file(unknown)) continue;
    const std::uintmax_t bytes = it->file_size(unknown);
    Folder& folder = folders[it->path().parent_path().string()];
    folder.bytes += unknown ? 0 : bytes;
    folder.parts += it->path().extension() == ".part";
  }
  const std::set<std::string> unmade = folders.empty() ? std::set<std::string>() : unmade_scans(tree);
  for (const auto& [path, folder] : folders) {
    const std::string scan = std::filesystem::path(path).lexically_relative(tree.parts()).string();
    const bool is_wanted = unmade.contains(scan);
    (is_wanted ? parts.wanted : parts.rest).push_back(path);
    if (!is_wanted) continue;
    parts.bytes += folder.bytes;
    parts.texts.push_back(scan + " (" + counted(folder.parts, "part") + ", " + bytes_text(folder.bytes) + ")");
  }
  return parts;
}

/// What runs before have left to go on from.
std::string text_of_parts(const KeptParts& parts) {
  std::string text;
  for (std::size_t i = 0; i < std::min(parts.texts.size(), kShownPending); ++i)
    text += (i == 0 ? "\npartly made: " : ", ") + parts.texts[i];
  if (parts.texts.size() > kShownPending)
    text += " and " + std::to_string(parts.texts.size() - kShownPending) + " more";
  return text.empty() ? text : text + "; the next run goes on from there";
}

/// Everything gc may take, with the reason.
std::vector<std::pair<std::string, std::string>> garbage_of(const OutputTree& tree, const KeptParts& parts) {
  std::vector<std::pair<std::string, std::string>> found;
  if (!has_open_waves(tree))  // else they may be at work
    for (const std::string& path : tree.leftovers()) found.emplace_back(path, "left by a run that was killed");
  const char* of_large = "parts of large scans that are done, gone or given up";
  if (!has_open_waves(tree) && parts.wanted.empty() && store::is_folder(tree.parts()))
    found.emplace_back(tree.parts(), of_large);
  else if (!has_open_waves(tree))
    for (const std::string& folder : parts.rest) found.emplace_back(folder, of_large);
  const auto epochs = epochs_in(tree.journal());
  for (std::size_t i = 0; i + kKeptJournals < epochs.size(); ++i)
    found.emplace_back(journal_file(tree.journal(), epochs[i]), "an old journal");
  std::set<std::string> known;
  // The last run may have looked at a part only: run.json alone does not tell what is gone.
  for (const std::string& name : tree.finished()) known.insert(tree.log(name));
  for (const std::string& name : load_names(tree)) known.insert(tree.log(name));
  for (const std::string& name : Quarantine::load(tree.quarantine_file()).names()) known.insert(tree.log(name));
  if (const auto run = read_tree(tree.run_file()))
    if (const Node* scans = run->find("scans"); scans && scans->is_sequence())
      for (const Node& scan : scans->items()) known.insert(tree.log(text_in(scan, "name")));
  if (const auto logs = store::list_files(tree.root() + "/logs"))
    for (const std::string& log : *logs)
      if (const std::string path = tree.root() + "/logs/" + log; log.ends_with(".log") && !known.contains(path))
        found.emplace_back(path, "the log of a scan that is gone");
  return found;
}

}  // namespace

int show_status(const std::string& out, Console& console) {
  const OutputTree tree(out);
  if (!is_output(tree)) return no_output(out, console);
  const Live live = look_at_run(tree);
  const auto run = read_tree(tree.run_file());
  Node event = Console::event("status");
  event.set("out", out);
  std::string text;
  if (live.tree) {
    const char* state = live.is_alive ? "running" : live.is_here ? "killed" : "elsewhere";
    event.set("state", state);
    event.set("live", *live.tree);
    event.set("silent_s", silence_of(live));
    const std::string who = "pid " + std::to_string(static_cast<long>(number_in(*live.tree, "pid"))) + " on " +
                            text_in(*live.tree, "host") + ", job " + text_in(*live.tree, "job");
    const double silence = silence_of(live);
    const bool stops = is_stopping(*live.tree);
    text = live.is_alive ? (stops ? "stopping, running for " : "running for ") +
                               clock_text(number_in(*live.tree, "seconds") + silence) + " h: " + who +
                               silence_text(silence) + stopped_text(*live.tree)
           : live.is_here ? "the run was killed, last sign " + text_in(*live.tree, "heartbeat") + ": " + who +
                                "\nrun the job again: it goes on where this one was"
                          : "running on another machine, last sign " + text_in(*live.tree, "heartbeat") + ": " + who;
    if (const Node* counts = live.tree->find("counts"); counts && counts->is_map())
      text += "\n" + count_line(*counts, live.is_here && !live.is_alive);
    if (const Node* running = live.tree->find("running"); running && running->is_sequence() && live.is_alive)
      text += running_lines(*running, silence);
    if (const double left = number_in(*live.tree, "seconds_left"); left > 0 && live.is_alive)
      text += "\nabout " + clock_text(left) + " h left";
    if (const std::string remark = text_in(*live.tree, "remark"); !remark.empty()) text += "\n" + remark;
  } else if (run) {
    const Node* exit = run->find("exit");
    const bool ended = exit && exit->is_integer();
    event.set("state", ended ? "ended" : "killed");
    Node counts = Node::map();
    if (const Node* scans = run->find("scans"); scans && scans->is_sequence())
      for (const Node& scan : scans->items()) {
        const std::string state = text_in(scan, "state");
        const Node* count = counts.find(state);
        counts.set(state, (count ? count->as_integer() : 0) + 1);
      }
    text =
        (ended ? "no run; the last ended " + text_in(*run, "ended") + " with exit " + std::to_string(exit->as_integer())
               : std::string("no run; the last was killed: run the job again, it goes on there")) +
        "\n" + count_line(counts);
    event.set("counts", std::move(counts));
  } else {
    event.set("state", "empty");
    text = "no run yet";
  }
  if (!live.is_alive && (!live.tree || live.is_here)) {
    text += text_of_parts(look_at_parts(tree));
    text += text_of_waves(tree, out);
  }
  const auto quarantined = Quarantine::load(tree.quarantine_file()).names();
  event.set("quarantined", static_cast<std::uint64_t>(quarantined.size()));
  if (!quarantined.empty())
    text += "\n" + counted(quarantined.size(), "scan") + " in quarantine, the first is " + quarantined.front() +
            "; scanmill retry " + out + " tries again";
  console.result(text, event);
  return kExitGood;
}

int cancel_run(const std::string& out, Console& console) {
  const OutputTree tree(out);
  if (!is_output(tree)) return no_output(out, console);
  const Live live = look_at_run(tree);
  Node event = Console::event("cancel");
  event.set("out", out);
  if (!live.tree || (live.is_here && !live.is_alive)) {
    event.set("asked", false);
    // Its work on a cluster outlives a driver that was killed.
    if (const auto rested = wait_for_no_task(tree); !rested) {
      console.complain(rested.error());
      return kExitBusy;
    }
    const std::size_t closed = abandon_waves(tree, false);
    console.result(out + ": no run to stop" +
                       (closed > 0 ? "; took back " + counted(closed, "array") + " that a run before had left" : ""),
                   event);
    return kExitGood;
  }
  if (auto written = store::write_text(tree.cancel_file(), utc_now() + "\n"); !written) {
    console.complain(written.error());
    return kExitInternal;
  }
  event.set("asked", true);
  if (is_stopping(*live.tree)) {
    console.result(out + ": asked to stop before; what is at work is stopped at once now", event);
    return kExitGood;
  }
  console.result(out + ": asked pid " + std::to_string(static_cast<long>(number_in(*live.tree, "pid"))) + " on " +
                     text_in(*live.tree, "host") +
                     " to bring its scans to the end and stop; ask once more to stop at once",
                 event);
  return kExitGood;
}

int collect_garbage(const std::string& out, bool dry_run, Console& console) {
  const OutputTree tree(out);
  if (!is_output(tree)) return no_output(out, console);
  std::string held_by;
  const auto lock = OutputLock::take(tree.lock_file(), held_by);
  if (!lock) {
    console.complain(lock.error());
    return held_by.empty() ? kExitInternal : kExitBusy;
  }
  const KeptParts parts = look_at_parts(tree);
  if (!parts.wanted.empty()) {
    const std::string text = "kept " + tree.parts() + ": " + bytes_text(parts.bytes) + " of parts of " +
                             counted(parts.wanted.size(), "scan") + " to be made, from which the next run goes on";
    Node event = Console::event("note");
    event.set("text", text);
    console.result(text, event);
  }
  const auto garbage = garbage_of(tree, parts);
  for (const auto& [path, reason] : garbage) {
    Node event = Console::event("gc");
    event.set("path", path);
    event.set("reason", reason);
    event.set("removed", !dry_run);
    console.result((dry_run ? "would remove " : "removed ") + path + ": " + reason, event);
    if (dry_run) continue;
    if (auto removed = store::remove_tree(path); !removed) {
      console.complain(removed.error());
      return kExitInternal;
    }
  }
  if (garbage.empty()) {
    Node event = Console::event("note");
    event.set("text", "nothing to remove");
    console.result(out + ": nothing to remove", event);
  }
  return kExitGood;
}

bool is_held(const std::string& out, Console& console) {
  const OutputTree tree(out);
  if (!is_output(tree)) return false;
  std::string held_by;
  const auto lock = OutputLock::take(tree.lock_file(), held_by);
  if (lock || held_by.empty()) return false;  // what else is wrong is told by the run that writes
  console.complain(lock.error());
  return true;
}

Result<RunOptions> release_scans(const std::string& out, const std::vector<std::string>& patterns, Console& console) {
  const OutputTree tree(out);
  const auto run = read_tree(tree.run_file());
  const Node* job = run ? run->find("job") : nullptr;
  if (!job || text_in(*job, "absolute").empty())
    return fail(Code::BadUsage, "found no run.json of a run; name the output folder of a run", out);
  RunOptions options;
  options.out = out;
  options.job = text_in(*job, "absolute");
  if (const Node* sets = job->find("set"); sets && sets->is_sequence())
    for (const Node& set : sets->items())
      if (set.is_string()) options.sets.push_back(set.as_string());
  std::set<std::string> bad;
  Quarantine quarantine = Quarantine::load(tree.quarantine_file());
  for (const std::string& name : quarantine.names()) bad.insert(name);
  if (const Node* scans = run->find("scans"); scans && scans->is_sequence())
    for (const Node& scan : scans->items())
      if (const std::string state = text_in(scan, "state"); state == "failed" || state == "stale")
        bad.insert(text_in(scan, "name"));
  for (const std::string& pattern : patterns)
    if (std::none_of(bad.begin(), bad.end(), [&](const std::string& name) { return matches(pattern, name); }))
      return fail(Code::BadUsage,
                  "found no failed or quarantined scan that matches '" + pattern + "'" +
                      (bad.empty() ? std::string("; there is none at all") : "; the first is " + *bad.begin()),
                  out);
  for (const std::string& name : bad)
    if (matches_any(patterns, name)) options.only.push_back(name);
  // --only tries them whatever the quarantine says; what succeeds leaves it, what fails again stays.
  Node event = Console::event("note");
  event.set("text", counted(options.only.size(), "scan") + " to try again");
  console.result(out + ": " + counted(options.only.size(), "scan") + " to try again", event);
  return options;
}

}  // namespace scanmill::runner
