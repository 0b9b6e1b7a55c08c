// SPDX-License-Identifier: Apache-2.0
#include "runner/task.hpp"

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "base/text.hpp"
#include "runner/executor.hpp"
#include "runner/job.hpp"
#include "runner/machine.hpp"
#include "runner/output_tree.hpp"
#include "runner/quarantine.hpp"
#include "runner/scan_maker.hpp"
#include "runner/scan_messages.hpp"
#include "runner/task_result.hpp"
#include "store/files.hpp"

namespace scanmill::runner {
namespace {

using Clock = std::chrono::steady_clock;
using document::Node;

constexpr auto kTaskTick = std::chrono::milliseconds(500);
constexpr auto kTaskPatience = std::chrono::seconds(10);
constexpr double kBeatsPerLease = 12;

/// The engine's own name of this task, for people who look for it.
std::string engine_name() {
  const auto of = [](const char* name) {
    const char* value = std::getenv(name);
    return std::string(value ? value : "");
  };
  if (const std::string array = of("SLURM_ARRAY_JOB_ID"); !array.empty())
    return "slurm " + array + "_" + of("SLURM_ARRAY_TASK_ID");
  if (const std::string job = of("SLURM_JOB_ID"); !job.empty()) return "slurm " + job;
  if (!of("JOB_COMPLETION_INDEX").empty()) return "kubernetes " + of("HOSTNAME");
  return "";
}

/// One task on its way.
class TaskRun {
 public:
  TaskRun(const TaskOptions& options, const TaskFile& file, Work& work, Console& console, Stop& stop)
      : options_(options),
        file_(file),
        task_(file.tasks[options.index]),
        folder_(folder_of(options.path)),
        work_(work),
        console_(console),
        stop_(stop),
        tree_(file.out) {
    threads_ = options.threads ? static_cast<int>(options.threads) : task_.threads;
    memory_ = options.memory ? options.memory : task_.memory;
    run_options_.job = file.job_path;
    run_options_.out = file.out;
    run_options_.sets = file.sets;
    run_options_.version = options.version;
    if (file.forced) run_options_.only = {"*"};
  }

  int run() {
    if (auto found = find_scans(); !found) {
      console_.complain(found.error());
      return exit_code_of(found.error());
    }
    const Quarantine quarantine = Quarantine::load(tree_.quarantine_file());
    const ScanMaker maker({run_options_, tree_, work_, quarantine, stop_, host_name(), file_.memory_cap, memory_, 0,
                           file_.time_limit_s, 0, bricks_, [this] { return is_wanted(); }});
    LocalOptions local;
    local.time_limit_s = file_.time_limit_s;
    const auto executor = make_local_executor(
        [&](const Order& order, Progress& progress) {
          const SelectedScan& scan = scans_[order.scan];
          if (!order.part.empty())
            return maker.make_part(scan, first_entry(order.scan), order.part, order.threads, order.memory, progress);
          return maker.make(scan, first_entry(order.scan), order.threads, order.memory, progress);
        },
        local);
    beat_path_ = folder_ + "/" + heartbeat_name(options_.index, host_name(), static_cast<int>(getpid()));
    for (std::size_t item = 0; item < task_.items.size() && goes_on(); ++item) make(item, *executor);
    (void)unlink(beat_path_.c_str());
    if (stop_.signal != 0) return 128 + stop_.signal;
    return died_ ? kExitInternal : later_ ? kExitBusy : failed_ ? kExitScans : rejected_ ? kExitGate : kExitGood;
  }

 private:
  static std::string folder_of(const std::string& path) {
    const auto parent = std::filesystem::path(path).parent_path().string();
    return parent.empty() ? "." : parent;
  }

  /// The scans of the task in the archive as it is now, with the keys of the worklist.
  Result<void> find_scans() {
    TRY_ASSIGN(const Job job, job_from(file_.job_text, file_.job_path, file_.sets, work_));
    bricks_ = job.how.brick;
    bricks_.cut_from = kCutFrom;
    const std::string hashes = tree_.hashes_file();
    if (const auto source = store::exists(hashes) ? store::open_file(hashes, hashes)
                                                  : Result<std::shared_ptr<const ByteSource>>(fail(Code::BadInput, "")))
      if (const auto text = read_all(**source, 1ull << 30)) work_.load_hashes(*text);
    TRY_ASSIGN(const Archive archive, work_.discover(job.archive, job.what, [&](const std::string& scan) {
      return what_of(job, scan, work_);
    }));
    std::map<std::string_view, std::size_t> numbers;
    for (std::size_t i = 0; i < archive.scans.size(); ++i) numbers[archive.scans[i].name] = i;
    std::map<std::size_t, std::shared_ptr<const Node>> keys;
    for (const TaskItem& item : task_.items) {
      auto& what = keys[item.keys];
      if (!what) what = std::make_shared<const Node>(file_.keys[item.keys]);
      const auto number = numbers.find(item.scan);
      SelectedScan scan{0, {item.scan, {}, {}, false}, what};
      if (number != numbers.end()) scan = {number->second, archive.scans[number->second], what};
      is_there_.push_back(number != numbers.end());
      scans_.push_back(std::move(scan));
    }
    return {};
  }

  ScanEntry first_entry(std::size_t item) const {
    ScanEntry entry;
    entry.name = scans_[item].task.name;
    entry.notes = scans_[item].task.notes;
    entry.repeat = repeat_command(run_options_, entry.name);
    return entry;
  }

  /// False once the worklist was taken back.
  bool is_wanted() const { return store::exists(options_.path) && !store::exists(folder_ + "/" + kRevokedFile); }

  bool goes_on() {
    if (stop_.signal != 0) return false;
    if (is_wanted() && !store::exists(folder_ + "/" + kDrainFile)) return true;
    later_ = true;
    console_.remark("what is left of the task is no longer wanted");
    return false;
  }

  void make(std::size_t item, Executor& executor) {
    if (const auto earlier = load_result(result_path(folder_, options_.index, item)); earlier && is_final(*earlier))
      return count(*earlier, item);
    TaskResult result;
    result.scan = task_.items[item].scan;
    result.host = host_name();
    result.engine = engine_name();
    if (is_there_[item]) {
      auto ended = attempt(item, executor);
      if (!ended) return;
      result.ended = *std::move(ended);
    } else {
      Attempt gone{first_entry(item), {}, false, {}};
      gone.entry.fate = ScanFate::Failed;
      gone.entry.failure = FailureClass::BadInput;
      gone.entry.error = fail(Code::BadInput, "the archive no longer holds this scan", result.scan);
      result.ended.attempt = std::move(gone);
    }
    if (const auto saved = save_result(folder_, options_.index, item, result); !saved) {
      console_.complain(saved.error());
      died_ = true;
    }
    count(result, item);
  }

  /// Nothing when it was stopped: then there is no result.
  std::optional<Ended> attempt(std::size_t item, Executor& executor) {
    console_.begin(task_.items[item].scan);
    if (auto started = executor.start({item, threads_, memory_, task_.items[item].part}); !started) {
      console_.complain(started.error());
      died_ = true;
      return std::nullopt;
    }
    std::optional<Ended> ended;
    std::optional<Clock::time_point> asked;
    while (!executor.running().empty()) {
      show_life(item, executor);
      for (Ended& one : executor.wait(kTaskTick)) ended = std::move(one);
      if (stop_.signal == 0) continue;
      if (!asked) {
        asked = Clock::now();
        executor.stop_all();
      } else if (Clock::now() - *asked > kTaskPatience) {
        executor.kill_all();
      }
    }
    console_.end();
    const bool cancelled = ended && ended->attempt && ended->attempt->entry.fate == ScanFate::Interrupted;
    if (cancelled && stop_.signal == 0) later_ = true;
    if (cancelled || !ended || (!ended->attempt && stop_.signal != 0)) return std::nullopt;
    return ended;
  }

  void show_life(std::size_t item, const Executor& executor) {
    const auto now = Clock::now();
    if (now < next_beat_) return;
    next_beat_ = now + std::chrono::milliseconds(
                           static_cast<std::int64_t>(1000 * std::clamp(file_.lease_s / kBeatsPerLease, 0.1, 10.0)));
    Heartbeat heartbeat{host_name(), engine_name(), static_cast<int>(getpid()), item, "start", 0, 0, space_, began_};
    if (!executor.running().empty()) {
      const Running& at = executor.running().front();
      heartbeat.stage = at.stage;
      heartbeat.done = at.done;
      heartbeat.total = at.total;
    }
    beat(beat_path_, heartbeat);
  }

  /// Of a task that comes before one whose part it needs: which is to be run first. Else empty.
  std::string first_task(const ScanEntry& entry, const std::string& part) const {
    std::string missing = missing_part(entry, tree_, part);
    if (missing.starts_with("link ")) missing = "gather";  // which makes those as well
    if (missing.empty()) return {};
    for (std::size_t t = 0; t < file_.tasks.size(); ++t)
      for (const TaskItem& item : file_.tasks[t].items)
        if (item.scan == entry.name && item.part == missing)
          return entry.name + ": " + (part.empty() ? "comes" : "part " + part + " comes") + " too early; the task '" +
                 missing + "' is first: scanmill task " + options_.path + " " + std::to_string(t) +
                 ", then this one again (" + entry.error.text() + ")";
    return {};
  }

  void count(const TaskResult& result, std::size_t item) {
    if (!result.ended.attempt) {
      died_ = true;
      console_.complain(fail(
          Code::Internal,
          result.ended.over_time ? "the time limit of a scan was reached" : "the process died of " + result.ended.death,
          result.scan));
      return;
    }
    ScanEntry entry = result.ended.attempt->entry;
    if (const std::string& part = task_.items[item].part; !part.empty() && entry.failure == FailureClass::None)
      return console_.remark(entry.name + ": part " + part + " is there");
    if (const std::string first = first_task(entry, task_.items[item].part); !first.empty()) {
      later_ = true;
      return console_.remark(first);
    }
    entry.repeat = first_entry(item).repeat;
    show_scan(entry, file_.out, false, false, false, console_);
    failed_ |= entry.fate == ScanFate::Quarantined || entry.failure == FailureClass::BadInput;
    later_ |= entry.failure == FailureClass::Transient;
    died_ |= entry.failure == FailureClass::Internal || entry.failure == FailureClass::Resource;
    rejected_ |= !entry.failed_gates.empty();
  }

  const TaskOptions& options_;
  const TaskFile& file_;
  const Task& task_;
  std::string folder_, beat_path_;
  std::string space_ = process_space();
  std::uint64_t began_ = look_at_process(getpid()).value_or(ProcessSign{}).began;
  Work& work_;
  Console& console_;
  Stop& stop_;
  OutputTree tree_;
  RunOptions run_options_;
  int threads_ = 1;
  std::uint64_t memory_ = 0;
  BrickKeys bricks_;
  std::vector<SelectedScan> scans_;
  std::vector<bool> is_there_;
  Clock::time_point next_beat_{};
  bool died_ = false, later_ = false, failed_ = false, rejected_ = false;
};

}  // namespace

int run_task(const TaskOptions& options, const TaskFile& file, Work& work, Console& console, Stop& stop) {
  if (options.index >= file.tasks.size()) {
    console.complain(fail(Code::BadUsage,
                          "found no task " + std::to_string(static_cast<std::int64_t>(options.index)) +  // as typed: -1
                              "; the worklist holds " + std::to_string(file.tasks.size()) + ", from 0",
                          options.path));
    return kExitUsage;
  }
  if (file.version != options.version) {
    console.complain(fail(Code::BadUsage,
                          "the worklist was written by scanmill " + file.version + ", and this is " + options.version +
                              ": it might make other bytes; run the same version everywhere",
                          options.path));
    return kExitUsage;
  }
  return TaskRun(options, file, work, console, stop).run();
}

}  // namespace scanmill::runner
