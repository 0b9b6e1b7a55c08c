// SPDX-License-Identifier: Apache-2.0
#include "runner/task_signs.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "base/text.hpp"
#include "runner/machine.hpp"
#include "runner/slurm_waves.hpp"
#include "runner/task_result.hpp"
#include "store/files.hpp"

namespace scanmill::runner {
namespace {

/// Every scan of the task has its record, and none of them is about to be tried again by this task.
bool has_all_records(const SignOfLife& sign, const TaskFile& file, const std::string& folder) {
  if (sign.index >= file.tasks.size()) return false;
  for (std::size_t item = 0; item < file.tasks[sign.index].items.size(); ++item) {
    const std::string path = result_path(folder, sign.index, item);
    const auto record = load_result(path);
    if (!record) return false;
    const auto stamp = store::stamp_of(path);
    if (!is_final(*record) && (!stamp || stamp->mtime_ns < sign.time_ns)) return false;
  }
  return true;
}

/// Known for certain: on this machine since its last start, where numbers mean the same, and gone.
bool process_has_ended(const Heartbeat& beat) {
  if (beat.space.empty() || beat.space != process_space() || beat.host != host_name()) return false;
  const auto now = look_at_process(beat.pid);
  return !now || (beat.began != 0 && now->began != beat.began);
}

std::string utc_in(double seconds) {
  const std::time_t then = std::time(nullptr) + static_cast<std::time_t>(std::ceil(seconds));
  std::tm parts{};
  gmtime_r(&then, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

std::string who(const SignOfLife& sign) {
  std::string text = "task " + std::to_string(sign.index);
  const auto beat = load_heartbeat(sign.path);
  if (!beat) return text;
  text += ", pid " + std::to_string(beat->pid) + " on " + beat->host;
  return beat->engine.empty() ? text : text + ", " + beat->engine;
}

Result<void> wait_for_no_task(const WaveFolder& wave, const TaskFile& file) {
  std::optional<SignOfLife> latest;
  for (const SignOfLife& sign : signs_of(wave)) {
    const auto beat = load_heartbeat(sign.path);
    if (has_all_records(sign, file, wave.folder) || (beat && process_has_ended(*beat)))
      (void)unlink(sign.path.c_str());
    else if (!latest || sign.time_ns > latest->time_ns)
      latest = sign;
  }
  if (!latest) return {};
  const double age = age_by_folder(wave, latest->time_ns);
  if (age >= file.lease_s) return {};
  return fail(Code::Cancelled,
              "tasks of this worklist are at work (" + who(*latest) + ", last sign " +
                  std::to_string(std::llround(age)) + " s ago); wait for them or stop them, and run again: without " +
                  "another sign they count as dead from " + utc_in(file.lease_s - age) + " on",
              wave.worklist());
}

}  // namespace

Result<void> wait_for_no_task(const OutputTree& tree) {
  for (const WaveFolder& wave : open_waves(tree)) {
    if (!wave.name.empty()) continue;  // Slurm's: it knows of its tasks itself
    if (const auto file = load_task_file(wave.worklist())) TRY(wait_for_no_task(wave, *file));
  }
  return {};
}

}  // namespace scanmill::runner
