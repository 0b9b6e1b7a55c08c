// SPDX-License-Identifier: Apache-2.0
// What is at work where, and why the rest waits: in Slurm's words, grouped, and said once.
#include <algorithm>
#include <filesystem>

#include "base/text.hpp"
#include "runner/slurm_run.hpp"

namespace scanmill::runner {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kIdleLook = 30;        // s, between looks at the nodes
constexpr double kTellAgain = 10 * 60;  // s
constexpr std::size_t kMostReasons = 3, kMostShown = 4;

/// Slurm's reason for waiting, as words.
std::string words_of_reason(const Element& element) {
  if (element.reason.empty() || element.reason == "None") return "not looked at by Slurm yet";
  std::string text = element.reason;
  std::replace(text.begin(), text.end(), '_', ' ');
  // Cut by squeue: the start says all.
  if (const auto rest = text.find(" or reserved for"); rest != std::string::npos) text.resize(rest);
  return text;
}

/// What passes by itself on every cluster.
bool is_usual(const std::string& reason) {
  static constexpr std::string_view kUsual[] = {"not looked at", "not submitted", "Resources", "Priority",
                                                "BeginTime",     "Cleaning",      "Prolog",    "JobArrayTaskLimit"};
  return std::any_of(std::begin(kUsual), std::end(kUsual),
                     [&](std::string_view usual) { return reason.starts_with(usual); });
}

bool is_of_nodes(const std::string& reason) {
  static constexpr std::string_view kNodes[] = {"DOWN", "DRAIN", "ReqNodeNotAvail", "NodeDown", "nodes", "Nodes"};
  return std::any_of(std::begin(kNodes), std::end(kNodes),
                     [&](std::string_view word) { return reason.find(word) != std::string::npos; });
}

}  // namespace

void SlurmRun::list_running() {
  running_.clear();
  reasons_.clear();
  std::map<std::size_t, std::size_t> place;
  for (const auto& [scan, wanted] : wanted_) {
    place[scan] = running_.size();
    running_.push_back({wanted.order, 0, wanted.began, "", 0, 0, {}, true, ""});
    if (wanted.waits) ++reasons_["not submitted yet"];
  }
  for (const Wave& wave : waves_) {
    if (wave.closed) continue;
    for (std::size_t e = 0; e < wave.elements.size(); ++e) list_element(wave, e, place);
  }
  list_waiting();
  list_changed_ = false;
}

void SlurmRun::list_element(const Wave& wave, std::size_t e, const std::map<std::size_t, std::size_t>& place) {
  const Element& element = wave.elements[e];
  if (element.settled) return;
  const bool works = element.heartbeat.has_value() || (element.seen && element.phase == JobPhase::Running);
  const std::string job = element.job.empty() ? "" : "job " + element.job + "_" + std::to_string(e);
  const std::string reason = !wave.submitted                                      ? "not submitted yet"
                             : element.seen && element.phase == JobPhase::Waiting ? words_of_reason(element)
                             : element.seen                                       ? "over, their records awaited"
                             : silent_                                            ? "Slurm does not answer"
                                                                                  : "not known to Slurm";
  for (std::size_t i = 0; i < element.scans.size(); ++i) {
    const auto at = place.find(element.scans[i]);
    if (at == place.end() || element.recorded[i]) continue;
    Running& one = running_[at->second];
    one.place = job + (element.node.empty() ? "" : (job.empty() ? "on " : " on ") + element.node);
    if (!works) {
      ++reasons_[reason];
      one.stage = reason;
      continue;
    }
    const std::size_t at_work = element.heartbeat ? element.heartbeat->item : 0;
    one.is_queued = i != at_work;
    one.stage = one.is_queued ? "next in its element" : "start";
    if (one.is_queued) ++reasons_["next in their elements"];
    if (one.is_queued || !element.heartbeat) continue;
    one.pid = element.heartbeat->pid;
    one.stage = element.heartbeat->stage;
    one.done = element.heartbeat->done;
    one.total = element.heartbeat->total;
  }
}

void SlurmRun::list_waiting() {
  std::vector<std::pair<std::size_t, std::string>> most;
  for (const auto& [reason, count] : reasons_) most.emplace_back(count, reason);
  std::sort(most.begin(), most.end(),
            [](const auto& a, const auto& b) { return a.first != b.first ? a.first > b.first : a.second < b.second; });
  waits_for_.clear();
  for (std::size_t i = 0; i < most.size() && i < kMostShown; ++i)
    waits_for_ += (i ? ", " : "") + std::to_string(most[i].first) + " " + most[i].second;
  if (!waits_for_.empty() && !idle_nodes_.empty()) waits_for_ += " (" + idle_nodes_ + ")";
}

/// Once, again when it is another reason, and every now and then.
void SlurmRun::tell_of_waiting() {
  std::string told;
  bool of_nodes = false;
  for (const auto& [reason, count] : reasons_) {
    if (is_usual(reason) || reason.starts_with("next in") || reason.starts_with("over,") ||
        reason.starts_with("Slurm does not") || reason.starts_with("not known"))
      continue;
    told += (told.empty() ? "" : ", ") + reason;
    of_nodes |= is_of_nodes(reason);
  }
  if (told.empty() || silent_ || draining_) {
    if (told.empty() && !told_waits_.empty() && !silent_) told_waits_.clear(), idle_nodes_.clear();
    return;
  }
  if (of_nodes && (Clock::now() >= next_idle_look_ || told != looked_at_)) {
    looked_at_ = told;
    idle_nodes_ = idle_nodes();
    next_idle_look_ = Clock::now() + seconds(std::max(kIdleLook, o_.keys.poll_s));
    list_waiting();
  }
  if (of_nodes) told += idle_nodes_;
  if (told == told_waits_ && age_s(told_) < kTellAgain) return;
  told_waits_ = told;
  told_ = Clock::now();
  o_.note("", "on the cluster: " + waits_for_);
}

std::string SlurmRun::idle_nodes() {
  std::string text, nodes;
  std::size_t count = 0;
  for (const IdleNodes& one : slurm_.idle_nodes(o_.keys.partition)) {
    if (count++ >= kMostReasons) continue;
    text += (text.empty() ? "" : ", ") + one.nodes + " " + one.state + ": " + one.reason;
    nodes += (nodes.empty() ? "" : ",") + one.nodes;
  }
  if (text.empty()) return {};
  if (count > kMostReasons) text += " and " + std::to_string(count - kMostReasons) + " more";
  return text + "; an administrator gives them back: scontrol update nodename=" + nodes + " state=resume";
}

}  // namespace scanmill::runner
