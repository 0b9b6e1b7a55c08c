// SPDX-License-Identifier: Apache-2.0
// What comes back: records of tasks, signs of life, Slurm's words; and when an element is over.
#include <algorithm>
#include <filesystem>

#include "base/text.hpp"
#include "runner/scan_messages.hpp"
#include "runner/slurm_run.hpp"
#include "runner/task.hpp"
#include "store/files.hpp"

namespace scanmill::runner {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using document::Node;

/// Whether a row tells that the element waits until a person lets it go on.
bool is_held(const Element& element) {
  if (element.word == "REQUEUE_HOLD" || element.word == "RESV_DEL_HOLD" || element.word == "SPECIAL_EXIT") return true;
  const std::string& reason = element.reason;
  return reason.starts_with("JobHeld") || reason.find("held") != std::string::npos;
}

}  // namespace

bool SlurmRun::has_submitted() const {
  return std::any_of(waves_.begin(), waves_.end(), [](const Wave& wave) { return wave.submitted && !wave.closed; });
}

void SlurmRun::read_records(Wave& wave) {
  std::error_code error;
  std::vector<std::pair<std::size_t, std::size_t>> records;
  for (fs::directory_iterator it(wave.folder.folder, error), end; !error && it != end; it.increment(error)) {
    const std::string file = it->path().filename().string();
    if (const auto began = began_numbers(file)) {
      know_number(began->second);
      if (began->first >= wave.elements.size() || wave.elements[began->first].began) continue;
      wave.elements[began->first].began = true;
      wave.elements[began->first].last_sign = wave.elements[began->first].began_at = Clock::now();
      list_changed_ = true;
    } else if (const auto numbers = result_numbers(file)) {
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

void SlurmRun::hear(Element& element, const std::string& path) {
  const auto stamp = store::stamp_of(path);
  if (!stamp || stamp->mtime_ns <= element.beat_ns) return;
  element.beat_ns = stamp->mtime_ns;
  element.beat_file = path;
  element.last_sign = element.heard = Clock::now();
  started_ = true;
  if (element.heartbeat && Clock::now() - element.beat_read < std::chrono::seconds(1)) return;
  if (auto beat = load_heartbeat(path)) {
    element.heartbeat = *std::move(beat);
    element.beat_read = Clock::now();
    list_changed_ = true;
  }
}

void SlurmRun::take(Element& element, std::size_t item, TaskResult result) {
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

void SlurmRun::look() {
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
    silent_ = list_changed_ = true;
    doubt_all();
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
  find_forgotten();
  list_changed_ = true;
}

void SlurmRun::see(Element& element, const QueueRow& row) {
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
  element.restarts = row.restarts;
  if (!row.node.empty()) element.node = row.node;
  if (alive) {
    element.last_sign = Clock::now();
    element.over_since = {};
  } else if (!element.is_over()) {
    element.over_since = Clock::now();
  }
  element.phase = phase;
}

void SlurmRun::judge(std::size_t w) {
  bool all = true;
  for (std::size_t e = 0; e < waves_[w].elements.size(); ++e) {
    Element& element = waves_[w].elements[e];
    if (!element.settled && element.has_all()) element.settled = true;
    if (!element.settled && waves_[w].submitted) judge_element(waves_[w], e);
    all &= element.settled;
  }
  if (all) close(waves_[w], false);
}

bool SlurmRun::lives(const Wave& wave, const Element& element) const {
  if (element.beat_file.empty())  // its program may be about to come up
    return wave.in_doubt && element.began && age_s(element.began_at) < o_.keys.lease_s;
  if (age_s(element.heard) >= o_.keys.lease_s) return false;
  // A sign that came when Slurm had told of the end for a while tells that Slurm is wrong, or tells of another's end.
  const bool after_end = element.heard > element.over_since + seconds(std::max(1.0, o_.keys.lease_s / 4));
  return (wave.in_doubt || after_end) && store::exists(element.beat_file);
}

void SlurmRun::judge_element(Wave& wave, std::size_t e) {
  Element& element = wave.elements[e];
  if (element.is_over()) {
    // Its records may be under way on a network file system; that it says to have ended well most of all.
    const bool well = *element.phase == JobPhase::Ended && element.wait_status == 0;
    const double patience = draining_ ? 0.2 : well ? o_.keys.lease_s : std::min(o_.keys.lease_s, 2 * o_.keys.poll_s);
    if (age_s(element.over_since) < patience) return;
    read_records(wave);
    if (!draining_ && !element.has_all() && lives(wave, element)) return;
    if (!element.has_all()) resolve(wave, e, *element.phase);
    element.settled = true;
    return;
  }
  if (element.seen && element.phase == JobPhase::Waiting && is_held(element)) return judge_held(wave, e);
  if (element.seen) return;
  // Slurm does not know it, or does not answer. Only silence of both for the whole lease means that it is lost.
  if (answered_ <= element.last_sign || age_s(element.last_sign) < o_.keys.lease_s) return;
  read_records(wave);
  if (!element.seen) may_repeat_numbers_ = wave.in_doubt = true;
  if (!element.has_all()) resolve(wave, e, JobPhase::Lost);
  element.settled = true;
}

void SlurmRun::judge_held(Wave& wave, std::size_t e) {
  Element& element = wave.elements[e];
  if (!element.reason.starts_with("launch")) {
    const std::string job = element.job + "_" + std::to_string(e);
    if (warned_.insert(job).second)
      o_.note("", "job " + job + " is held (" +
                      (element.word == "PENDING" ? element.reason : element.word + ", " + element.reason) +
                      "): scontrol release " + job + " lets it go on");
    return;
  }
  (void)slurm_.cancel_element(element.job, e);
  read_records(wave);
  if (!element.has_all()) resolve(wave, e, JobPhase::Lost);
  element.settled = true;
}

}  // namespace scanmill::runner
