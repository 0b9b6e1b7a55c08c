// SPDX-License-Identifier: Apache-2.0
#include "runner/driver.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <set>
#include <string_view>

#include "base/text.hpp"
#include "runner/executor.hpp"
#include "runner/forecast.hpp"
#include "runner/glob.hpp"
#include "runner/job_scans.hpp"
#include "runner/journal.hpp"
#include "runner/known_names.hpp"
#include "runner/machine.hpp"
#include "runner/output_lock.hpp"
#include "runner/output_tree.hpp"
#include "runner/quarantine.hpp"
#include "runner/ro_crate.hpp"
#include "runner/run_files.hpp"
#include "runner/run_report.hpp"
#include "runner/scan_messages.hpp"
#include "runner/scheduler.hpp"
#include "runner/slurm_executor.hpp"
#include "runner/slurm_waves.hpp"
#include "runner/task_signs.hpp"
#include "store/files.hpp"

namespace scanmill::runner {
namespace {

using document::Node;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

// The driver's own: measured 47 MB for 100 scans (14 of them the program, which workers share), 51 for 1,500 that were
// made, 69 for 10,000 that were unchanged.
constexpr std::uint64_t kDriverMemory = 32ull << 20, kDriverScanMemory = 5ull << 10;  // the latter from 100 on
// Of a worker that makes a scan of 2 MB: 70 MB with 1 thread, 94 with 7, 136 with 16.
constexpr std::uint64_t kWorkerMemory = 80ull << 20, kThreadMemory = 6ull << 20;

class Driver {
 public:
  Driver(const RunOptions& options, Work& work, Console& console, Stop& stop)
      : options_(options), work_(work), console_(console), stop_(stop), tree_(out_of(options)) {
    report_.version = options.version;
    report_.libraries = options.libraries;
    report_.job_path = options.job;
    report_.job_absolute = std::filesystem::absolute(options.job).lexically_normal().string();
    report_.out = tree_.root();
    report_.sets = options.sets;
    report_.only = options.only;
    report_.dry_run = options.dry_run;
    report_.host = host_name();
    report_.pid = static_cast<int>(getpid());
    report_.started = utc_now();
  }

  int run() {
    int code = prepare();
    if (code == kExitGood) code = run_scans();
    return finish(code);
  }

 private:
  static std::string out_of(const RunOptions& options) {
    if (options.out.empty()) return std::filesystem::path(options.job).stem().string() + ".out";
    std::string out = options.out;
    while (out.size() > 1 && out.back() == '/') out.pop_back();
    return out;
  }

  /// Everything that is judged before the first scan. Nothing is written by a dry run.
  int prepare() {
    auto job = load_job(options_.job, options_.sets, work_);
    if (!job) return refuse(job.error(), kExitUsage);
    job_ = *std::move(job);
    report_.job_text = job_.text;
    report_.archive = job_.archive;
    report_.archive_absolute = std::filesystem::absolute(job_.archive).lexically_normal().string();
    report_.threads = static_cast<int>(options_.threads   ? options_.threads
                                       : job_.how.threads ? job_.how.threads
                                       : is_slurm()       ? 1
                                                          : usable_cores());
    report_.memory_cap = options_.memory   ? options_.memory
                         : job_.how.memory ? job_.how.memory
                         : is_slurm()      ? cluster_memory(job_.how.cluster, knows_memory_)
                                           : usable_memory() / 10 * 8;
    if (options_.disk) job_.how.disk = options_.disk;
    if (is_slurm()) job_.how.brick.cut_from = kCutFrom;
    if (auto enough = check_cap(); !enough) return refuse(enough.error(), kExitUsage);
    if (report_.memory_cap > 0 && in_this_process())
      if (auto capped = cap_memory(report_.memory_cap); !capped) return refuse(capped.error(), kExitUsage);

    if (auto apart = check_out_of_archive(tree_, job_.archive); !apart) return refuse(apart.error(), kExitUsage);
    auto selection = select_scans(job_, options_.only, work_);
    if (!selection) {
      const int code = exit_code_of(selection.error());
      return refuse(selection.error(),
                    code == kExitScans ? kExitUsage : code);  // the archive as a whole, no single scan
    }
    selection_ = *std::move(selection);
    if (auto enough = check_cap(); !enough) return refuse(enough.error(), kExitUsage);
    report_.notes = selection_.notes;
    if (const std::uint64_t there = usable_memory(); !is_slurm() && there > 0 && report_.memory_cap > there)
      report_.notes.push_back("memory cap: found " + bytes_text(report_.memory_cap) +
                              "; this machine, or its control group, has " + bytes_text(there) +
                              ": the system may kill what takes more");
    note_idle_cut();
    for (const std::string& note : report_.notes) console_.note("", note);
    report_.scans.reserve(selection_.scans.size());
    for (const SelectedScan& scan : selection_.scans) {
      ScanEntry entry;
      entry.name = scan.task.name;
      entry.notes = scan.task.notes;
      report_.scans.push_back(std::move(entry));
    }
    if (!options_.dry_run)
      if (const int code = take_output(); code != kExitGood) return code;
    if (const auto source = store::exists(tree_.hashes_file())
                                ? store::open_file(tree_.hashes_file(), tree_.hashes_file())
                                : Result<std::shared_ptr<const ByteSource>>(fail(Code::BadInput, ""));
        source)
      if (const auto text = read_all(**source, 1ull << 30)) work_.load_hashes(*text);
    quarantine_ = Quarantine::load(tree_.quarantine_file());
    if (!options_.dry_run) show_beginning();
    if (!options_.only.empty()) return kExitGood;
    list_vanished();
    note_lost();
    if (options_.dry_run) return kExitGood;
    if (auto kept = save_names(selection_.all_names, tree_); !kept) return give_up(kept.error());
    return kExitGood;
  }

  /// A cap under which no scan can be made is a slip, not a night of failures.
  Result<void> check_cap() const {
    if (report_.memory_cap == 0) return {};
    const std::uint64_t least = (is_inline() ? 0 : driver_memory()) + kWorkerMemory +
                                kThreadMemory * static_cast<std::uint64_t>(report_.threads);
    if (report_.memory_cap < least)
      return fail(Code::BadUsage,
                  "found " + bytes_text(report_.memory_cap) + "; a run with " +
                      counted(static_cast<std::uint64_t>(report_.threads), "thread") +
                      (selection_.scans.empty() ? "" : " over " + counted(selection_.scans.size(), "scan")) +
                      " needs " + bytes_text(least) +
                      " before the first point is read; give at least that, or fewer threads",
                  "memory cap");
    return {};
  }

  int take_output() {
    if (auto made = tree_.prepare(); !made) return refuse(made.error(), kExitInternal);
    std::string held_by;
    auto lock = OutputLock::take(tree_.lock_file(), held_by);
    if (!lock) return refuse(lock.error(), held_by.empty() ? kExitInternal : kExitBusy);
    lock_ = std::make_unique<OutputLock>(*std::move(lock));
    if (auto rested = wait_for_no_task(tree_); !rested) return refuse(rested.error(), kExitBusy);
    abandon_waves(tree_, is_slurm());
    if (!has_open_waves(tree_))
      if (auto removed = tree_.remove_leftovers(); !removed) return give_up(removed.error());
    (void)store::remove_tree(tree_.cancel_file());  // meant for a run before this one
    if (tree_.is_unwritable())
      return give_up(fail(Code::NoSpace,
                          "takes no more files: the disk is full or the folder is not writable; free space or choose "
                          "another --out",
                          tree_.root()));
    return save_report();
  }

  int refuse(const Error& error, int code) {
    console_.complain(error);
    return code;
  }

  /// Keys of a cut that cuts nothing.
  void note_idle_cut() {
    const BrickKeys& keys = job_.how.brick;
    if (keys.edge_bins > 0) return note_uncut();
    if (keys.pieces == 0 && keys.batches == 0) return;
    for (const SelectedScan& scan : selection_.scans)
      if (keys.cut_from > 0 && work_.look_at(scan.number).bytes >= keys.cut_from) return;
    report_.notes.push_back(std::string("brick.") + (keys.pieces > 0 ? "pieces" : "batches") +
                            " does nothing here: no scan of this run is cut without brick.edge_bins; give it, 256 say");
  }

  /// Scans that no brick can be made of.
  void note_uncut() {
    std::vector<std::string> uncut;
    for (const SelectedScan& scan : selection_.scans)
      if (scan.what && work_.parts_of(scan.number, *scan.what, job_.how.brick, "").waves.empty())
        uncut.push_back(scan.task.name);
    if (uncut.empty()) return;
    report_.notes.push_back("brick.edge_bins does nothing for " + counted(uncut.size(), "scan") + " (" + uncut.front() +
                            (uncut.size() > 1 ? " first" : "") +
                            "): a lattice from target_points, target_bins or origin: bounds, poses that are refined, "
                            "and files that cannot be read are made in one piece");
  }

  /// The output takes nothing: say so once, and do not try to write the rest.
  int give_up(const Error& error) {
    lock_.reset();
    return refuse(error, kExitInternal);
  }

  /// What a log of many nights needs to be read.
  void show_beginning() {
    const std::string line = report_.started + "  scanmill " + report_.version + ", job " + report_.job_path + " -> " +
                             tree_.root() + ", " + std::to_string(selection_.scans.size()) + " of " +
                             counted(selection_.all_names.size(), "scan") + ", " +
                             counted(static_cast<std::uint64_t>(report_.threads), "thread") +
                             (!knows_memory_       ? ", memory of the nodes not known"
                              : report_.memory_cap ? ", " + bytes_text(report_.memory_cap) + " of memory"
                                                   : "");
    if (!knows_memory_)
      console_.note("", "Slurm does not say how much memory its nodes have; elements ask for " +
                            bytes_text(report_.memory_cap) + " at most, unless resources.memory says otherwise");
    if (console_.style() == ProgressStyle::Plain) console_.remark(line);
  }

  void list_vanished() {
    const std::set<std::string_view> there(selection_.all_names.begin(), selection_.all_names.end());
    for (const std::string& name : tree_.finished()) {
      if (there.contains(name)) continue;
      ScanEntry entry;
      entry.name = name;
      entry.fate = ScanFate::Vanished;
      entry.notes.push_back("the archive no longer holds this scan; its result is kept");
      entry.files = result_files(tree_, name);
      report_.scans.push_back(std::move(entry));
    }
    if (const auto gone = report_.count(ScanFate::Vanished); gone > 0)
      console_.note("", counted(gone, "scan") + (gone == 1 ? " is" : " are") + " no longer in the archive, such as " +
                            report_.scans.back().name + "; the results are kept");
  }

  /// Scans that went before they ever had a result: said once, since nothing of them is left to list.
  void note_lost() {
    std::set<std::string> known = load_names(tree_);
    for (const std::string& name : quarantine_.names()) known.insert(name);
    for (const std::string& name : selection_.all_names) known.erase(name);
    std::erase_if(known, [&](const std::string& name) { return !matches_any(job_.scans, name); });
    for (const std::string& name : known) quarantine_.remove(name);
    std::erase_if(known, [&](const std::string& name) { return load_state(tree_.scan(name)).has_value(); });
    if (known.empty()) return;
    report_.notes.push_back(counted(known.size(), "scan") + " without a result vanished from the archive: " +
                            *known.begin() + (known.size() > 1 ? " and so on" : ""));
    console_.note("", report_.notes.back());
  }

  int run_scans() {
    if (!options_.dry_run) {
      Node head = Node::map();
      head.set("type", "run");
      head.set("host", report_.host);
      head.set("pid", report_.pid);
      head.set("job", report_.job_path);
      head.set("version", report_.version);
      auto journal = Journal::begin(tree_.journal(), std::move(head));
      if (!journal) return refuse(journal.error(), kExitInternal);
      journal_ = std::make_unique<Journal>(*std::move(journal));
    }
    const ScanMaker maker({options_,
                           tree_,
                           work_,
                           quarantine_,
                           stop_,
                           report_.host,
                           shared_memory(),
                           report_.memory_cap,
                           job_.how.disk,
                           is_inline() ? 0 : job_.how.scan_time_limit_s,
                           journal_ ? journal_->epoch() : 0,
                           job_.how.brick,
                           {}});
    auto executor = executor_for(maker);
    Scheduler scheduler({options_, job_.how, tree_, selection_, maker, work_, console_, stop_, report_, quarantine_,
                         journal_.get(), *executor, shared_memory(), in_this_process(),
                         [this] { return save_report(); }, [this](const Error& error) { console_.complain(error); }});
    const int code = scheduler.run();
    executor.reset();
    if (is_slurm()) {
      abandon_waves(tree_, false);
      (void)tree_.remove_leftovers();  // of tasks whose node was lost
    }
    if (options_.dry_run && code == kExitGood) show_forecast(maker);
    if (journal_) {
      Node tail = Node::map();
      tail.set("type", "left");
      tail.set("signal", stop_.signal.load());
      journal_->add(std::move(tail));
      if (auto kept = journal_->commit(true); !kept && code == kExitGood) return refuse(kept.error(), kExitInternal);
    }
    return code;
  }

  /// How a scan that is cut will be made; reads its points.
  std::vector<ForecastWave> waves_of(const SelectedScan& scan, const ScanMaker& maker, std::uint64_t bytes) {
    const CutParts parts = maker.parts_of(scan);
    if (parts.waves.empty()) return {};
    const ChunkLoop loop(report_.threads);
    console_.begin(scan.task.name);
    auto forecast =
        work_.forecast_parts(scan.number, *scan.what, job_.how.brick, parts.folder, {loop, stop_.flag}, console_);
    console_.end();
    if (!forecast) console_.note(scan.task.name, "no forecast of its parts: " + forecast.error().text());
    if (!forecast || !*forecast) return {};
    if (const std::uint64_t most = std::ranges::max((*forecast)->disk); job_.how.disk > 0 && most > job_.how.disk)
      console_.note(scan.task.name, "would be refused: its parts and results need " + bytes_text(most) +
                                        " of disk at one time; found " + bytes_text(job_.how.disk) +
                                        " that resources.disk (--disk) allows the run");
    return runner::waves_of(parts, **forecast, bytes);
  }

  void show_forecast(const ScanMaker& maker) {
    Forecast forecast;
    forecast.cores = report_.threads;
    forecast.bytes_per_core_second = speed_of(tree_.journal());
    for (std::size_t i = 0; i < selection_.scans.size(); ++i) {
      const ScanEntry& entry = report_.scans[i];
      const std::uint64_t bytes = work_.look_at(selection_.scans[i].number).bytes;
      const char* verb = entry.fate == ScanFate::Pending ? "run" : name_of(entry.fate);
      forecast.tasks.push_back({entry.name, verb, entry.why, bytes, memory_guess(bytes)});
      if (entry.fate == ScanFate::Pending) forecast.tasks.back().waves = waves_of(selection_.scans[i], maker, bytes);
    }
    if (options_.dag == "dot") return console_.print(to_dot(forecast));
    if (options_.dag == "json") return console_.print(document::to_json(to_document(forecast), 1) + "\n");
    std::string lines = line_of(forecast);
    for (const ForecastTask& task : forecast.tasks)
      if (!task.waves.empty()) lines += "\n" + table_of(forecast, task);
    console_.result(lines, to_document(forecast));
  }

  bool is_inline() const {
    return options_.executor.empty() ? job_.how.in_this_process : options_.executor == "inline";
  }
  bool is_slurm() const {
    return !options_.dry_run && (options_.executor.empty() ? job_.how.on_cluster : options_.executor == "slurm");
  }
  bool in_this_process() const { return options_.dry_run || is_inline(); }

  /// What scans may use together: with processes of their own, this one takes its part.
  std::uint64_t shared_memory() const {
    return report_.memory_cap == 0 || in_this_process() || is_slurm() ? report_.memory_cap
                                                                      : report_.memory_cap - driver_memory();
  }
  std::uint64_t driver_memory() const {
    const std::uint64_t scans = selection_.scans.size();
    return kDriverMemory + kDriverScanMemory * (scans > 100 ? scans - 100 : 0);
  }

  std::unique_ptr<Executor> executor_for(const ScanMaker& maker) {
    const std::string of = "/" + std::to_string(selection_.scans.size()) + "] ";
    auto make = [this, &maker, of](const Order& order, Progress& progress) {
      const SelectedScan& scan = selection_.scans[order.scan];
      if (in_this_process()) console_.begin("[" + std::to_string(order.scan + 1) + of + scan.task.name);
      const ScanEntry& entry = report_.scans[order.scan];
      Attempt attempt = order.part.empty()
                            ? maker.make(scan, entry, order.threads, order.memory, progress)
                            : maker.make_part(scan, entry, order.part, order.threads, order.memory, progress);
      if (in_this_process()) console_.end();
      return attempt;
    };
    if (in_this_process()) return make_inline_executor(std::move(make), console_);
    if (is_slurm()) return slurm_executor();
    LocalOptions local;
    local.time_limit_s = job_.how.scan_time_limit_s;
    local.in_child = [this] {
      if (lock_) lock_->forget();
      if (journal_) journal_->forget();
      stop_.drains.store(false);
    };
    stop_.drains.store(true);
    return make_local_executor(std::move(make), std::move(local));
  }

  std::unique_ptr<Executor> slurm_executor() {
    stop_.drains.store(true);
    TaskFile frame;
    frame.version = report_.version;
    frame.out = std::filesystem::absolute(tree_.root()).lexically_normal().string();
    frame.job_path = report_.job_absolute;
    frame.job_text = job_.text;
    frame.job_shown = options_.job;
    frame.sets = options_.sets;
    frame.forced = !options_.only.empty();
    frame.memory_cap = shared_memory();
    frame.time_limit_s = job_.how.scan_time_limit_s;
    frame.lease_s = job_.how.cluster.lease_s;
    return make_slurm_executor(
        {job_.how.cluster, tree_, selection_, stop_, std::move(frame), speed_of(tree_.journal()), report_.memory_cap,
         [this](std::size_t scan) { return work_.look_at(selection_.scans[scan].number).bytes; },
         [this](std::size_t scan) -> const ScanEntry& { return report_.scans[scan]; },
         [this](const std::string& scan, const std::string& text) { console_.note(scan, text); }});
  }

  Result<void> save_run() const {
    TRY_ASSIGN(const auto sink, store::create_file(tree_.run_file()));
    TRY(write_run(report_, *sink));
    return sink->commit();
  }

  int save_report() {
    report_.seconds = seconds_since(began_);
    auto saved = save_run();
    report_.written = report_.written || saved.ok();
    return saved ? kExitGood : refuse(saved.error(), kExitInternal);
  }

  /// The results that stand, for catalogues.
  Result<void> save_crate() const {
    const auto result_of = [&](const ScanEntry& entry) -> std::optional<CrateScan> {
      auto state = load_state(tree_.scan(entry.name));
      if (!state) return std::nullopt;
      return CrateScan{entry.name, entry.fate == ScanFate::Done, std::move(*state)};
    };
    TRY_ASSIGN(const auto sink, store::create_file(tree_.root() + "/ro-crate-metadata.json"));
    TRY(write_ro_crate(report_, result_of, {"run.json"}, *sink));
    return sink->commit();
  }

  /// The worst code in the order 130/143, 1, 3, 4; state files, run.json, last line.
  int finish(int code) {
    const int signal = stop_.signal.load();
    const bool bad = report_.count(ScanFate::Failed) + report_.count(ScanFate::Stale) > 0 ||
                     (job_.how.strict && report_.count(ScanFate::Quarantined) > 0);
    if (code == kExitGood && bad) code = kExitScans;
    if (code == kExitGood && report_.rejected() > 0) code = kExitGate;
    if (code == kExitGood && report_.put_off > 0) code = kExitBusy;
    if (signal != 0 && (lock_ || code == kExitGood)) code = 128 + signal;
    report_.ended = utc_now();
    report_.exit_code = code;
    report_.seconds = seconds_since(began_);
    if (lock_) {
      auto kept = quarantine_.save(tree_.quarantine_file());
      if (kept) kept = store::write_text(tree_.hashes_file(), work_.save_hashes());
      if (kept) kept = save_run();
      report_.written = report_.written || kept.ok();
      std::vector<std::string> notes;
      if (kept) kept = write_run_files(report_, work_, tree_, notes);
      report_.has_page = kept.ok() && report_.only.empty() && store::exists(tree_.page_file());
      for (const std::string& note : notes) console_.note("", note);
      if (kept && !options_.dry_run) kept = save_crate();
      if (!kept) {
        console_.complain(kept.error());
        if (code < 128) report_.exit_code = code = kExitInternal;
      }
    }
    if (!options_.dry_run && (lock_ || code != kExitBusy))
      for (const std::string& note : notify(job_.how.notify, report_, tree_)) console_.note("", note);
    if (options_.dag.empty()) console_.last(last_line(report_), last_event(report_));
    return code;
  }

  const RunOptions& options_;
  Work& work_;
  Console& console_;
  Stop& stop_;
  OutputTree tree_;
  RunReport report_;
  Job job_;
  Selection selection_;
  bool knows_memory_ = true;
  Quarantine quarantine_;
  std::unique_ptr<OutputLock> lock_;
  std::unique_ptr<Journal> journal_;
  Clock::time_point began_ = Clock::now();
};

}  // namespace

int exit_code_of(const Error& error) {
  switch (error.code) {
    case Code::BadUsage:
    case Code::BadParameter:
      return kExitUsage;
    case Code::Unsupported:
    case Code::BadInput:
      return kExitScans;
    default:
      return kExitInternal;
  }
}

int run_job(const RunOptions& options, Work& work, Console& console, Stop& stop) {
  return Driver(options, work, console, stop).run();
}

JobCheck check_job(const std::string& path, std::span<const std::string> sets, Work& work) {
  const auto job = load_job(path, sets, work);
  if (!job) return {lines_of(job.error().text()), {}};
  const auto selection = select_scans(*job, {}, work);
  if (!selection) return {lines_of(selection.error().text()), {}};
  JobCheck check;
  for (const SelectedScan& scan : selection->scans)
    if (scan.task.is_of_job && !scan.task.broken.empty()) check.problems.push_back(path + ": " + scan.task.broken);
  check.notes = selection->idle;
  return check;
}

}  // namespace scanmill::runner
