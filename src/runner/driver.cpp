// SPDX-License-Identifier: Apache-2.0
#include "runner/driver.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <new>

#include "base/text.hpp"
#include "runner/job_scans.hpp"
#include "runner/machine.hpp"
#include "runner/output_lock.hpp"
#include "runner/output_tree.hpp"
#include "runner/quarantine.hpp"
#include "runner/run_files.hpp"
#include "runner/run_report.hpp"
#include "runner/scan_log.hpp"
#include "runner/scan_messages.hpp"
#include "runner/scan_state.hpp"
#include "store/files.hpp"

namespace scanmill::runner {
namespace {

using document::Node;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

class Driver {
 public:
  Driver(const RunOptions& options, Work& work, Console& console, const Stop& stop)
      : options_(options), work_(work), console_(console), stop_(stop), tree_(out_of(options)) {
    report_.version = options.version;
    report_.libraries = options.libraries;
    report_.job_path = options.job;
    report_.out = tree_.root();
    report_.sets = options.sets;
    report_.only = options.only;
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
    report_.threads = static_cast<int>(options_.threads   ? options_.threads
                                       : job_.how.threads ? job_.how.threads
                                                          : usable_cores());
    report_.memory_cap = options_.memory   ? options_.memory
                         : job_.how.memory ? job_.how.memory
                                           : usable_memory() / 10 * 8;
    if (report_.memory_cap)
      if (auto capped = cap_memory(report_.memory_cap); !capped) return refuse(capped.error(), kExitUsage);

    auto selection = select_scans(job_, options_.only, work_);
    if (!selection) {
      const int code = exit_code_of(selection.error());
      return refuse(selection.error(),
                    code == kExitScans ? kExitUsage : code);  // the archive as a whole, no single scan
    }
    selection_ = *std::move(selection);
    report_.notes = selection_.notes;
    for (const std::string& note : report_.notes) console_.note("", note);
    for (const SelectedScan& scan : selection_.scans) {
      ScanEntry entry;
      entry.name = scan.task.name;
      entry.notes = scan.task.notes;
      entry.repeat = repeat_command(options_, scan.task.name);
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
    if (options_.only.empty()) list_vanished();
    return kExitGood;
  }

  int take_output() {
    if (auto made = tree_.prepare(); !made) return refuse(made.error(), kExitInternal);
    std::string held_by;
    auto lock = OutputLock::take(tree_.lock_file(), held_by);
    if (!lock) return refuse(lock.error(), held_by.empty() ? kExitInternal : kExitBusy);
    lock_ = std::make_unique<OutputLock>(*std::move(lock));
    if (auto removed = tree_.remove_leftovers(); !removed) return give_up(removed.error());
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

  /// The output takes nothing: say so once, and do not try to write the rest.
  int give_up(const Error& error) {
    lock_.reset();
    return refuse(error, kExitInternal);
  }

  void list_vanished() {
    for (const std::string& name : tree_.finished()) {
      if (std::find(selection_.all_names.begin(), selection_.all_names.end(), name) != selection_.all_names.end())
        continue;
      ScanEntry entry;
      entry.name = name;
      entry.fate = ScanFate::Vanished;
      entry.notes.push_back("the archive no longer holds this scan; its result is kept");
      entry.files = files_of(name);
      report_.scans.push_back(std::move(entry));
    }
  }

  std::vector<std::string> files_of(const std::string& name) const {
    std::vector<std::string> files;
    if (const auto state = load_state(tree_.scan(name)))
      for (const OutputFile& output : state->outputs) files.push_back("scans/" + name + "/" + output.name);
    return files;
  }

  int run_scans() {
    const ChunkLoop loop(report_.threads);
    const Context context{loop, stop_.flag};
    for (std::size_t i = 0; i < selection_.scans.size(); ++i) {
      if (stop_.flag.is_set()) return kExitGood;  // finish() names the signal
      const auto begin = Clock::now();
      console_.begin("[" + std::to_string(i + 1) + "/" + std::to_string(selection_.scans.size()) + "] " +
                     report_.scans[i].name);
      const double cpu = cpu_seconds();
      const std::string started = utc_now();
      const bool go_on = one_scan(selection_.scans[i], report_.scans[i], context);
      ScanEntry& entry = report_.scans[i];
      if (entry.attempts > 0) {
        entry.started = started;
        entry.ended = utc_now();
      }
      entry.seconds = seconds_since(begin);
      entry.cpu_seconds = cpu_seconds() - cpu;
      report_.scans[i].peak_memory = peak_memory();
      console_.end();
      show_scan(report_.scans[i], tree_.root(), options_.explain, options_.dry_run, console_);
      if (!go_on) return kExitInternal;
      if (!options_.dry_run && seconds_since(saved_) > 1)
        if (const int code = save_report(); code != kExitGood) return code;
    }
    return kExitGood;
  }

  /// False when the output takes no more: then nothing that follows could be kept.
  bool one_scan(const SelectedScan& scan, ScanEntry& entry, const Context& context) {
    const std::string& name = scan.task.name;
    console_.stage("check inputs", 0, 0);
    auto fingerprint = work_.fingerprint(scan.number, scan.what);
    const auto state = load_state(tree_.scan(name));
    if (!fingerprint) {
      entry.why = {state ? "its inputs cannot be read" : "new"};
      return failed(scan.task.broken.empty() ? fingerprint.error() : fail(Code::BadInput, scan.task.broken),
                    state.has_value(), nullptr, entry);
    }
    entry.why = reasons_to_run(state, tree_.scan(name), *fingerprint, scan.what);
    if (entry.why.empty()) {
      entry.fate = ScanFate::Unchanged;
      entry.counts = state->counts;
      entry.record_identity = state->record_identity;
      entry.failed_gates = state->failed_gates;
      entry.files = files_of(name);
      return true;
    }
    const Quarantine::Entry* held = options_.only.empty() ? quarantine_.find(name, fingerprint->value) : nullptr;
    if (held) {
      entry.fate = ScanFate::Quarantined;
      entry.error = fail(Code::BadInput, held->error);
      return true;
    }
    if (options_.dry_run) return true;
    if (!scan.task.broken.empty()) {
      const Error broken = fail(Code::BadInput, scan.task.broken);
      if (const auto log = begin_log(scan, entry)) (*log)->line("failed: " + broken.text());
      return failed(broken, state.has_value(), &*fingerprint, entry);
    }
    auto made = make(scan, *fingerprint, entry, context);
    if (!made) return failed(made.error(), state.has_value(), &*fingerprint, entry);
    quarantine_.remove(name);
    entry.fate = ScanFate::Done;
    return true;
  }

  /// A log that says when, with what and why.
  Result<std::unique_ptr<ScanLog>> begin_log(const SelectedScan& scan, const ScanEntry& entry) {
    TRY_ASSIGN(auto log, ScanLog::begin(tree_.log(scan.task.name), console_));
    log->line("scan " + scan.task.name + ", " + utc_now() + ", scanmill " + options_.version + " on " + report_.host +
              ", " + std::to_string(report_.threads) + " threads");
    log->line("why: " + joined_lines(entry.why, "; "));
    log->line("what: " + document::to_canonical_json(scan.what));
    return log;
  }

  /// One attempt, from an empty folder to the switch.
  Result<void> make(const SelectedScan& scan, const Fingerprint& fingerprint, ScanEntry& entry,
                    const Context& context) {
    ++entry.attempts;
    TRY_ASSIGN(const auto log, begin_log(scan, entry));
    TRY_ASSIGN(const std::string folder, tree_.begin_attempt(scan.task.name));
    auto made = fill(scan, fingerprint, folder, entry, context, *log);
    if (made && stop_.flag.is_set()) made = fail(Code::Cancelled, "stopped before the result was put in place");
    if (made) made = tree_.commit(folder, scan.task.name);
    if (!made) {
      log->line("failed: " + made.error().text());
      (void)store::remove_tree(folder);
      return made;
    }
    for (const std::string& note : entry.notes) log->line("note: " + note);
    for (const std::string& gate : entry.failed_gates) log->line("gate failed: " + gate);
    for (const auto& [stage, seconds] : entry.stage_seconds)
      log->line("stage " + stage + " took " + seconds_text(seconds));
    for (const Node::Entry& count : entry.counts.entries())
      log->line(count.key + " " + document::to_canonical_json(count.value));
    log->line("done, record " + entry.record_identity + ", " + utc_now());
    entry.files = files_of(scan.task.name);
    return {};
  }

  Result<void> fill(const SelectedScan& scan, const Fingerprint& fingerprint, const std::string& folder,
                    ScanEntry& entry, const Context& context, Progress& progress) {
    auto outcome = guarded([&] { return work_.run(scan.number, scan.what, folder, context, progress); });
    if (!outcome) return std::move(outcome).error();
    entry.notes.insert(entry.notes.end(), outcome->notes.begin(), outcome->notes.end());
    entry.counts = outcome->counts;
    entry.record_identity = outcome->record_identity;
    entry.stage_seconds = outcome->stage_seconds;
    entry.failed_gates = outcome->failed_gates;
    TRY_ASSIGN(const Fingerprint after, work_.fingerprint(scan.number, scan.what));
    if (after.value != fingerprint.value)
      return fail(Code::BadInput, "an input changed while the scan was made; run again when its writer has finished",
                  scan.task.name);
    ScanState state{fingerprint, scan.what, outcome->counts, outcome->record_identity, outcome->failed_gates, {}};
    return save_state(state, folder);
  }

  template <class F>
  Result<Outcome> guarded(F&& body) const {
    try {
      return body();
    } catch (const std::bad_alloc&) {
      return fail(Code::NoSpace,
                  "the memory cap of " + bytes_text(report_.memory_cap) +
                      " was reached; raise resources.memory (--memory) or choose larger bins",
                  "memory");
    } catch (const std::exception& error) {
      return fail(Code::Internal,
                  std::string("unexpected: ") + error.what() + "; please report it with the scan's log");
    }
  }

  bool failed(const Error& error, bool has_result, const Fingerprint* fingerprint, ScanEntry& entry) {
    entry.error = error;
    entry.failure = class_of(error);
    entry.fate = error.code == Code::Cancelled ? ScanFate::Interrupted
                 : has_result                  ? ScanFate::Stale
                                               : ScanFate::Failed;
    if (has_result) {
      entry.files = files_of(entry.name);
      if (const auto state = load_state(tree_.scan(entry.name))) entry.failed_gates = state->failed_gates;
    }
    if (error.code == Code::Internal) saw_internal_ = true;
    if (error.code == Code::BadInput && fingerprint && !options_.dry_run)
      quarantine_.add(entry.name, {fingerprint->value, error.text()});
    const bool machine = error.code == Code::IoFailed || (error.code == Code::NoSpace && error.where != "memory");
    return !machine || options_.dry_run ||
           !((" " + error.where).find(" " + tree_.root() + "/") != std::string::npos || tree_.is_unwritable());
  }

  int save_report() {
    saved_ = Clock::now();
    report_.seconds = seconds_since(began_);
    auto saved = store::write_text(tree_.run_file(), document::to_json(to_document(report_), 1) + "\n");
    report_.written = report_.written || saved.ok();
    return saved ? kExitGood : refuse(saved.error(), kExitInternal);
  }

  /// The worst code in the order 130/143, 1, 3, 4; state files, run.json, last line.
  int finish(int code) {
    const int signal = stop_.signal.load();
    if (code == kExitGood && saw_internal_) code = kExitInternal;
    const bool bad = report_.count(ScanFate::Failed) + report_.count(ScanFate::Stale) > 0 ||
                     (job_.how.strict && report_.count(ScanFate::Quarantined) > 0);
    if (code == kExitGood && bad) code = kExitScans;
    if (code == kExitGood && report_.rejected() > 0) code = kExitGate;
    if (signal != 0 && (lock_ || code == kExitGood)) code = 128 + signal;
    report_.ended = utc_now();
    report_.exit_code = code;
    report_.seconds = seconds_since(began_);
    if (lock_) {
      auto kept = quarantine_.save(tree_.quarantine_file());
      if (kept) kept = store::write_text(tree_.hashes_file(), work_.save_hashes());
      if (kept) kept = store::write_text(tree_.run_file(), document::to_json(to_document(report_), 1) + "\n");
      report_.written = report_.written || kept.ok();
      std::vector<std::string> notes;
      if (kept) kept = write_run_files(report_, work_, tree_, notes);
      report_.has_page = kept.ok() && report_.only.empty() && store::exists(tree_.page_file());
      for (const std::string& note : notes) console_.note("", note);
      if (!kept) {
        console_.complain(kept.error());
        if (code < 128) report_.exit_code = code = kExitInternal;
      }
    }
    if (!options_.dry_run && code != kExitBusy)
      for (const std::string& note : notify(job_.how.notify, report_, tree_)) console_.note("", note);
    console_.last(last_line(report_), last_event(report_));
    return code;
  }

  const RunOptions& options_;
  Work& work_;
  Console& console_;
  const Stop& stop_;
  OutputTree tree_;
  RunReport report_;
  Job job_;
  Selection selection_;
  Quarantine quarantine_;
  std::unique_ptr<OutputLock> lock_;
  bool saw_internal_ = false;
  Clock::time_point began_ = Clock::now(), saved_{};
};

}  // namespace

int exit_code_of(const Error& error) {
  switch (error.code) {
    case Code::BadUsage:
    case Code::BadParameter:
    case Code::Unsupported:
      return kExitUsage;
    case Code::BadInput:
      return kExitScans;
    default:
      return kExitInternal;
  }
}

int run_job(const RunOptions& options, Work& work, Console& console, const Stop& stop) {
  return Driver(options, work, console, stop).run();
}

std::vector<std::string> check_job(const std::string& path, std::span<const std::string> sets, Work& work) {
  auto job = load_job(path, sets, work);
  auto error = [&]() -> Error {
    if (!job) return job.error();
    auto selection = select_scans(*job, {}, work);
    return selection ? Error{Code::Internal, {}, {}} : selection.error();
  }();
  if (error.message.empty()) return {};
  return lines_of(error.text());
}

}  // namespace scanmill::runner
