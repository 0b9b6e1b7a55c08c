// SPDX-License-Identifier: Apache-2.0
// A controller that was killed comes back with what it had saved some seconds before: it starts elements again that run
// already, and gives numbers of jobs out again. Nodes refuse a number that they know, and Slurm then drains them
// ("Duplicate jobid"): what can be done against that is done here.
#include <algorithm>
#include <utility>

#include "base/text.hpp"
#include "runner/slurm_run.hpp"

namespace scanmill::runner {
namespace {

constexpr int kMostDoubts = 10;              // of a scan, before what befalls it counts
constexpr std::uint64_t kMostSkips = 500;    // of numbers: what a controller forgets, it started within seconds
constexpr std::uint64_t kNewRound = 100000;  // lower by so much: numbers began again at the cluster's first (MaxJobId)

}  // namespace

void SlurmRun::doubt_all() {
  may_repeat_numbers_ = true;
  for (Wave& wave : waves_)
    if (!wave.closed) wave.in_doubt = true;
}

void SlurmRun::know_number(std::uint64_t number) { highest_number_ = std::max(highest_number_, number); }

void SlurmRun::find_forgotten() {
  for (Wave& wave : waves_) {
    if (!wave.submitted || wave.closed) continue;
    const auto count =
        static_cast<std::size_t>(std::count_if(wave.elements.begin(), wave.elements.end(), [&](const Element& element) {
          // One whose record is there would be started again as well. What Slurm put back itself began too, and it
          // counts that; versions that do not tell are believed as long as they answer.
          return element.seen && element.began && element.phase == JobPhase::Waiting && !element.forgotten &&
                 (element.restarts == 0 || (element.restarts < 0 && wave.in_doubt));
        }));
    if (count == 0) continue;
    may_repeat_numbers_ = wave.in_doubt = true;
    o_.note("", "Slurm forgot that " + counted(count, "element") + " of array " + wave.elements.front().job +
                    " began, as a controller does that was killed; what it has waiting of them is taken back, "
                    "and submitted again when no task is at it");
    const auto done = slurm_.cancel(wave.folder.name, "PENDING", "");
    if (!done) o_.note("", done.error().text());
    for (Element& element : wave.elements)
      element.forgotten |= done.ok() && element.seen && element.phase == JobPhase::Waiting;
    next_look_ = {};
  }
  for (const std::string& name : std::exchange(closed_unheard_, {}))
    if (auto done = slurm_.cancel(name, "", ""); !done) closed_unheard_.push_back(name);
}

void SlurmRun::skip_numbers() {
  if (highest_number_ == 0) {
    may_repeat_numbers_ = false;
    return;
  }
  const std::string name = "scanmill-skip-" + new_token();
  std::uint64_t first = 0, count = 0;
  while (count < kMostSkips) {
    const auto number = slurm_.take_number(name, o_.keys);
    if (!number) break;  // what refuses it refuses the array as well, and says why
    ++count;
    if (first == 0) first = *number;
    may_repeat_numbers_ = *number <= highest_number_ && highest_number_ - *number < kNewRound;
    if (!may_repeat_numbers_) break;
  }
  if (count > 0) (void)slurm_.cancel(name, "", "");
  if (count > 1)
    o_.note("", "Slurm gives numbers of jobs out again, from " + std::to_string(first) + "; " + std::to_string(count) +
                    " are skipped, so that no node refuses a job as a duplicate");
  if (may_repeat_numbers_ && count == kMostSkips) highest_number_ = 0;  // that far is not its usual forgetting
}

bool SlurmRun::excuses(Wanted& wanted, const std::string& end, const std::string& job) {
  if (++wanted.doubts > kMostDoubts) return false;
  if (!end.empty()) {
    Excused& all = excused_[end];
    if (all.count++ == 0) all.name = wanted.name, all.job = job;
  }
  again(wanted.unit, wanted.doubts, "");
  return true;
}

/// A line for all that ended in the same way: a controller takes whole arrays with it.
void SlurmRun::tell_of_excused() {
  for (const auto& [end, all] : std::exchange(excused_, {})) {
    const std::string rest = end + "; submitted again, and it counts against nothing: the controller may have lost it";
    if (all.count == 1)
      o_.note(all.name, all.job + " " + rest);
    else
      o_.note("", all.job + " and others, of " + counted(all.count, "scan") + " such as " + all.name + ", " + rest);
  }
}

}  // namespace scanmill::runner
