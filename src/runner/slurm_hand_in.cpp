// SPDX-License-Identifier: Apache-2.0
// What goes to Slurm: scans packed to elements, elements to arrays; and the arrays of a driver that died.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/text.hpp"
#include "runner/pack_tasks.hpp"
#include "runner/slurm_run.hpp"
#include "runner/task.hpp"
#include "store/files.hpp"

namespace scanmill::runner {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using document::Node;

constexpr double kElementStart = 60;  // s, of an element's time limit

}  // namespace

void SlurmRun::flush() {
  if (broken_ || draining_) return;
  if (!took_leftovers_) drop_unwanted();
  const auto now = Clock::now();
  std::map<std::uint64_t, std::vector<std::size_t>> by_memory;
  for (const auto& [scan, wanted] : wanted_)
    if (wanted.waits && wanted.not_before <= now) by_memory[wanted.order.memory].push_back(scan);
  for (auto& [memory, scans] : by_memory) plan_waves(memory, scans);
  for (std::size_t w = 0; w < waves_.size() && !broken_ && next_try_ <= Clock::now(); ++w)
    if (!waves_[w].closed && !waves_[w].submitted) submit(waves_[w]);
}

void SlurmRun::plan_waves(std::uint64_t memory, const std::vector<std::size_t>& scans) {
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

std::size_t SlurmRun::most_elements() {
  if (!most_elements_) {
    most_elements_ = static_cast<std::size_t>(o_.keys.chunk);
    if (const auto most = slurm_.setting("MaxArraySize"); most && *most > 1)
      most_elements_ = std::min<std::size_t>(*most_elements_, *most - 1);
  }
  return *most_elements_;
}

void SlurmRun::make_one(const std::vector<std::vector<std::size_t>>& tasks, std::uint64_t memory) {
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

std::string SlurmRun::script_of(const TaskFile& file) const {
  std::string words;
  for (const std::string& word : o_.keys.wrap) words += shell_word(word) + " ";
  const std::string program = o_.keys.program.empty() ? own_path() : o_.keys.program;
  const std::string folder = o_.frame.out + "/work/" + file.token + "/";
  // The mark tells that the element began, and under which number, before anything of ours could fail.
  return "#!/bin/sh\n( : >" + shell_word(folder) + began_name("\"$SLURM_ARRAY_TASK_ID\"", "\"$SLURM_JOB_ID\"") +
         " ) 2>/dev/null\nexec " + words + shell_word(program) + " task " + shell_word(folder + kTaskFileName) +
         " \"$SLURM_ARRAY_TASK_ID\"\n";
}

std::string SlurmRun::own_path() {
  std::error_code error;
  const auto path = fs::read_symlink("/proc/self/exe", error);
  return error ? "scanmill" : path.string();
}

void SlurmRun::submit(Wave& wave) {
  if (!wave.looked_up) {
    // The reply to the last submission was lost: perhaps the job was not.
    const auto rows = slurm_.look({wave.folder.name});
    if (!rows) return retry_later(wave, rows.error().text());
    wave.looked_up = true;
    wave.in_doubt |= !rows->empty();
    if (!rows->empty()) return accept(wave);
  }
  if (may_repeat_numbers_) skip_numbers();
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
  if (const auto job = slurm_.submit(spec, o_.keys, fault)) {
    know_number(std::strtoull(job->c_str(), nullptr, 10));
    return accept(wave);
  }
  wave.looked_up = false;
  if (fault.passing) return retry_later(wave, "sbatch: " + fault.text);
  broken_ = fail(Code::BadParameter,
                 "sbatch refused the work: " + fault.text + "; correct cluster, resources or the command line");
}

void SlurmRun::accept(Wave& wave) {
  wave.submitted = true;
  list_changed_ = true;
  for (Element& element : wave.elements) element.last_sign = Clock::now();
  next_look_ = std::max(next_look_, Clock::now() + scan_interval_);
  if (vain_tries_ > 0) o_.note("", "submitted after " + std::to_string(vain_tries_) + " tries in vain");
  vain_tries_ = 0;
}

/// One pause for all arrays: what keeps one of them back keeps all.
void SlurmRun::retry_later(Wave& wave, const std::string& why) {
  const double before = o_.keys.poll_s * std::pow(2, std::min(vain_tries_, 10) - 1);
  const double pause = std::min(kMostBackOff, std::max(o_.keys.poll_s, 2 * before));
  ++vain_tries_;
  wave.in_doubt = true;
  list_changed_ = true;
  if (before < kMostBackOff || vain_tries_ % 10 == 0)
    o_.note("", why + "; tried again in " + number_text(std::ceil(pause)) + " s");
  next_try_ = Clock::now() + seconds(pause);
}

void SlurmRun::take_over() {
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
    wave.in_doubt = true;    // what befell the controller meanwhile is not known
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

bool SlurmRun::adopt(std::size_t scan, const Wanted& wanted) {
  const auto offer = offers_.find(wanted.name + "\n" + wanted.keys + "\n" + wanted.order.part);
  if (offer == offers_.end()) return false;
  const auto [w, e, i] = offer->second;
  offers_.erase(offer);
  if (waves_[w].closed || waves_[w].elements[e].recorded[i]) return false;
  waves_[w].elements[e].scans[i] = scan;
  return true;
}

void SlurmRun::drop_unwanted() {
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

}  // namespace scanmill::runner
