// SPDX-License-Identifier: Apache-2.0
#include "runner/slurm_executor.hpp"

#include <poll.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/text.hpp"
#include "runner/pack_tasks.hpp"
#include "runner/scan_messages.hpp"
#include "runner/slurm_run.hpp"
#include "runner/task.hpp"
#include "store/files.hpp"

namespace scanmill::runner {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using document::Node;

constexpr std::uint64_t kUnknownMemory = 64ull << 30;
constexpr double kSilentLook = 2;  // s, between looks at most while the controller is out of reach
constexpr double kLeastTime = 300, kTimeOverForecast = 8;  // of a scan's share of an element's time limit

}  // namespace

SlurmRun::SlurmRun(SlurmOptions options)
    : o_(std::move(options)), slurm_([this] { return o_.stop.flag.is_set() && o_.stop.requests > 1; }) {
  scan_interval_ = seconds(std::clamp(o_.keys.poll_s / 4, 0.01, 2.0));
  take_over();
}

SlurmRun::~SlurmRun() {
  for (Wave& wave : waves_)
    if (!wave.closed) close(wave, true);
}

Result<void> SlurmRun::start(const Order& order) {
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

std::vector<Ended> SlurmRun::wait(std::chrono::milliseconds timeout) {
  flush();
  const auto now = Clock::now();
  if (now >= next_scan_) {
    next_scan_ = now + scan_interval_;
    for (Wave& wave : waves_)
      if (!wave.closed) read_records(wave);
  }
  if (now >= next_look_ && has_submitted()) {
    look();
    // What a controller that comes back has forgotten is to be noticed before it starts anything of ours again.
    const double pause = draining_ ? 1.0 : silent_ ? kSilentLook : o_.keys.poll_s;
    next_look_ = Clock::now() + seconds(std::min(pause, o_.keys.poll_s));
  }
  for (std::size_t w = 0; w < waves_.size(); ++w)
    if (!waves_[w].closed) judge(w);
  tell_of_excused();
  if (list_changed_) list_running();
  tell_of_waiting();
  if (ended_.empty() && !wanted_.empty()) (void)poll(nullptr, 0, static_cast<int>(timeout.count()));
  return std::exchange(ended_, {});
}

void SlurmRun::drain() {
  draining_ = true;
  give_back_waiting();
  for (Wave& wave : waves_) {
    if (wave.closed) continue;
    (void)store::write_scratch(wave.folder.folder + "/" + kDrainFile, "\n");
    if (auto done = slurm_.cancel(wave.folder.name, "PENDING", ""); !done) o_.note("", done.error().text());
  }
  next_look_ = {};
}

void SlurmRun::stop_all() {
  draining_ = stopping_ = true;
  give_back_waiting();
  for (Wave& wave : waves_)
    if (!wave.closed)
      if (auto done = slurm_.cancel(wave.folder.name, "", ""); !done) o_.note("", done.error().text());
  next_look_ = {};
}

void SlurmRun::kill_all() {
  draining_ = stopping_ = true;
  for (Wave& wave : waves_)
    if (!wave.closed) close(wave, true);
  std::vector<std::size_t> all;
  for (const auto& [scan, wanted] : wanted_) all.push_back(scan);
  for (const std::size_t scan : all) give_back(scan);
  list_running();
}

std::size_t SlurmRun::unit_of(const Order& order) {
  const auto [at, is_new] = unit_numbers_.emplace(std::pair(order.scan, order.part), units_.size());
  if (is_new) units_.push_back(order.scan);
  return at->second;
}

double SlurmRun::granted(const Wanted& wanted) const {
  if (o_.keys.time_s > 0) return o_.keys.time_s;
  const double forecast = forecast_seconds(wanted.bytes, o_.bytes_per_core_second, wanted.order.threads);
  return std::min(o_.frame.time_limit_s, std::max(kLeastTime, kTimeOverForecast * forecast));
}

void SlurmRun::finish(std::size_t scan, Ended ended) {
  const auto at = wanted_.find(scan);
  if (at == wanted_.end()) return;
  ended.order = at->second.order;
  ended_.push_back(std::move(ended));
  wanted_.erase(at);
  list_changed_ = true;
}

void SlurmRun::give_back(std::size_t scan) {
  Ended ended;
  Attempt attempt{entry_of(scan), {}, false, {}};
  ended.attempt = std::move(attempt);
  finish(scan, std::move(ended));
}

void SlurmRun::give_back_waiting() {
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

void SlurmRun::fail_scan(std::size_t scan, FailureClass failure, Error error) {
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

void SlurmRun::again(std::size_t scan, int count, const std::string& why) {
  const auto at = wanted_.find(scan);
  if (at == wanted_.end()) return;
  if (draining_) return give_back(scan);
  at->second.waits = true;
  at->second.not_before = Clock::now() + seconds(count > 1 ? std::min(kMostBackOff, std::pow(2, count - 1)) : 0);
  list_changed_ = true;
  if (!why.empty()) o_.note(at->second.name, why + "; submitted again");
}

std::unique_ptr<Executor> make_slurm_executor(SlurmOptions options) {
  return std::make_unique<SlurmRun>(std::move(options));
}

std::uint64_t cluster_memory(const ClusterKeys& keys, bool& is_known) {
  const auto largest = SlurmClient().largest_node(keys.partition);
  is_known = largest.has_value();
  const std::uint64_t node = largest.value_or(kUnknownMemory);
  return node > 2 * kTaskMemory ? node - kTaskMemory : node;
}

}  // namespace scanmill::runner
