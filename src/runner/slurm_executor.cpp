// SPDX-License-Identifier: Apache-2.0
#include "runner/slurm_executor.hpp"

#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "base/digest.hpp"
#include "base/text.hpp"
#include "runner/machine.hpp"
#include "runner/pack_tasks.hpp"
#include "runner/scan_messages.hpp"
#include "runner/slurm_client.hpp"
#include "runner/slurm_wave.hpp"
#include "runner/task.hpp"
#include "store/files.hpp"

namespace scanmill::runner {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using document::Node;

constexpr std::uint64_t kTaskMemory = 96ull << 20;  // the task's own, beside the scan's process
constexpr std::uint64_t kUnknownMemory = 64ull << 30;
constexpr double kLeastTime = 300, kTimeOverForecast = 8;  // of a scan's share of an element's time limit
constexpr double kElementStart = 60;                       // and of the element itself
constexpr double kMostBackOff = 60;
constexpr int kMostCancelled = 2, kMostLaunches = 2, kHopelessLaunches = 3;

double seconds_since(Moment begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }
Clock::duration seconds(double count) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(count));
}
std::string keys_digest(const Node& keys) { return sha256_hex(document::to_canonical_json(keys)); }

/// The last lines of an element's log, on one line.
std::string last_words(const std::string& log) {
  std::ifstream file(log, std::ios::binary);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);)
    if (!words_of(line).empty()) lines.push_back(line.substr(0, 300));
  std::string text;
  for (std::size_t i = lines.size() - std::min<std::size_t>(lines.size(), 2); i < lines.size(); ++i)
    text += (text.empty() ? "" : " / ") + lines[i];
  return text;
}

class SlurmExecutor final : public Executor {
 public:
  explicit SlurmExecutor(SlurmOptions options)
      : o_(std::move(options)), slurm_([this] { return o_.stop.flag.is_set() && o_.stop.requests > 1; }) {
    scan_interval_ = seconds(std::clamp(o_.keys.poll_s / 4, 0.01, 2.0));
    take_over();
  }

  ~SlurmExecutor() override {
    for (Wave& wave : waves_)
      if (!wave.closed) close(wave, true);
  }

  Result<void> start(const Order& order) override {
    const SelectedScan& scan = o_.selection.scans[order.scan];
    const std::size_t unit = unit_of(order);
    Wanted wanted;
    wanted.order = order;
    wanted.unit = unit;
    wanted.order.memory = memory_class(order.memory, o_.most_memory);
    wanted.name = scan.task.name;
    wanted.keys = keys_digest(*scan.what);
    wanted.bytes = order.part.empty() ? o_.bytes_of(order.scan) : order.bytes;
    wanted.granted_s = granted(wanted);
    if (const auto grown = grants_.find(unit); grown != grants_.end())
      wanted.granted_s = std::max(wanted.granted_s, grown->second);
    wanted.began = Clock::now();
    wanted.waits = !adopt(unit, wanted);
    wanted_[unit] = std::move(wanted);
    list_changed_ = true;
    return {};
  }

  std::vector<Ended> wait(std::chrono::milliseconds timeout) override {
    flush();
    const auto now = Clock::now();
    if (now >= next_scan_) {
      next_scan_ = now + scan_interval_;
      for (Wave& wave : waves_)
        if (!wave.closed) read_records(wave);
    }
    if (now >= next_look_ && has_submitted()) {
      look();
      next_look_ = Clock::now() + seconds(draining_ ? std::min(1.0, o_.keys.poll_s) : o_.keys.poll_s);
    }
    for (std::size_t w = 0; w < waves_.size(); ++w)
      if (!waves_[w].closed) judge(w);
    if (list_changed_) list_running();
    if (ended_.empty() && !wanted_.empty()) (void)poll(nullptr, 0, static_cast<int>(timeout.count()));
    return std::exchange(ended_, {});
  }

  const std::vector<Running>& running() const override { return running_; }
  bool is_remote() const override { return true; }
  std::optional<Error> broken() const override { return broken_; }

  void drain() override {
    draining_ = true;
    give_back_waiting();
    for (Wave& wave : waves_) {
      if (wave.closed) continue;
      (void)store::write_scratch(wave.folder.folder + "/" + kDrainFile, "\n");
      if (auto done = slurm_.cancel(wave.folder.name, "PENDING", ""); !done) o_.note("", done.error().text());
    }
    next_look_ = {};
  }

  void stop_all() override {
    draining_ = stopping_ = true;
    give_back_waiting();
    for (Wave& wave : waves_)
      if (!wave.closed)
        if (auto done = slurm_.cancel(wave.folder.name, "", ""); !done) o_.note("", done.error().text());
    next_look_ = {};
  }

  void kill_all() override {
    draining_ = stopping_ = true;
    for (Wave& wave : waves_)
      if (!wave.closed) close(wave, true);
    std::vector<std::size_t> all;
    for (const auto& [scan, wanted] : wanted_) all.push_back(scan);
    for (const std::size_t scan : all) give_back(scan);
    list_running();
  }

 private:
  /// Scans and parts are told apart by one number, which is called a scan's below.
  std::size_t unit_of(const Order& order) {
    const auto [at, is_new] = unit_numbers_.emplace(std::pair(order.scan, order.part), units_.size());
    if (is_new) units_.push_back(order.scan);
    return at->second;
  }
  const ScanEntry& entry_of(std::size_t unit) const { return o_.entry_of(units_[unit]); }

  // ---- what is wanted -------------------------------------------------------------------------------------------

  /// Share of a scan in the time limit of its element.
  double granted(const Wanted& wanted) const {
    if (o_.keys.time_s > 0) return o_.keys.time_s;
    const double forecast = forecast_seconds(wanted.bytes, o_.bytes_per_core_second, wanted.order.threads);
    return std::min(o_.frame.time_limit_s, std::max(kLeastTime, kTimeOverForecast * forecast));
  }

  void list_running() {
    running_.clear();
    std::map<std::size_t, std::size_t> place;
    for (const auto& [scan, wanted] : wanted_) {
      place[scan] = running_.size();
      running_.push_back({wanted.order, 0, wanted.began, "queued", 0, 0});
    }
    for (const Wave& wave : waves_) {
      if (wave.closed) continue;
      for (const Element& element : wave.elements) {
        if (!element.heartbeat || element.settled || element.heartbeat->item >= element.scans.size()) continue;
        const auto at = place.find(element.scans[element.heartbeat->item]);
        if (at == place.end() || element.recorded[element.heartbeat->item]) continue;
        Running& one = running_[at->second];
        one.pid = element.heartbeat->pid;
        one.stage = element.heartbeat->stage;
        one.done = element.heartbeat->done;
        one.total = element.heartbeat->total;
      }
    }
    list_changed_ = false;
  }

  /// The scan comes to its end for this executor.
  void finish(std::size_t scan, Ended ended) {
    const auto at = wanted_.find(scan);
    if (at == wanted_.end()) return;
    ended.order = at->second.order;
    ended_.push_back(std::move(ended));
    wanted_.erase(at);
    list_changed_ = true;
  }

  /// Without a result, and nobody's fault: not begun, or stopped on request.
  void give_back(std::size_t scan) {
    Ended ended;
    Attempt attempt{entry_of(scan), {}, false, {}};
    ended.attempt = std::move(attempt);
    finish(scan, std::move(ended));
  }

  void give_back_waiting() {
    std::vector<std::size_t> all;
    for (const auto& [scan, wanted] : wanted_)
      if (wanted.waits) all.push_back(scan);
    for (const std::size_t scan : all) give_back(scan);
    for (Wave& wave : waves_)
      if (!wave.closed && !wave.submitted) {
        for (const Element& element : wave.elements)
          for (const std::size_t one : element.scans) give_back(one);
        close(wave, wave.tries > 0);
      }
  }

  void fail_scan(std::size_t scan, FailureClass failure, Error error) {
    Ended ended;
    Attempt attempt{entry_of(scan), {}, false, {}};
    const bool has_result = store::exists(o_.tree.scan(attempt.entry.name) + "/" + kStateFile);
    attempt.entry.fate = has_result ? ScanFate::Stale : ScanFate::Failed;
    if (has_result) attempt.entry.files = result_files(o_.tree, attempt.entry.name);
    ++attempt.entry.attempts;
    if (attempt.entry.why.empty()) attempt.entry.why = {"new or changed"};
    attempt.entry.failure = failure;
    attempt.entry.error = std::move(error);
    ended.attempt = std::move(attempt);
    finish(scan, std::move(ended));
  }

  /// Submitted again; `count` of so many times so far, which is said and delays it.
  void again(std::size_t scan, int count, const std::string& why) {
    const auto at = wanted_.find(scan);
    if (at == wanted_.end()) return;
    if (draining_) return give_back(scan);
    at->second.waits = true;
    at->second.not_before = Clock::now() + seconds(count > 1 ? std::min(kMostBackOff, std::pow(2, count - 1)) : 0);
    list_changed_ = true;
    if (!why.empty()) o_.note(at->second.name, why + "; submitted again");
  }

  // ---- handing in -----------------------------------------------------------------------------------------------

  void flush() {
    if (broken_ || draining_) return;
    if (!took_leftovers_) drop_unwanted();
    const auto now = Clock::now();
    std::map<std::uint64_t, std::vector<std::size_t>> by_memory;
    for (const auto& [scan, wanted] : wanted_)
      if (wanted.waits && wanted.not_before <= now) by_memory[wanted.order.memory].push_back(scan);
    for (auto& [memory, scans] : by_memory) plan_waves(memory, scans);
    for (std::size_t w = 0; w < waves_.size() && !broken_; ++w)
      if (!waves_[w].closed && !waves_[w].submitted && waves_[w].next_try <= Clock::now()) submit(waves_[w]);
  }

  void plan_waves(std::uint64_t memory, const std::vector<std::size_t>& scans) {
    PackRule rule;
    rule.task_seconds = o_.keys.time_s > 0 ? std::min(o_.keys.element_s, o_.keys.time_s / 3) : o_.keys.element_s;
    rule.least_tasks = static_cast<std::size_t>(o_.keys.spread);
    rule.scans_per_task = static_cast<std::size_t>(o_.keys.scans_per_element);
    std::vector<ScanLoad> loads;
    std::vector<std::vector<std::size_t>> tasks;
    for (const std::size_t scan : scans) {
      const Wanted& wanted = wanted_[scan];
      if (wanted.alone)
        tasks.push_back({scan});
      else
        loads.push_back({scan, forecast_seconds(wanted.bytes, o_.bytes_per_core_second, wanted.order.threads)});
    }
    auto packed = pack_tasks(std::move(loads), rule);
    tasks.insert(tasks.begin(), packed.begin(), packed.end());
    const std::size_t chunk = most_elements();
    for (std::size_t begin = 0; begin < tasks.size(); begin += chunk)
      make_one({tasks.begin() + static_cast<std::ptrdiff_t>(begin),
                tasks.begin() + static_cast<std::ptrdiff_t>(std::min(begin + chunk, tasks.size()))},
               memory);
  }

  /// Elements of an array: the job's wish, and what the cluster takes.
  std::size_t most_elements() {
    if (!most_elements_) {
      most_elements_ = static_cast<std::size_t>(o_.keys.chunk);
      if (const auto most = slurm_.setting("MaxArraySize"); most && *most > 1)
        most_elements_ = std::min<std::size_t>(*most_elements_, *most - 1);
    }
    return *most_elements_;
  }

  void make_one(const std::vector<std::vector<std::size_t>>& tasks, std::uint64_t memory) {
    TaskFile file = o_.frame;
    file.token = new_token();
    Wave wave;
    wave.memory = memory;
    std::map<std::string, std::size_t> keys;
    for (const auto& scans : tasks) {
      Task task;
      Element element;
      double time = kElementStart;
      for (const std::size_t scan : scans) {
        Wanted& wanted = wanted_[scan];
        wanted.waits = false;
        wanted.alone = false;
        wave.threads = task.threads = wanted.order.threads;
        task.memory = memory;
        const auto [at, is_new] = keys.emplace(wanted.keys, file.keys.size());
        if (is_new) file.keys.push_back(*o_.selection.scans[units_[scan]].what);
        task.items.push_back({wanted.name, at->second, wanted.bytes, wanted.order.part});
        element.scans.push_back(scan);
        element.recorded.push_back(false);
        time += wanted.granted_s;
      }
      wave.seconds = o_.keys.time_s > 0 ? o_.keys.time_s : std::max(wave.seconds, time);
      file.tasks.push_back(std::move(task));
      wave.elements.push_back(std::move(element));
    }
    auto made = make_wave(o_.tree, file, wave_job_name(o_.frame.job_path, file.token), script_of(file));
    if (!made) {
      broken_ = made.error();
      return;
    }
    wave.folder = *std::move(made);
    waves_.push_back(std::move(wave));
  }

  std::string script_of(const TaskFile& file) const {
    std::string words;
    for (const std::string& word : o_.keys.wrap) words += shell_word(word) + " ";
    const std::string program = o_.keys.program.empty() ? own_path() : o_.keys.program;
    return "#!/bin/sh\nexec " + words + shell_word(program) + " task " +
           shell_word(o_.frame.out + "/work/" + file.token + "/" + kTaskFileName) + " \"$SLURM_ARRAY_TASK_ID\"\n";
  }
  static std::string own_path() {
    std::error_code error;
    const auto path = fs::read_symlink("/proc/self/exe", error);
    return error ? "scanmill" : path.string();
  }

  void submit(Wave& wave) {
    if (!wave.looked_up) {
      // The reply to the last submission was lost: perhaps the job was not.
      const auto rows = slurm_.look({wave.folder.name});
      if (!rows) return retry_later(wave, rows.error().text());
      wave.looked_up = true;
      if (!rows->empty()) return accept(wave);
    }
    ArraySpec spec;
    spec.name = wave.folder.name;
    spec.count = wave.elements.size();
    spec.threads = wave.threads;
    spec.memory = wave.memory + kTaskMemory;
    spec.seconds = wave.seconds;
    spec.folder = o_.frame.out + "/work/" + fs::path(wave.folder.folder).filename().string();
    spec.script = spec.folder + "/script.sh";
    SubmitFault fault;
    ++wave.tries;
    if (slurm_.submit(spec, o_.keys, fault)) return accept(wave);
    wave.looked_up = false;
    if (fault.passing) return retry_later(wave, "sbatch: " + fault.text);
    broken_ = fail(Code::BadParameter,
                   "sbatch refused the work: " + fault.text + "; correct cluster, resources or the command line");
  }

  void accept(Wave& wave) {
    wave.submitted = true;
    for (Element& element : wave.elements) element.last_sign = Clock::now();
    next_look_ = std::max(next_look_, Clock::now() + scan_interval_);
    if (wave.tries > 1) o_.note("", "submitted after " + std::to_string(wave.tries) + " tries");
  }

  void retry_later(Wave& wave, const std::string& why) {
    const double pause = std::min(kMostBackOff, o_.keys.poll_s * std::pow(2, std::min(wave.tries, 10) - 1));
    if (wave.tries <= 1 || pause >= kMostBackOff)
      o_.note("", why + "; tried again in " + number_text(std::ceil(pause)) + " s");
    wave.next_try = Clock::now() + seconds(pause);
  }

  // ---- taking over ----------------------------------------------------------------------------------------------

  /// Waves of a driver that died; their elements wait for scans that are wanted.
  void take_over() {
    std::size_t elements = 0;
    for (const WaveFolder& folder : open_waves(o_.tree)) {
      const auto file = load_task_file(folder.worklist());
      if (!file || folder.name.empty() || file->version != o_.frame.version) {
        if (!folder.name.empty()) (void)slurm_.cancel(folder.name, "", "");
        close_wave(folder);
        continue;
      }
      (void)unlink((folder.folder + "/" + kDrainFile).c_str());
      Wave wave;
      wave.folder = folder;
      wave.tries = 1;
      wave.looked_up = false;  // it may have died before it submitted
      std::vector<std::string> digests;
      for (const Node& keys : file->keys) digests.push_back(keys_digest(keys));
      for (std::size_t t = 0; t < file->tasks.size(); ++t) {
        const Task& task = file->tasks[t];
        wave.threads = task.threads;
        wave.memory = std::max(wave.memory, task.memory);
        Element element;
        for (std::size_t i = 0; i < task.items.size(); ++i) {
          offers_[task.items[i].scan + "\n" + digests[task.items[i].keys] + "\n" + task.items[i].part] = {waves_.size(),
                                                                                                          t, i};
          element.scans.push_back(kNoScan);
          element.recorded.push_back(false);
        }
        wave.elements.push_back(std::move(element));
      }
      wave.seconds = std::max(o_.keys.time_s, o_.frame.time_limit_s);
      elements += wave.elements.size();
      waves_.push_back(std::move(wave));
    }
    if (elements > 0)
      o_.note("", "taking over " + counted(elements, "element") + " of " + counted(waves_.size(), "array") +
                      " that an earlier run left on the cluster");
  }

  bool adopt(std::size_t scan, const Wanted& wanted) {
    const auto offer = offers_.find(wanted.name + "\n" + wanted.keys + "\n" + wanted.order.part);
    if (offer == offers_.end()) return false;
    const auto [w, e, i] = offer->second;
    offers_.erase(offer);
    if (waves_[w].closed || waves_[w].elements[e].recorded[i]) return false;
    waves_[w].elements[e].scans[i] = scan;
    return true;
  }

  /// Everything wanted at the start has been asked for: elements that nobody wants are of no use.
  void drop_unwanted() {
    took_leftovers_ = true;
    offers_.clear();
    for (Wave& wave : waves_) {
      if (wave.closed) continue;
      bool any = false;
      for (const Element& element : wave.elements)
        any |= std::any_of(element.scans.begin(), element.scans.end(), [](std::size_t s) { return s != kNoScan; });
      if (!any) {
        close(wave, true);
        continue;
      }
      for (Element& element : wave.elements)
        for (std::size_t i = 0; i < element.scans.size(); ++i)
          if (element.scans[i] == kNoScan) element.recorded[i] = true;
      read_records(wave);  // what is done already need not be handed in again
      if (std::all_of(wave.elements.begin(), wave.elements.end(), [](const Element& one) { return one.has_all(); }))
        wave.submitted = true;
    }
  }

  // ---- what comes of it -----------------------------------------------------------------------------------------

  bool has_submitted() const {
    return std::any_of(waves_.begin(), waves_.end(), [](const Wave& wave) { return wave.submitted && !wave.closed; });
  }

  /// One list of the folder tells of all records and signs of life; on NFS it also brings the cache up to date.
  void read_records(Wave& wave) {
    std::error_code error;
    std::vector<std::pair<std::size_t, std::size_t>> records;
    for (fs::directory_iterator it(wave.folder.folder, error), end; !error && it != end; it.increment(error)) {
      const std::string file = it->path().filename().string();
      if (const auto numbers = result_numbers(file)) {
        if (numbers->first < wave.elements.size() && numbers->second < wave.elements[numbers->first].recorded.size() &&
            !wave.elements[numbers->first].recorded[numbers->second])
          records.push_back(*numbers);
      } else if (const auto index = heartbeat_index(file); index && *index < wave.elements.size()) {
        Element& element = wave.elements[*index];
        if (element.settled || element.has_all()) continue;
        hear(element, it->path().string());
      }
    }
    for (const auto& [index, item] : records)
      if (auto result = load_result(result_path(wave.folder.folder, index, item)))
        take(wave.elements[index], item, *std::move(result));
  }

  void hear(Element& element, const std::string& path) {
    const auto stamp = store::stamp_of(path);
    if (!stamp || stamp->mtime_ns <= element.beat_ns) return;
    element.beat_ns = stamp->mtime_ns;
    element.beat_file = path;
    element.last_sign = Clock::now();
    started_ = true;
    if (element.heartbeat && Clock::now() - element.beat_read < std::chrono::seconds(1)) return;
    if (auto beat = load_heartbeat(path)) {
      element.heartbeat = *std::move(beat);
      element.beat_read = Clock::now();
      list_changed_ = true;
    }
  }

  void take(Element& element, std::size_t item, TaskResult result) {
    element.recorded[item] = true;
    element.last_sign = Clock::now();
    started_ = true;
    const std::size_t scan = element.scans[item];
    const auto at = wanted_.find(scan);
    if (at == wanted_.end() || at->second.name != result.scan) return;
    if (result.ended.attempt) {
      // What the driver knew of earlier attempts goes on.
      ScanEntry& entry = result.ended.attempt->entry;
      const ScanEntry& before = entry_of(scan);
      entry.repeat = before.repeat;
      entry.attempts += before.attempts;
      entry.seconds += before.seconds;
      entry.cpu_seconds += before.cpu_seconds;
      if (!before.started.empty()) entry.started = before.started;
    }
    finish(scan, std::move(result.ended));
  }

  void look() {
    std::vector<std::string> names;
    std::map<std::string, std::size_t> waves;
    for (std::size_t w = 0; w < waves_.size(); ++w)
      if (waves_[w].submitted && !waves_[w].closed) {
        names.push_back(waves_[w].folder.name);
        waves[names.back()] = w;
      }
    const auto rows = slurm_.look(names);
    if (!rows) {
      if (!silent_) o_.note("", rows.error().text() + "; going on by the tasks' own records");
      silent_ = true;
      return;
    }
    if (std::exchange(silent_, false)) o_.note("", "Slurm answers again");
    answered_ = Clock::now();
    for (const std::string& name : names)
      for (Element& element : waves_[waves[name]].elements) element.seen = false;
    for (const QueueRow& row : *rows)
      if (Wave& wave = waves_[waves[row.name]]; !row.is_rest && row.index < wave.elements.size())
        see(wave.elements[row.index], row);
    for (const QueueRow& row : *rows)
      if (row.is_rest)
        for (Element& element : waves_[waves[row.name]].elements)
          if (!element.seen) see(element, row);
  }

  void see(Element& element, const QueueRow& row) {
    const JobWord* word = job_word(row.state);
    if (!word && warned_.insert(row.state).second)
      o_.note("", "Slurm says " + row.state + ", a word that is not known here; the element is taken for alive");
    const JobPhase phase = word ? word->phase : JobPhase::Running;
    const bool alive = phase == JobPhase::Waiting || phase == JobPhase::Running;
    // A reply that was lost can leave two arrays of one name: alive is what any of them is.
    if (element.seen && element.phase && !element.is_over() && !alive) return;
    element.seen = true;
    element.word = row.state;
    element.reason = row.reason;
    element.job = row.job;
    element.wait_status = row.wait_status;
    if (alive) {
      element.last_sign = Clock::now();
      element.over_since = {};
    } else if (!element.is_over()) {
      element.over_since = Clock::now();
    }
    element.phase = phase;
  }

  void judge(std::size_t w) {
    bool all = true;
    for (std::size_t e = 0; e < waves_[w].elements.size(); ++e) {
      Element& element = waves_[w].elements[e];
      if (!element.settled && element.has_all()) element.settled = true;
      if (!element.settled && waves_[w].submitted) judge_element(waves_[w], e);
      all &= element.settled;
    }
    if (all) close(waves_[w], false);
  }

  void judge_element(Wave& wave, std::size_t e) {
    Element& element = wave.elements[e];
    if (element.is_over()) {
      // Its records may be under way on a network file system; that it says to have ended well most of all.
      const bool well = *element.phase == JobPhase::Ended && element.wait_status == 0;
      const double patience = draining_ ? 0.2 : well ? o_.keys.lease_s : std::min(o_.keys.lease_s, 2 * o_.keys.poll_s);
      if (seconds_since(element.over_since) < patience) return;
      read_records(wave);
      if (!element.has_all()) resolve(wave, e, *element.phase);
      element.settled = true;
      return;
    }
    if (element.seen && element.phase == JobPhase::Waiting &&
        (element.reason.starts_with("launch") || element.reason == "JobHeldAdmin" || element.reason == "JobHeldUser"))
      return judge_held(wave, e);
    if (element.seen) return;
    // Slurm does not know it, or does not answer. Only silence of both for the whole lease means that it is lost.
    if (answered_ <= element.last_sign || seconds_since(element.last_sign) < o_.keys.lease_s) return;
    read_records(wave);
    if (!element.has_all()) resolve(wave, e, JobPhase::Lost);
    element.settled = true;
  }

  /// A held job never starts by itself: one whose launch failed is taken back, one that a person holds is told of.
  void judge_held(Wave& wave, std::size_t e) {
    Element& element = wave.elements[e];
    if (!element.reason.starts_with("launch")) {
      if (warned_.insert(element.job + "_" + std::to_string(e)).second)
        o_.note("", "job " + element.job + "_" + std::to_string(e) + " is held (" + element.reason +
                        "); scontrol release lets it go on");
      return;
    }
    (void)slurm_.cancel_element(element.job, e);
    read_records(wave);
    if (!element.has_all()) resolve(wave, e, JobPhase::Lost);
    element.settled = true;
  }

  /// The element is over, and these of its scans have no record.
  void resolve(Wave& wave, std::size_t e, JobPhase phase) {
    Element& element = wave.elements[e];
    if (const std::string path = element.beat_file; !path.empty())
      if (auto beat = load_heartbeat(path)) element.heartbeat = *std::move(beat);
    std::vector<std::size_t> left;
    for (std::size_t i = 0; i < element.scans.size(); ++i)
      if (!element.recorded[i]) left.push_back(i);
    const bool begun = element.heartbeat.has_value();
    const std::size_t at_work = begun ? std::max(element.heartbeat->item, left.front()) : left.front();
    if (phase == JobPhase::Ended) {
      const int status = element.wait_status;
      if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) phase = JobPhase::OutOfMemory;
      const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      if (code == 128 + SIGTERM || code == 128 + SIGINT) phase = JobPhase::Cancelled;
      if (code == kExitBusy) phase = JobPhase::Lost;
      if (!begun && phase == JobPhase::Ended && code != 0) return failed_launch(wave, e, left, code);
    }
    for (const std::size_t i : left) {
      const std::size_t scan = element.scans[i];
      const auto at = wanted_.find(scan);
      element.recorded[i] = true;
      if (at == wanted_.end()) continue;
      if (draining_) {
        give_back(scan);
      } else if (i == at_work || phase == JobPhase::Lost || phase == JobPhase::Cancelled) {
        blame(wave, e, at->second, phase, begun);
      } else {
        again(scan, 0, "");  // not reached
      }
    }
  }

  /// What became of the scan that was at work.
  void blame(const Wave& wave, std::size_t e, Wanted& wanted, JobPhase phase, bool begun) {
    const Element& element = wave.elements[e];
    const std::size_t scan = wanted.unit;
    Ended ended;
    ended.stage = element.heartbeat ? element.heartbeat->stage : "";
    const std::string job = "job " + (element.job.empty() ? wave.folder.name : element.job) + "_" + std::to_string(e);
    const std::string log = last_words(wave.folder.folder + "/" + std::to_string(e) + ".log");
    switch (phase) {
      case JobPhase::OutOfMemory:
        ended.killed_by_system = true;
        return finish(scan, std::move(ended));
      case JobPhase::TimeLimit:
        if (!begun) return lose(wanted, job + " reached its time limit before it began");
        if (const bool grows = o_.keys.time_s <= 0 && wanted.granted_s < o_.frame.time_limit_s;
            grows || element.scans.size() > 1) {
          if (grows) wanted.granted_s = std::min(o_.frame.time_limit_s, 2 * wanted.granted_s);
          grants_[scan] = wanted.granted_s;
          wanted.alone = true;
          return again(scan, 0, job + " reached its time limit");
        }
        ended.over_time = true;
        if (o_.keys.time_s > 0)
          return fail_scan(
              scan, FailureClass::Internal,
              fail(Code::Internal, "the time limit of an element, " + number_text(o_.keys.time_s) + " s, was reached" +
                                       (ended.stage.empty() ? "" : " in stage " + ended.stage) +
                                       "; raise cluster.time or choose larger bins"));
        return finish(scan, std::move(ended));
      case JobPhase::Cancelled:
        if (++wanted.cancelled <= kMostCancelled) return again(scan, 0, job + " was cancelled by somebody else");
        return fail_scan(scan, FailureClass::Cancelled,
                         fail(Code::Cancelled, "its job was cancelled " + std::to_string(wanted.cancelled) +
                                                   " times by somebody else; ask them, and run again"));
      case JobPhase::Lost:
        return lose(wanted, job + (element.seen ? " was lost (" + element.word + ")" : " vanished without a sign"));
      default:
        break;
    }
    ended.death = element.wait_status == 0 ? "an end without a record"
                  : WIFSIGNALED(element.wait_status)
                      ? "signal " + std::to_string(WTERMSIG(element.wait_status)) + " (" +
                            std::string(strsignal(WTERMSIG(element.wait_status))) + ")"
                      : "exit code " + std::to_string(WEXITSTATUS(element.wait_status)) + " without an answer";
    ended.death += " of " + job + (log.empty() ? "" : " (" + log + ")");
    finish(scan, std::move(ended));
  }

  void lose(Wanted& wanted, const std::string& what) {
    if (++wanted.lost <= o_.keys.resubmits) return again(wanted.unit, wanted.lost, what);
    fail_scan(wanted.unit, FailureClass::Transient,
              fail(Code::IoFailed, "its job was lost " + std::to_string(wanted.lost) +
                                       " times, the last time: " + what + "; look at the nodes, and run again"));
  }

  /// The program did not come up on the node. Once may be the node; every time is the job's.
  void failed_launch(Wave& wave, std::size_t e, const std::vector<std::size_t>& left, int code) {
    Element& element = wave.elements[e];
    const std::string log = last_words(wave.folder.folder + "/" + std::to_string(e) + ".log");
    const std::string what =
        "the task did not start on its node (exit code " + std::to_string(code) + ")" + (log.empty() ? "" : ": " + log);
    ++failed_launches_;
    std::size_t worst = 0;
    for (const std::size_t i : left) {
      element.recorded[i] = true;
      const auto at = wanted_.find(element.scans[i]);
      if (at == wanted_.end()) continue;
      worst = std::max(worst, static_cast<std::size_t>(++at->second.launches));
      if (draining_)
        give_back(element.scans[i]);
      else if (at->second.launches <= kMostLaunches)
        again(element.scans[i], at->second.launches, i == left.front() ? what : "");
      else
        fail_scan(element.scans[i], FailureClass::Transient,
                  fail(Code::IoFailed, what + "; look at cluster.wrap, cluster.program and the node"));
    }
    if (!started_ && (failed_launches_ >= kHopelessLaunches || worst > kMostLaunches))
      broken_ = fail(Code::BadParameter,
                     what +
                         "; no task has started so far: check cluster.wrap, cluster.program, and that the nodes "
                         "see the output folder");
  }

  /// `all`: cancel what Slurm has of it. Else only what never began: a task that is about to end is left in peace.
  void close(Wave& wave, bool all) {
    if (wave.closed) return;
    wave.closed = true;
    const bool waits = std::any_of(wave.elements.begin(), wave.elements.end(),
                                   [](const Element& element) { return element.phase == JobPhase::Waiting; });
    if (all || waits) (void)slurm_.cancel(wave.folder.name, all ? "" : "PENDING", "");
    close_wave(wave.folder);
    list_changed_ = true;
  }

  SlurmOptions o_;
  SlurmClient slurm_;
  struct Place {
    std::size_t wave, element, item;
  };
  std::vector<Wave> waves_;
  std::map<std::pair<std::size_t, std::string>, std::size_t> unit_numbers_;
  std::vector<std::size_t> units_;        // the scan of each
  std::map<std::size_t, Wanted> wanted_;  // by unit
  std::map<std::string, Place> offers_;   // of waves that were taken over, by scan and keys
  std::map<std::size_t, double> grants_;  // time that scans were found to need
  std::vector<Running> running_;
  std::vector<Ended> ended_;
  std::optional<Error> broken_;
  std::optional<std::size_t> most_elements_;
  std::set<std::string> warned_;
  Clock::duration scan_interval_{};
  Moment next_scan_{}, next_look_{}, answered_{};
  int failed_launches_ = 0;
  bool draining_ = false, stopping_ = false, silent_ = false, started_ = false, took_leftovers_ = false,
       list_changed_ = false;
};

}  // namespace

std::unique_ptr<Executor> make_slurm_executor(SlurmOptions options) {
  return std::make_unique<SlurmExecutor>(std::move(options));
}

std::uint64_t cluster_memory(const ClusterKeys& keys) {
  const std::uint64_t node = SlurmClient().largest_node(keys.partition).value_or(kUnknownMemory);
  return node > 2 * kTaskMemory ? node - kTaskMemory : node;
}

}  // namespace scanmill::runner
