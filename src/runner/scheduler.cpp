// SPDX-License-Identifier: Apache-2.0
#include "runner/scheduler.hpp"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <ctime>
#include <set>

#include "base/text.hpp"
#include "runner/machine.hpp"
#include "runner/scan_messages.hpp"
#include "store/files.hpp"

namespace scanmill::runner {

using document::Node;

namespace {

constexpr auto kTick = std::chrono::milliseconds(100);
constexpr auto kAskInterval = std::chrono::milliseconds(500);
constexpr auto kSpaceInterval = std::chrono::seconds(1);
constexpr auto kStopPatience = std::chrono::seconds(10);
constexpr double kOverdue = 0.1;     // of its time so far is left to what takes longer than was thought
constexpr double kSaveShare = 0.05;  // of the time may go into run.json
constexpr int kMostWaits = 10;       // for files that keep changing
constexpr std::size_t kRememberedEpochs = 3;
constexpr std::size_t kManyScans = 20;          // with more than these, what is unchanged is only counted
constexpr std::uint64_t kLeastSpace = 1 << 20;  // of a result

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// The next moment at which clocks here show this minute of the day.
std::int64_t next_minute(std::int64_t minute) {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  localtime_r(&now, &parts);
  parts.tm_hour = static_cast<int>(minute / 60);
  parts.tm_min = static_cast<int>(minute % 60);
  parts.tm_sec = 0;
  parts.tm_isdst = -1;
  const std::time_t today = std::mktime(&parts);
  if (today > now) return today;
  ++parts.tm_mday;
  parts.tm_isdst = -1;
  return std::mktime(&parts);
}

Node event_for(const char* type, const std::string& scan) {
  Node event = Node::map();
  event.set("type", type);
  event.set("scan", scan);
  return event;
}

}  // namespace

Scheduler::Scheduler(Parts parts)
    : p_(std::move(parts)), view_(p_.console, p_.tree.live_file(), p_.journal ? p_.journal->epoch() : 0) {
  for (const SelectedScan& scan : p_.selection.scans) names_.push_back(scan.task.name);
  remembered_.resize(names_.size());
  if (p_.how.until_minute >= 0) deadline_ = next_minute(p_.how.until_minute);
  if (p_.journal)
    if (const auto space = store::free_space(p_.tree.root())) {
      std::uint64_t kept = 0;  // of parts that earlier runs made: they take of what is allowed
      if (p_.how.disk > 0 && store::is_folder(p_.tree.parts()))
        for (const std::string& name : names_) kept += p_.tree.bytes_of_parts(name);
      const std::uint64_t more = p_.how.disk - std::min(p_.how.disk, kept);
      space_floor_ = p_.how.disk > 0 ? *space - std::min(*space, more) : *space / 5;
    }
}

int Scheduler::run() {
  tell_of_deadline();
  recall_memory();
  sort_out();
  tell_of_waits();
  while (code_ == 0 && (!list_.empty() || !p_.executor.running().empty())) {
    listen();
    start_ready();
    auto timeout = kTick;
    if (p_.executor.running().empty() && list_.empty()) timeout = std::chrono::milliseconds(0);
    const bool only_waits = p_.executor.running().empty() && !list_.empty();
    const auto begin = Clock::now();
    for (Ended& ended : p_.executor.wait(timeout)) end(std::move(ended));
    if (only_waits) p_.report.waited += seconds_since(begin);
    if (const auto broken = p_.executor.broken(); broken && code_ == 0) {
      p_.complain(*broken);
      code_ = kExitCluster;
    }
    keep_state();
  }
  if (code_ != 0) {
    p_.executor.kill_all();
    while (!p_.executor.running().empty())
      for (const Ended& ended : p_.executor.wait(kTick))
        if (p_.journal && !p_.executor.is_remote()) p_.tree.remove_attempts(name(ended.order.scan));
  }
  if (p_.journal) view_.end();
  return code_;
}

/// What needs no work is known at once; the rest goes on the list.
void Scheduler::sort_out() {
  const bool has_parts = p_.journal && !p_.options.dry_run && store::is_folder(p_.tree.parts());
  for (std::size_t i = 0; i < names_.size() && !p_.stop.flag.is_set() && p_.stop.signal == 0; ++i) {
    ScanEntry& entry = p_.report.scans[i];
    Judgement judgement = p_.maker.judge(p_.selection.scans[i], entry);
    if (judgement.needs_work) {
      put_on_list(i);
      continue;
    }
    entry = std::move(judgement.entry);
    if (entry.fate == ScanFate::Unchanged && has_parts) p_.tree.remove_parts(entry.name);
    leave_quarantine(entry);
    show(entry);
  }
}

/// A good result stands: what was held against the scan is over, also when the file that failed was put back.
void Scheduler::leave_quarantine(const ScanEntry& entry) {
  if (p_.journal && (entry.fate == ScanFate::Done || entry.fate == ScanFate::Unchanged))
    p_.quarantine.remove(entry.name);
}

void Scheduler::show(ScanEntry& entry) {
  if (!entry.error.message.empty()) entry.repeat = repeat_command(p_.options, entry.name);
  show_scan(entry, p_.tree.root(), p_.options.explain, p_.options.dry_run, names_.size() > kManyScans, p_.console);
}

void Scheduler::put_on_list(std::size_t scan) {
  WorkItem item;
  item.scan = scan;
  const InputLook look = p_.work.look_at(p_.selection.scans[scan].number);
  item.bytes = look.bytes;
  item.memory = remembered_[scan];
  const bool waits = p_.how.settle_s > 0 && p_.options.only.empty() && p_.journal;
  if (waits) (void)settles(item);
  bytes_all_ += item.bytes;
  const CutParts parts = p_.journal ? p_.maker.parts_of(p_.selection.scans[scan]) : CutParts{};
  if (parts.waves.empty()) return list_.add(item);
  CutState& cut = cut_[scan];
  cut.waves = parts.waves;
  cut.whole = parts.whole;
  cut.bytes = item.bytes;
  put_next_wave(scan);
}

WorkItem Scheduler::take_from_work(const Order& order) {
  const auto found = std::find_if(at_work_.begin(), at_work_.end(), [&](const WorkItem& item) {
    return item.scan == order.scan && item.part == order.part;
  });
  WorkItem item;
  if (found == at_work_.end()) {
    item.scan = order.scan;
    item.part = order.part;
    return item;
  }
  item = *found;
  at_work_.erase(found);
  return item;
}

/// The minute that was meant may just have gone by.
void Scheduler::tell_of_deadline() {
  constexpr std::int64_t kAlmostADay_s = 23 * 3600;
  if (deadline_ && *deadline_ - std::time(nullptr) > kAlmostADay_s)
    p_.console.note("", "resources.until: this time of day has just gone by; it is taken as tomorrow's");
}

/// Minutes may pass before the first scan starts: an operator must not take that for a hang.
void Scheduler::tell_of_waits() {
  const auto waits = list_.waits(Clock::now());
  if (waits.count == 0) return;
  p_.console.note("", "waiting " + std::to_string(1 + static_cast<int>(-seconds_since(waits.last))) +
                          " s for the files of " + counted(waits.count, "scan") +
                          " that changed a moment ago (settle_s)");
}

/// True when its files were left alone for long enough; else it has a later moment. What is dated in the future was
/// written by another clock, or so on purpose: it is watched instead.
bool Scheduler::settles(WorkItem& item) {
  const InputLook look = p_.work.look_at(p_.selection.scans[item.scan].number);
  const std::int64_t now = now_ns();
  double age = 1e-9 * static_cast<double>(now - look.newest_ns);
  if (look.newest_ns > now) {
    if (item.seen_since == Moment{})
      p_.report.scans[item.scan].notes.push_back("an input is dated " + clock_text(-age) +
                                                 " h after this machine's clock; it was watched for settle_s instead");
    if (item.seen_since == Moment{} || look.newest_ns != item.seen.newest_ns || look.bytes != item.seen.bytes) {
      item.seen = look;
      item.seen_since = Clock::now();
    }
    age = seconds_since(item.seen_since);
  }
  const double left = static_cast<double>(p_.how.settle_s) - age;
  if (left <= 0) return true;
  item.not_before = Clock::now() + std::chrono::milliseconds(static_cast<std::int64_t>(left * 1000) + 1);
  return false;
}

/// Memory that scans were found to need in the last runs.
void Scheduler::recall_memory() {
  if (!p_.journal) return;
  const auto epochs = epochs_in(p_.tree.journal());
  for (std::size_t k = epochs.size() - std::min(epochs.size(), kRememberedEpochs + 1); k < epochs.size(); ++k) {
    if (epochs[k] == p_.journal->epoch()) continue;
    for (const Node& event : load_journal(p_.tree.journal(), epochs[k])) {
      const Node *scan = event.find("scan"), *memory = event.find("needs_memory");
      if (!scan || !memory || !scan->is_string() || !memory->is_integer()) continue;
      const auto at = std::lower_bound(names_.begin(), names_.end(), scan->as_string());
      if (at != names_.end() && *at == scan->as_string())
        remembered_[static_cast<std::size_t>(at - names_.begin())] = static_cast<std::uint64_t>(memory->as_integer());
    }
  }
}

/// Signals, `scanmill cancel`, and the journal's due lines.
void Scheduler::listen() {
  const auto now = Clock::now();
  if (p_.journal && now - asked_ > kAskInterval) {
    asked_ = now;
    if (store::exists(p_.tree.cancel_file())) {
      (void)store::remove_tree(p_.tree.cancel_file());
      (void)p_.stop.request(SIGTERM);
    }
  }
  if (p_.stop.snapshot.exchange(false)) view_.snapshot(picture());
  if (p_.stop.signal == 0) return;
  if (!list_.empty()) put_off("");
  const auto running = p_.executor.running().size();
  const auto queued = static_cast<std::size_t>(std::count_if(p_.executor.running().begin(), p_.executor.running().end(),
                                                             [](const Running& one) { return one.is_queued; }));
  if (!draining_ && running > 0 && !p_.stop.flag.is_set()) {
    draining_ = true;
    p_.executor.drain();
    remark_ = "stopping: what is at work is brought to its end; once more stops at once";
    p_.console.remark("stopping: " + at_work_text(false) + (running - queued == 1 ? " is" : " are") +
                      " brought to the end" + (queued > 0 ? ", " + std::to_string(queued) + " taken back" : "") +
                      "; once more stops at once");
  }
  if (p_.stop.flag.is_set() && running > 0) {
    if (stop_at_ == Clock::time_point{}) {
      stop_at_ = now;
      if (p_.executor.is_remote())
        p_.console.remark("stopping at once: " + at_work_text(true) + (running == 1 ? " is" : " are") + " cancelled");
      p_.executor.stop_all();
    } else if (now - stop_at_ > kStopPatience) {
      p_.executor.kill_all();
    }
  }
}

Room Scheduler::room() const {
  Room room{p_.report.threads, p_.report.threads, p_.memory, p_.memory};
  if (p_.executor.is_remote()) return room;
  for (const Running& one : p_.executor.running()) {
    room.cores_free -= one.order.threads;
    room.memory_free -= std::min(room.memory_free, one.order.memory);
  }
  return room;
}

void Scheduler::start_ready() {
  while (code_ == 0 && p_.stop.signal == 0 && !p_.stop.flag.is_set()) {
    auto next = list_.next(room(), Clock::now());
    if (!next) break;
    auto& [item, order] = *next;
    if (p_.executor.is_remote()) {
      order.threads = p_.report.threads;
      order.memory = std::max(item.memory, memory_guess(item.bytes));
    }
    if (p_.one_at_a_time) {
      order.threads = p_.report.threads;
      order.memory = p_.memory;
    }
    if (item.not_before != Clock::time_point{} && item.transient == 0 && !settles(item)) {
      if (++item.waits < kMostWaits)
        list_.add(item);
      else
        leave_for_later(item.scan, "put off: its files kept changing through " + std::to_string(kMostWaits) +
                                       " waits of settle_s; it is made once they are left alone");
      continue;
    }
    if (!may_start(item, order)) continue;
    if (p_.journal && item.part.empty()) {
      Node event = event_for("start", name(item.scan));
      event.set("threads", order.threads);
      event.set("memory_bytes", order.memory);
      p_.journal->add(std::move(event));
    }
    at_work_.push_back(item);
    if (auto started = p_.executor.start(order); !started) {
      (void)take_from_work(order);
      if (p_.executor.running().empty()) {
        p_.complain(started.error());
        code_ = kExitInternal;
      } else {
        item.not_before = Clock::now() + std::chrono::seconds(1);  // when one of those at work has ended
        list_.add(item);
        break;
      }
    }
  }
  const auto moment = list_.next_moment(Clock::now());
  if (draining_) return;
  remark_ = p_.executor.running().empty() && moment
                ? "waiting " + std::to_string(1 + static_cast<int>(-seconds_since(*moment))) +
                      " s for files that were changed just now (settle_s)"
                : "";
}

void Scheduler::leave_for_later(std::size_t scan, const std::string& why) {
  ScanEntry& entry = p_.report.scans[scan];
  entry.notes.push_back(why);
  p_.console.note(entry.name, why);
  if (p_.report.put_off++ == 0 && p_.journal) p_.journal->add(event_for("put_off", entry.name));
}

/// Time and disk. What is put off for time stays pending; a full disk ends the run.
bool Scheduler::may_start(const WorkItem& item, const Order& order) {
  if (deadline_) {
    const double rate = core_seconds_ > 0 ? static_cast<double>(bytes_done_) / core_seconds_ : 0;
    const double needs = rate > 0 ? static_cast<double>(item.bytes) / (rate * order.threads) : 0;
    if (static_cast<double>(std::time(nullptr)) + needs > static_cast<double>(*deadline_)) {
      leave_for_later(item.scan, "put off: it would not end by resources.until");
      return false;
    }
  }
  if (p_.journal && Clock::now() - space_checked_ > kSpaceInterval) {
    space_checked_ = Clock::now();
    if (const std::string lack = lack_of_space(item); !lack.empty()) {
      p_.complain(fail(Code::NoSpace, lack, p_.tree.root()));
      code_ = kExitInternal;
      return false;
    }
  }
  return true;
}

/// The files of a result take about as much as its inputs; empty when there is room.
std::string Scheduler::lack_of_space(const WorkItem& item) const {
  const auto space = store::free_space(p_.tree.root());
  const std::uint64_t needs = item.bytes + kLeastSpace;
  if (!space || *space >= space_floor_ + needs) return {};
  const std::string of_scan = name(item.scan) + " needs " + bytes_text(needs) + " at least; ";
  if (p_.how.disk > 0)
    return "of the " + bytes_text(p_.how.disk) + " of disk that resources.disk (--disk) allows the run " +
           bytes_text(*space - std::min(*space, space_floor_)) +
           " are left (what others write there takes of it too), and " + of_scan +
           "raise it, and run again: what is done is kept";
  return bytes_text(*space) + " of disk are free, of which the run leaves " + bytes_text(space_floor_) +
         " alone, and " + of_scan +
         "free space or say how much the run may use (resources.disk, --disk), and run again: what is done is kept";
}

void Scheduler::put_off(const std::string& why) {
  for (const WorkItem& item : list_.drop_all())
    if (!why.empty()) p_.report.scans[item.scan].notes.push_back(why);
}

/// An attempt is over: its entry, and whether there will be another.
void Scheduler::end(Ended&& ended) {
  const std::size_t scan = ended.order.scan;
  const WorkItem item = take_from_work(ended.order);
  if (!item.part.empty()) return end_part(item, std::move(ended));
  ScanEntry& entry = p_.report.scans[scan];
  std::string fingerprint;
  bool output_is_bad = false;
  if (ended.attempt) {
    entry = std::move(ended.attempt->entry);
    fingerprint = std::move(ended.attempt->fingerprint);
    output_is_bad = ended.attempt->output_is_bad;
    if (p_.executor.running().empty() || !ended.attempt->hashes.empty()) p_.work.load_hashes(ended.attempt->hashes);
  } else {
    take_over_death(ended, entry);
    if (p_.journal && !p_.executor.is_remote()) p_.tree.remove_attempts(entry.name);
  }
  if (cut_began_.contains(scan)) entry.seconds = seconds_of_cut(scan, ended);
  if (ended.peak_memory > 0) entry.peak_memory = ended.peak_memory;
  const bool again = !output_is_bad && entry.failure != FailureClass::None && goes_again(item, ended, entry);
  if (p_.journal) note_end(item, ended, again);
  if (again) return;
  finish_scan(item, ended, fingerprint);
  if (output_is_bad) code_ = kExitInternal;
}

/// Of a scan that failed: an earlier result stays.
void Scheduler::keep_result(ScanEntry& entry) const {
  const bool has_result = store::exists(p_.tree.scan(entry.name) + "/" + kStateFile);
  entry.fate = has_result ? ScanFate::Stale : ScanFate::Failed;
  if (has_result) entry.files = result_files(p_.tree, entry.name);
}

/// The process died without an answer.
void Scheduler::take_over_death(Ended& ended, ScanEntry& entry) const {
  ++entry.attempts;
  if (entry.why.empty()) entry.why = {"new or changed"};
  entry.seconds += ended.seconds;
  entry.cpu_seconds += ended.cpu_seconds;
  entry.failed_stage = ended.stage;
  if (entry.started.empty()) entry.started = utc_now();
  entry.ended = utc_now();
  keep_result(entry);
  const std::string stage = ended.stage.empty() ? "" : " in stage " + ended.stage;
  if (p_.stop.flag.is_set()) {
    entry.fate = ScanFate::Interrupted;
    entry.failure = FailureClass::Cancelled;
    entry.error = fail(Code::Cancelled, "stopped on request" + stage);
  } else if (ended.over_time) {
    entry.failure = FailureClass::Internal;
    entry.error = fail(Code::Internal, "the time limit of " + clock_text(p_.how.scan_time_limit_s) + " h was reached" +
                                           stage + "; raise resources.scan_time_limit or choose larger bins");
  } else if (ended.killed_by_system) {
    entry.failure = FailureClass::Resource;
    entry.error = fail(Code::NoSpace,
                       "the worker was killed from outside" + stage +
                           ", most likely because the machine ran out of memory; lower resources.memory or "
                           "resources.threads, or choose larger bins",
                       "memory");
  } else if (ended.death.starts_with("signal 9 ")) {
    entry.failure = FailureClass::Internal;
    entry.error = fail(Code::Internal, "the worker was killed from outside (SIGKILL)" + stage +
                                           ", and memory was not short; look for who did it: an operator, a watchdog, "
                                           "a limit of the batch system");
  } else {
    entry.failure = FailureClass::Internal;
    entry.error = fail(Code::Internal, "the worker died of " + ended.death + stage +
                                           "; please report it with the scan's log: the other scans are not touched");
  }
}

bool Scheduler::goes_again(WorkItem item, const Ended& ended, const ScanEntry& entry) {
  if (p_.stop.signal != 0 || p_.stop.flag.is_set() || p_.options.dry_run) return false;
  std::string why;
  const double passed = p_.how.retry_wait_s * std::pow(4, item.transient);
  // Shares of all cores come to a few bytes less than the whole.
  const bool had_all = ended.order.memory >= p_.memory - p_.memory / 100;
  // The memory of a process that made other scans is in pieces: what lacked it there gets one of its own.
  if (entry.failure == FailureClass::Resource && p_.memory > 0 && (!had_all || ended.reused)) {
    item.memory = std::min(p_.memory, 2 * ended.order.memory);
    why = had_all ? "in a process of its own"
                  : "with " + bytes_text(item.memory) + " of memory in place of " + bytes_text(ended.order.memory);
  } else if (may_heal(item.scan, missing_part(entry, p_.tree, item.part))) {
    why = "at once";
  } else if (entry.failure == FailureClass::Transient && item.transient < p_.how.retry_transient) {
    item.not_before = Clock::now() + std::chrono::milliseconds(static_cast<std::int64_t>(1000 * passed));
    ++item.transient;
    why = "in " + number_text(passed) + " s";
  } else if (!ended.attempt && !ended.over_time && item.internal < p_.how.retry_internal) {
    ++item.internal;
    why = "once more";
  } else {
    return false;
  }
  p_.console.note(entry.name, entry.error.text() + "; tried again " + why);
  ScanEntry& next = p_.report.scans[item.scan];
  next.fate = ScanFate::Pending;
  next.failure = FailureClass::None;
  next.error = {Code::Internal, {}, {}};
  list_.add(item);
  return true;
}

void Scheduler::note_end(const WorkItem& item, const Ended& ended, bool again) {
  const ScanEntry& entry = p_.report.scans[item.scan];
  Node event = event_for("end", entry.name);
  event.set("state", again ? "again" : name_of(entry.fate));
  if (!entry.error.message.empty()) {
    event.set("class", name_of(entry.failure));
    event.set("text", entry.error.text());
  }
  event.set("seconds", ended.seconds);
  const auto parts = parts_.find(item.scan);  // of a scan that was cut they count as well: forecasts go by it
  event.set("core_seconds",
            ended.seconds * ended.order.threads + (parts == parts_.end() ? 0 : parts->second.core_seconds));
  event.set("bytes", item.bytes);
  if (entry.fate == ScanFate::Done && item.memory > 0) event.set("needs_memory", item.memory);
  if (!entry.record_identity.empty()) event.set("record", entry.record_identity);
  p_.journal->add(std::move(event));
}

void Scheduler::finish_scan(const WorkItem& item, const Ended& ended, const std::string& fingerprint) {
  ScanEntry& entry = p_.report.scans[item.scan];
  bytes_done_ += item.bytes;
  if (const auto parts = parts_.find(item.scan); parts != parts_.end())
    bytes_found_ += static_cast<double>(item.bytes) * parts->second.found;
  parts_.erase(item.scan);
  core_seconds_ += ended.seconds * ended.order.threads;
  leave_quarantine(entry);
  const bool stays = entry.failure == FailureClass::BadInput || entry.failure == FailureClass::Resource ||
                     entry.failure == FailureClass::Internal;
  if (stays && p_.journal && (entry.fate == ScanFate::Failed || entry.fate == ScanFate::Stale)) {
    std::string known = fingerprint;
    if (known.empty() && !ended.attempt)
      if (const auto now =
              p_.work.fingerprint(p_.selection.scans[item.scan].number, *p_.selection.scans[item.scan].what))
        known = now->value;
    if (!known.empty())
      p_.quarantine.add(
          entry.name, {known, entry.error.text(), entry.failure, utc_now(), entry.attempts,
                       entry.failure == FailureClass::Resource ? p_.memory : 0,
                       ended.over_time ? p_.how.scan_time_limit_s : 0, entry.error.where == "disk" ? p_.how.disk : 0});
  }
  show(entry);
}

/// The journal, run.json and what the operator sees.
void Scheduler::keep_state() {
  if (!p_.journal || code_ != 0) return;
  if (auto kept = p_.journal->commit(); !kept) {
    p_.complain(kept.error());
    code_ = kExitInternal;
    return;
  }
  view_.show(picture());
  if (seconds_since(saved_) < std::max(1.0, save_took_ / kSaveShare)) return;
  const auto begin = Clock::now();
  code_ = p_.save();
  saved_ = Clock::now();
  save_took_ = seconds_since(begin);
}

RunPicture Scheduler::picture() const {
  std::string remark = remark_;
  if (const std::string waits = p_.executor.waits_for(); !waits.empty())
    remark += (remark.empty() ? "pending: " : "; pending: ") + waits;
  const std::uint64_t bytes_done = bytes_done_ + static_cast<std::uint64_t>(bytes_of_parts());
  std::set<std::size_t> handed_out;
  for (const Running& one : p_.executor.running()) handed_out.insert(one.order.scan);
  RunPicture picture{p_.report,
                     p_.executor.running(),
                     names_,
                     list_.scans_beside(handed_out),
                     bytes_done,
                     bytes_all_,
                     remark,
                     seconds_since(began_),
                     p_.stop.signal != 0};
  picture.parts = &parts_;
  if (p_.executor.is_remote() || core_seconds_ <= 0) return picture;
  picture.cores = p_.report.threads;
  picture.core_seconds = core_seconds_;
  picture.bytes_found = bytes_found_;
  for (const auto& [scan, parts] : parts_) picture.bytes_found += static_cast<double>(parts.bytes) * parts.found;
  const double rate = std::max(0.0, static_cast<double>(bytes_done) - picture.bytes_found) / core_seconds_;
  for (const Running& one : p_.executor.running())
    for (const WorkItem& item : at_work_) {
      if (item.scan != one.order.scan || item.part != one.order.part) continue;
      const double spent = rate * one.order.threads * seconds_since(one.began);
      picture.bytes_begun += std::min(spent, share_of(item) - kOverdue * spent);
    }
  return picture;
}

}  // namespace scanmill::runner
