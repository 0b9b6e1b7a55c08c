// SPDX-License-Identifier: Apache-2.0
// What the end of an element means for its scans that have no record: whose fault it is, and what is tried next.
#include <sys/wait.h>

#include <algorithm>
#include <cstring>

#include "base/text.hpp"
#include "runner/last_words.hpp"
#include "runner/scan_messages.hpp"
#include "runner/slurm_run.hpp"
#include "runner/task.hpp"

namespace scanmill::runner {
namespace {

constexpr int kMostCancelled = 2, kMostLaunches = 2, kHopelessLaunches = 3;

}  // namespace

void SlurmRun::resolve(Wave& wave, std::size_t e, JobPhase phase) {
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
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL && !wave.in_doubt) phase = JobPhase::OutOfMemory;
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    if (code == 128 + SIGTERM || code == 128 + SIGINT) phase = JobPhase::Cancelled;
    if (code == kExitBusy) phase = JobPhase::Lost;
    if (wave.in_doubt && phase == JobPhase::Ended) phase = JobPhase::Lost;
    // An end that Slurm tells of an element that never ran here is another one's.
    if (!begun && phase == JobPhase::Ended && code == 0 && !element.began) phase = JobPhase::Lost;
    if (!begun && phase == JobPhase::Ended) return failed_launch(wave, e, left, code);
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

void SlurmRun::blame(const Wave& wave, std::size_t e, Wanted& wanted, JobPhase phase, bool begun) {
  const Element& element = wave.elements[e];
  const std::size_t scan = wanted.unit;
  Ended ended;
  ended.stage = element.heartbeat ? element.heartbeat->stage : "";
  const std::string job = "job " + (element.job.empty() ? wave.folder.name : element.job) + "_" + std::to_string(e);
  const std::string log = last_words(wave.folder.folder + "/" + std::to_string(e) + ".log", 0, 2);
  const std::string node = element.node.empty() ? "" : " on " + element.node;
  const bool is_sure = begun && (phase == JobPhase::OutOfMemory || phase == JobPhase::TimeLimit);
  if (wave.in_doubt && !is_sure &&
      excuses(wanted,
              element.forgotten ? ""  // told when it was taken back
              : !element.seen   ? "vanished without a sign"
                                : "ended without a record (" + element.word + ")",
              job + node))
    return;
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
        return again(scan, 0, job + " reached its time limit" + node);
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
      return lose(wanted,
                  job + (element.seen ? " was lost (" + element.word + ")" + node : " vanished without a sign"));
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

void SlurmRun::lose(Wanted& wanted, const std::string& what) {
  if (++wanted.lost <= o_.keys.resubmits) return again(wanted.unit, wanted.lost, what);
  fail_scan(wanted.unit, FailureClass::Transient,
            fail(Code::IoFailed, "its job was lost " + std::to_string(wanted.lost) + " times, the last time: " + what +
                                     "; look at the nodes, and run again"));
}

void SlurmRun::failed_launch(Wave& wave, std::size_t e, const std::vector<std::size_t>& left, int code) {
  Element& element = wave.elements[e];
  const std::string log = last_words(wave.folder.folder + "/" + std::to_string(e) + ".log", 0, 2);
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

void SlurmRun::close(Wave& wave, bool all) {
  if (wave.closed) return;
  wave.closed = true;
  const bool waits = std::any_of(wave.elements.begin(), wave.elements.end(),
                                 [](const Element& element) { return element.phase == JobPhase::Waiting; });
  if (all || waits) (void)slurm_.cancel(wave.folder.name, all ? "" : "PENDING", "");
  if (silent_) closed_unheard_.push_back(wave.folder.name);
  close_wave(wave.folder);
  list_changed_ = true;
}

}  // namespace scanmill::runner
