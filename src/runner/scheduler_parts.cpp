// SPDX-License-Identifier: Apache-2.0
// Scans that are cut: their parts wave by wave, then the scan itself.
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "base/text.hpp"
#include "runner/machine.hpp"
#include "runner/scan_messages.hpp"
#include "runner/scheduler.hpp"
#include "store/files.hpp"

namespace scanmill::runner {

/// "cut into 4 map, 1 gather, 27 frame, 4 pick: 36 parts in 4 waves, then the scan itself"
void Scheduler::tell_of_cut(std::size_t scan) {
  CutState& cut = cut_[scan];
  if (std::exchange(cut.told, true)) return;
  std::string kinds;
  std::size_t count = 0;
  for (const auto& wave : cut.waves) {
    count += wave.size();
    std::map<std::string, std::size_t> of_kind;
    for (const std::string& part : wave) ++of_kind[part.substr(0, part.find(' '))];
    for (const auto& [kind, number] : of_kind)
      kinds += (kinds.empty() ? "" : ", ") + std::to_string(number) + " " + kind;
  }
  p_.console.note(name(scan), "cut into " + kinds + ": " + counted(count, "part") + " in " +
                                  counted(cut.waves.size(), "wave") + ", then the scan itself");
}

/// Of the CPU time of all; until the first part tells, parts and the scan itself count alike.
double Scheduler::CutState::share(std::size_t wave) const {
  if (wave < cpu.size()) return cpu[wave];
  std::size_t all = 1;
  for (const auto& one : waves) all += one.size();
  return static_cast<double>(wave < waves.size() ? waves[wave].size() : 1) / static_cast<double>(all);
}

/// The part of the scan's bytes that this work stands for, by its CPU time.
double Scheduler::share_of(const WorkItem& item) const {
  const auto found = parts_.find(item.scan);
  if (found == parts_.end()) return static_cast<double>(item.bytes);
  return static_cast<double>(found->second.bytes) * found->second.next;
}

/// Of scans that are not done, by the parts that are there.
double Scheduler::bytes_of_parts() const {
  double bytes = 0;
  for (const auto& [scan, parts] : parts_) bytes += static_cast<double>(parts.bytes) * parts.share;
  return bytes;
}

/// "3 scans and 2 parts of 1 scan"
std::string Scheduler::at_work_text(bool queued_too) const {
  std::size_t scans = 0, parts = 0;
  std::set<std::size_t> cut;
  for (const Running& one : p_.executor.running()) {
    if (one.is_queued && !queued_too) continue;
    if (one.order.part.empty()) {
      ++scans;
      continue;
    }
    ++parts;
    cut.insert(one.order.scan);
  }
  const std::string of_parts = parts == 0 ? "" : counted(parts, "part") + " of " + counted(cut.size(), "scan");
  if (scans == 0 && parts > 0) return of_parts;
  return counted(scans, "scan") + (parts > 0 ? " and " + of_parts : "");
}

/// Parts of the next wave, which share the bytes of the scan; after the last one the scan itself.
void Scheduler::put_next_wave(std::size_t scan) {
  CutState& cut = cut_[scan];
  WorkItem item;
  item.scan = scan;
  item.bytes = cut.bytes;
  item.memory = remembered_[scan];
  item.not_before = cut.not_before;
  item.transient = cut.passing;
  PartCount& count = parts_[scan];
  count = {0, 0, cut.bytes, count.core_seconds};
  for (std::size_t w = 0; w < cut.waves.size(); ++w) {
    count.all += cut.waves[w].size();
    if (w >= cut.next) continue;
    count.done += cut.waves[w].size();
    count.share += cut.share(w);
    if (w < cut.found.size() && cut.found[w]) count.found += cut.share(w);
  }
  count.next = cut.share(cut.next) / static_cast<double>(cut.next < cut.waves.size() ? cut.waves[cut.next].size() : 1);
  if (cut.next == cut.waves.size()) {
    if (cut.idle) parts_.erase(scan);
    cut_.erase(scan);
    return list_.add(item);
  }
  if (cut.next > 0) tell_of_cut(scan);  // the first reads the inputs: what is unchanged is not cut
  if (cut.whole[cut.next]) item.memory = std::max(item.memory, memory_guess(cut.bytes));
  const std::vector<std::string>& wave = cut.waves[cut.next++];
  cut.left = wave.size();
  item.bytes = std::max<std::uint64_t>(1, cut.bytes / wave.size());
  for (const std::string& part : wave) {
    item.part = part;
    list_.add(item);
  }
}

bool Scheduler::is_at_work(std::size_t scan) const {
  return std::any_of(at_work_.begin(), at_work_.end(), [&](const WorkItem& item) { return item.scan == scan; });
}

/// Each part of a scan may be lost as often as a fault may pass: those that are whole become more.
bool Scheduler::may_heal(std::size_t scan, const std::string& lost) {
  return !lost.empty() && lost_[{scan, lost}]++ < p_.how.retry_transient;
}

/// A part failed for a reason that may pass. One that it reads may be lost or was found damaged, so all of the scan's
/// waves come again: what is there is not made anew.
void Scheduler::begin_again(std::size_t scan, ScanEntry& entry, bool at_once) {
  CutState& cut = cut_[scan];
  if (!std::exchange(cut.again, true)) {
    const double wait = at_once ? 0 : p_.how.retry_wait_s * std::pow(4, cut.passing++);
    cut.not_before = at_once ? Clock::time_point{}
                             : Clock::now() + std::chrono::milliseconds(static_cast<std::int64_t>(1000 * wait));
    cut.next = 0;
    list_.drop(scan);
    ++entry.attempts;
    p_.console.note(entry.name,
                    entry.error.text() + "; tried again " + (at_once ? "at once" : "in " + number_text(wait) + " s"));
  }
  entry.fate = ScanFate::Pending;
  entry.failure = FailureClass::None;
  entry.error = {Code::Internal, {}, {}};
}

/// Why the parts of the scan would not fit on the disk, all that they will take there counted; nothing when they do.
std::optional<Error> Scheduler::lack_for_parts(std::size_t scan, const CutForecast& forecast) const {
  const auto space = store::free_space(p_.tree.root());
  if (!space || !p_.journal) return std::nullopt;
  const CutState& cut = cut_.at(scan);
  const std::uint64_t cap = p_.executor.is_remote() ? memory_guess(cut.bytes) : p_.memory;
  const std::uint64_t paged = cap > 0 ? forecast.memory - std::min(forecast.memory, unpaged_under(cap)) : 0;
  std::uint64_t wanted = 0;
  for (std::size_t n = 0; n < forecast.disk.size(); ++n) {
    const bool is_whole = n >= cut.whole.size() || cut.whole[n];
    if (forecast.disk[n] > 0) wanted = std::max(wanted, forecast.disk[n] + (is_whole ? paged : 0));
  }
  wanted -= std::min(wanted, p_.tree.bytes_of_parts(name(scan)));
  const std::uint64_t room = *space - std::min(*space, space_floor_);
  if (wanted <= room) return std::nullopt;
  const std::string needs = "about " + grouped(forecast.bins) + " bins are occupied: parts" +
                            (paged > 0 ? ", memory paged to disk" : "") + " and results need " + bytes_text(wanted) +
                            " of disk at one time; found ";
  if (p_.how.disk > 0 && space_floor_ > 0)
    return fail(Code::NoSpace,
                needs + bytes_text(room) + " of the " + bytes_text(p_.how.disk) +
                    " that resources.disk (--disk) allows the run; raise it, choose larger bins, or fewer "
                    "brick.pieces",
                "disk");
  return fail(Code::NoSpace,
              needs + bytes_text(room) + " free" +
                  (space_floor_ > 0 ? " beside the " + bytes_text(space_floor_) + " that the run leaves alone" : "") +
                  "; free space, choose larger bins, or fewer brick.pieces",
              p_.tree.root());
}

/// Wall time since the first of its parts began, in this run.
double Scheduler::seconds_of_cut(std::size_t scan, const Ended& ended) {
  const auto now = Clock::now();
  const auto began = now - std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(ended.seconds));
  return std::chrono::duration<double>(now - cut_began_.emplace(scan, began).first->second).count();
}

/// A part is there, is tried again, or its scan has failed. The others of the scan come to their end first.
void Scheduler::end_part(const WorkItem& item, Ended&& ended) {
  const auto found = cut_.find(item.scan);
  if (found == cut_.end()) return;
  CutState& cut = found->second;
  ScanEntry& entry = p_.report.scans[item.scan];
  const ScanEntry before = entry;
  bool output_is_bad = false;
  std::string fingerprint;
  if (ended.attempt) {
    entry = std::move(ended.attempt->entry);
    // Parts run side by side: each began with what the entry was then.
    entry.attempts = before.attempts;
    if (!before.started.empty()) entry.started = before.started;
    entry.cpu_seconds = before.cpu_seconds + ended.cpu_seconds;
    entry.peak_memory = std::max(before.peak_memory, ended.peak_memory);
    fingerprint = std::move(ended.attempt->fingerprint);
    output_is_bad = ended.attempt->output_is_bad;
    p_.work.load_hashes(ended.attempt->hashes);
  } else {
    take_over_death(ended, entry);
    entry.attempts = before.attempts;
  }
  entry.seconds = seconds_of_cut(item.scan, ended);
  bool is_refused = false;
  if (ended.attempt && ended.attempt->forecast && ended.attempt->forecast->cpu.size() == cut.waves.size() + 1) {
    cut.cpu = ended.attempt->forecast->cpu;
    cut.found.clear();
    for (const std::uint64_t bytes : ended.attempt->forecast->disk) cut.found.push_back(bytes == 0);
  }
  if (ended.attempt && ended.attempt->forecast && entry.failure == FailureClass::None)
    if (auto lack = lack_for_parts(item.scan, *ended.attempt->forecast)) {
      is_refused = true;
      entry.error = *std::move(lack);
      entry.failure = class_of(entry.error);
      entry.failed_stage = item.part;
      keep_result(entry);
    }
  core_seconds_ += ended.seconds * ended.order.threads;
  parts_[item.scan].core_seconds += ended.seconds * ended.order.threads;
  if (entry.fate == ScanFate::Unchanged) {
    entry = before;
    cut.idle = true;
    list_.drop(item.scan);
  }
  const bool failed = entry.failure != FailureClass::None;
  const bool goes_on = p_.stop.signal == 0 && !p_.stop.flag.is_set() && !p_.options.dry_run;
  const bool is_passing =
      failed && !is_refused && !cut.failed && !output_is_bad && entry.failure == FailureClass::Transient;
  const std::string lost = is_passing ? missing_part(entry, p_.tree, item.part) : "";
  const bool heals = goes_on && may_heal(item.scan, lost);
  const bool may_begin_again = heals || (lost.empty() && goes_on && cut.passing < p_.how.retry_transient);
  if (cut.again || (is_passing && may_begin_again))
    begin_again(item.scan, entry, heals);
  else if (failed && !is_refused && !cut.failed && !output_is_bad && goes_again(item, ended, entry)) {
    ++entry.attempts;
    return;
  }
  if (cut.again) {
    if (!is_at_work(item.scan)) {
      cut.again = false;
      put_next_wave(item.scan);
    }
    return;
  }
  if (failed) {
    if (!cut.failed) {
      cut.failed = entry;
      cut.fingerprint = fingerprint;
      list_.drop(item.scan);
    }
    entry = *cut.failed;
  }
  if (cut.failed) {
    entry = *cut.failed;
    if (is_at_work(item.scan)) return;
    WorkItem whole = item;
    whole.part.clear();
    whole.bytes = cut.bytes;
    const std::string known = cut.fingerprint;
    cut_.erase(found);
    ++entry.attempts;
    if (p_.journal) note_end(whole, ended, false);
    finish_scan(whole, ended, known);
    if (output_is_bad) code_ = kExitInternal;
    return;
  }
  if (cut.idle) {  // the scan itself says why
    if (is_at_work(item.scan)) return;
    cut.next = cut.waves.size();
    return put_next_wave(item.scan);
  }
  PartCount& count = parts_[item.scan];
  ++count.done;
  count.share += count.next;
  if (--cut.left == 0) put_next_wave(item.scan);
}

}  // namespace scanmill::runner
