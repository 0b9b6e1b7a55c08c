// SPDX-License-Identifier: Apache-2.0
#include "runner/write_worklist.hpp"

#include <algorithm>
#include <filesystem>
#include <map>

#include "base/text.hpp"
#include "runner/forecast.hpp"
#include "runner/job_scans.hpp"
#include "runner/output_lock.hpp"
#include "runner/output_tree.hpp"
#include "runner/pack_tasks.hpp"
#include "runner/quarantine.hpp"
#include "runner/scan_maker.hpp"
#include "runner/slurm_waves.hpp"
#include "runner/task_file.hpp"
#include "runner/task_signs.hpp"
#include "runner/worklist.hpp"
#include "store/files.hpp"

namespace scanmill::runner {
namespace {

namespace fs = std::filesystem;
using document::Node;

std::string absolute(const std::string& path) { return fs::absolute(path).lexically_normal().string(); }

std::string out_of(const RunOptions& options) {
  std::string out = options.out.empty() ? fs::path(options.job).stem().string() + ".out" : options.out;
  while (out.size() > 1 && out.back() == '/') out.pop_back();
  return out;
}

/// Places in the selection of the scans that need work.
std::vector<std::size_t> scans_to_make(const WorklistOptions& options, const Job& job, const OutputTree& tree,
                                       const Selection& selection, Work& work) {
  const Quarantine quarantine = Quarantine::load(tree.quarantine_file());
  const Stop stop;
  const ScanMaker maker({options.run, tree, work, quarantine, stop, "", 0, 0, 0, job.how.scan_time_limit_s, 0, {}, {}});
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < selection.scans.size(); ++i) {
    ScanEntry entry;
    entry.name = selection.scans[i].task.name;
    if (maker.judge(selection.scans[i], std::move(entry)).needs_work) found.push_back(i);
  }
  return found;
}

TaskFile tasks_of(const WorklistOptions& options, const Job& job, const OutputTree& tree, const Selection& selection,
                  const std::vector<std::size_t>& scans, Work& work) {
  TaskFile file;
  file.version = options.run.version;
  file.token = new_token();
  file.out = absolute(tree.root());
  file.job_path = absolute(options.run.job);
  file.job_shown = options.run.job;
  file.job_text = job.text;
  file.sets = options.run.sets;
  file.forced = !options.run.only.empty();
  file.time_limit_s = job.how.scan_time_limit_s;
  file.lease_s = job.how.cluster.lease_s;
  const auto threads = static_cast<int>(std::max<std::int64_t>(1, options.run.threads));
  const double speed = speed_of(tree.journal());
  const auto bytes_of = [&](std::size_t i) { return work.look_at(selection.scans[i].number).bytes; };
  std::vector<ScanLoad> loads;
  double seconds = 0;
  for (const std::size_t i : scans) {
    loads.push_back({i, forecast_seconds(bytes_of(i), speed, threads)});
    seconds += loads.back().seconds;
  }
  PackRule rule;
  if (options.tasks > 0) rule = {seconds + 1, static_cast<std::size_t>(options.tasks), 0};
  std::map<std::shared_ptr<const Node>, std::size_t> keys;
  const auto item_of = [&](std::size_t i) -> TaskItem {
    const SelectedScan& scan = selection.scans[i];
    const auto [at, is_new] = keys.emplace(scan.what, file.keys.size());
    if (is_new) file.keys.push_back(*scan.what);
    return {scan.task.name, at->second, bytes_of(i), {}};
  };
  // Large scans: a task for each of their parts, then one that puts them together.
  std::vector<Task> of_parts;
  BrickKeys bricks = job.how.brick;
  bricks.cut_from = kCutFrom;
  for (const std::size_t i : scans) {
    const SelectedScan& scan = selection.scans[i];
    const CutParts parts = work.parts_of(scan.number, *scan.what, bricks, tree.parts(scan.task.name));
    if (parts.waves.empty()) continue;
    std::erase_if(loads, [&](const ScanLoad& load) { return load.scan == i; });
    TaskItem item = item_of(i);
    Task task;
    task.threads = threads;
    task.memory = memory_class(memory_guess(item.bytes), options.run.memory);
    for (const auto& wave : parts.waves) {
      for (const std::string& part : wave) {
        task.items = {item};
        task.items.front().part = part;
        task.items.front().bytes = std::max<std::uint64_t>(1, item.bytes / wave.size());
        of_parts.push_back(task);
      }
      ++task.wave;
    }
    task.items = {item};
    of_parts.push_back(task);
  }
  for (const auto& packed : pack_tasks(std::move(loads), rule)) {
    Task task;
    task.threads = threads;
    for (const std::size_t i : packed) {
      task.items.push_back(item_of(i));
      task.memory = std::max(task.memory, memory_class(memory_guess(bytes_of(i)), options.run.memory));
    }
    file.tasks.push_back(std::move(task));
  }
  for (Task& task : of_parts) file.tasks.push_back(std::move(task));
  std::stable_sort(file.tasks.begin(), file.tasks.end(), [](const Task& a, const Task& b) { return a.wave < b.wave; });
  return file;
}

Result<TaskFile> write(const WorklistOptions& options, Work& work, std::string& path) {
  TRY_ASSIGN(const Job job, load_job(options.run.job, options.run.sets, work));
  const OutputTree tree(out_of(options.run));
  path = options.path.empty() ? tree.root() + "/work/by-hand/" + kTaskFileName : options.path;
  TRY(check_out_of_archive(tree, job.archive));
  TRY_ASSIGN(const Selection selection, select_scans(job, options.run.only, work));
  TRY(tree.prepare());
  std::string held_by;
  TRY_ASSIGN(const OutputLock lock, OutputLock::take(tree.lock_file(), held_by));
  TRY(wait_for_no_task(tree));
  abandon_waves(tree, false);
  const auto scans = scans_to_make(options, job, tree, selection, work);
  TaskFile file = tasks_of(options, job, tree, selection, scans, work);
  if (const auto parent = fs::path(path).parent_path().string(); !parent.empty()) TRY(store::make_folders(parent));
  TRY(store::write_text(path, document::to_json(to_document(file)) + "\n"));
  return file;
}

}  // namespace

int write_worklist(const WorklistOptions& options, Work& work, Console& console) {
  std::string path;
  const auto file = write(options, work, path);
  if (!file) {
    console.complain(file.error());
    return file.error().code == Code::Cancelled ? kExitBusy : exit_code_of(file.error());
  }
  const std::size_t count = file->tasks.size();
  Node event = Console::event("tasks");
  event.set("path", path);
  event.set("tasks", static_cast<std::uint64_t>(count));
  console.result(count == 0 ? path + ": no scan needs work"
                            : path + ": " + counted(count, "task") + "; scanmill task " + path + " 0" +
                                  (count > 1 ? " to " + std::to_string(count - 1) : ""),
                 event);
  if (const auto last = count > 0 ? file->tasks.back().wave : 0; last > 0)
    console.note("",
                 "scans are cut into parts, and tasks have waves 0 to " + std::to_string(last) +
                     ", in this order: a task whose wave comes too early ends with 75 and is to be run again" +
                     (options.tasks > 0 && count > static_cast<std::size_t>(options.tasks)
                          ? "; --tasks " + std::to_string(options.tasks) +
                                " holds for scans in one piece, brick.pieces and brick.batches set the number of parts"
                          : ""));
  return kExitGood;
}

}  // namespace scanmill::runner
