// SPDX-License-Identifier: Apache-2.0
#include "runner/run_view.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "base/text.hpp"
#include "runner/machine.hpp"
#include "store/files.hpp"

namespace scanmill::runner {

using document::Node;

namespace {

constexpr auto kTtyInterval = std::chrono::milliseconds(100);
constexpr auto kHeartbeat = std::chrono::seconds(60);
constexpr auto kJsonInterval = std::chrono::seconds(3);
constexpr double kLongSilence_s = 10;
constexpr auto kSaveInterval = std::chrono::seconds(2);

double age_of(const Running& one) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - one.began).count();
}

/// Seconds since its latest sign; 0 where that is not told.
double silence_of(const Running& one) {
  if (one.heard == std::chrono::steady_clock::time_point{}) return 0;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - one.heard).count();
}

/// "1:07" or "2:01:07"
std::string short_clock(double seconds) {
  std::string text = clock_text(seconds);
  return text.starts_with("00:") ? text.substr(text[3] == '0' ? 4 : 3) : text;
}

std::vector<const Running*> slowest_first(std::span<const Running> running) {
  std::vector<const Running*> list;
  for (const Running& one : running) list.push_back(&one);
  std::sort(list.begin(), list.end(), [](const Running* a, const Running* b) {
    return a->is_queued != b->is_queued ? b->is_queued : a->began < b->began;
  });
  return list;
}

/// "bun" or "bun frame-3"
std::string name_of_running(const RunPicture& picture, const Running& one) {
  const std::string& part = one.order.part;
  return picture.names[one.order.scan] + (part.empty() || part == one.stage ? "" : " " + part);
}

/// Of a part that is at work.
const PartCount* parts_of(const RunPicture& picture, const Running& one) {
  if (!picture.parts || one.order.part.empty()) return nullptr;
  const auto found = picture.parts->find(one.order.scan);
  return found == picture.parts->end() ? nullptr : &found->second;
}

/// ", 19 of 36 parts done", or nothing for a scan in one piece.
std::string parts_text(const RunPicture& picture, const Running& one) {
  const PartCount* parts = parts_of(picture, one);
  return parts ? ", " + std::to_string(parts->done) + " of " + counted(parts->all, "part") + " done" : "";
}

std::uint64_t percent(std::uint64_t part, std::uint64_t whole) {
  return whole == 0
             ? 0
             : std::min<std::uint64_t>(
                   100, static_cast<std::uint64_t>(100.0 * static_cast<double>(part) / static_cast<double>(whole)));
}

std::uint64_t failed_of(const RunReport& report) {
  return report.count(ScanFate::Failed) + report.count(ScanFate::Stale);
}

/// Scans; one whose parts are at work counts once.
std::size_t count_at_work(const RunPicture& picture) {
  std::set<std::size_t> scans;
  for (const Running& one : picture.running)
    if (!one.is_queued) scans.insert(one.order.scan);
  return scans.size();
}

/// ", 3 pending, 5 parts pending", as far as there are any.
std::string queued_text(const RunPicture& picture) {
  std::size_t scans = 0, parts = 0;
  for (const Running& one : picture.running)
    if (one.is_queued) ++(one.order.part.empty() ? scans : parts);
  return (scans > 0 ? ", " + std::to_string(scans) + " pending" : "") +
         (parts > 0 ? ", " + counted(parts, "part") + " pending" : "");
}

}  // namespace

double seconds_left(const RunPicture& picture) {
  if (!picture.running.empty() && count_at_work(picture) == 0) return 0;  // nobody knows when those begin
  const double done = static_cast<double>(picture.bytes_done) - picture.bytes_found;
  if (done < 1 || picture.seconds < 1) return 0;
  const double left = static_cast<double>(picture.bytes_all - picture.bytes_done);
  if (picture.cores == 0 || picture.core_seconds <= 0) return picture.seconds * left / done;
  return std::max(0.0, left - picture.bytes_begun) * picture.core_seconds / done / picture.cores;
}

std::string silence_text(double seconds) {
  return seconds < kLongSilence_s ? "" : ", no sign for " + std::to_string(std::llround(seconds)) + " s";
}

std::string line_of(const RunPicture& picture) {
  const RunReport& report = picture.report;
  std::string line = std::to_string(report.count(ScanFate::Done)) + " done";
  if (const auto unchanged = report.count(ScanFate::Unchanged)) line += ", " + std::to_string(unchanged) + " unchanged";
  if (const auto failed = failed_of(report)) line += ", " + std::to_string(failed) + " failed";
  const std::size_t at_work = count_at_work(picture);
  line += ", " + std::to_string(at_work) + " running";
  if (at_work > 0) {
    const Running& slowest = *slowest_first(picture.running).front();
    line += " (" + name_of_running(picture, slowest) + " " + slowest.stage + " " + short_clock(age_of(slowest)) +
            parts_text(picture, slowest) + ")";
  }
  line += queued_text(picture) + ", " + std::to_string(picture.waiting) + " waiting | " +
          std::to_string(percent(picture.bytes_done, picture.bytes_all)) + " % of " + bytes_text(picture.bytes_all) +
          " | " + short_clock(picture.seconds);
  if (const double left = seconds_left(picture); left > 0) line += ", about " + short_clock(left) + " left";
  if (!picture.remark.empty()) line += " | " + picture.remark;
  return line;
}

std::vector<std::string> block_of(const RunPicture& picture) {
  std::vector<std::string> lines;
  for (const Running* one : slowest_first(picture.running)) {
    if (one->is_queued) break;  // the remark tells of them
    std::string line = "  " + name_of_running(picture, *one) + "  " + one->stage;
    if (one->total > 0) line += "  " + std::to_string(percent(one->done, one->total)) + " %";
    line += "  " + short_clock(age_of(*one)) + ", " + counted(static_cast<std::uint64_t>(one->order.threads), "thread");
    line += parts_text(picture, *one);
    if (!one->place.empty()) line += ", " + one->place;
    line += silence_text(silence_of(*one));
    lines.push_back(std::move(line));
  }
  if (!picture.remark.empty()) lines.push_back("  " + picture.remark);  // the line below is cut at the screen's edge
  RunPicture counts = picture;
  counts.remark.clear();
  lines.push_back(line_of(counts));
  return lines;
}

Node to_document(const RunPicture& picture, std::uint64_t epoch) {
  const RunReport& report = picture.report;
  Node tree = Node::map();
  tree.set("scanmill_live", 1);
  tree.set("epoch", epoch);
  tree.set("host", report.host);
  tree.set("pid", report.pid);
  tree.set("job", report.job_path);
  tree.set("started", report.started);
  tree.set("heartbeat", utc_now());
  tree.set("seconds", picture.seconds);
  tree.set("seconds_left", seconds_left(picture));
  Node counts = Node::map();
  for (const ScanFate fate : {ScanFate::Unchanged, ScanFate::Done, ScanFate::Failed, ScanFate::Stale,
                              ScanFate::Quarantined, ScanFate::Interrupted})
    counts.set(name_of(fate), report.count(fate));
  counts.set("running", static_cast<std::uint64_t>(count_at_work(picture)));
  counts.set("waiting", static_cast<std::uint64_t>(picture.waiting));
  tree.set("counts", std::move(counts));
  tree.set("bytes_done", picture.bytes_done);
  tree.set("bytes", picture.bytes_all);
  if (!picture.remark.empty()) tree.set("remark", picture.remark);
  tree.set("stopping", picture.is_stopping);
  Node running = Node::sequence();
  for (const Running* one : slowest_first(picture.running)) {
    Node row = Node::map();
    row.set("scan", picture.names[one->order.scan]);
    if (!one->order.part.empty()) row.set("part", one->order.part);
    if (const PartCount* parts = parts_of(picture, *one)) {
      row.set("parts_done", static_cast<std::uint64_t>(parts->done));
      row.set("parts", static_cast<std::uint64_t>(parts->all));
    }
    if (one->is_queued) row.set("queued", true);
    if (!one->place.empty()) row.set("place", one->place);
    row.set("stage", one->stage);
    row.set("done", one->done);
    row.set("total", one->total);
    row.set("seconds", age_of(*one));
    row.set("silent_s", silence_of(*one));
    row.set("pid", one->pid);
    row.set("threads", one->order.threads);
    row.set("memory_bytes", one->order.memory);
    running.push(std::move(row));
  }
  tree.set("running", std::move(running));
  return tree;
}

void RunView::show(const RunPicture& picture) {
  const auto now = Clock::now();
  if (now >= next_save_) {
    next_save_ = now + kSaveInterval;
    // What cannot be written is not missed: the run goes on, and says so itself when it matters.
    (void)store::write_scratch(live_file_, document::to_json(to_document(picture, epoch_)) + "\n");
  }
  const ProgressStyle style = console_.style();
  const auto interval = style == ProgressStyle::Tty    ? Clock::duration(kTtyInterval)
                        : style == ProgressStyle::Json ? Clock::duration(kJsonInterval)
                                                       : Clock::duration(kHeartbeat);
  if (!began_ && style != ProgressStyle::Tty) next_show_ = now + interval;
  began_ = true;
  if (now < next_show_) return;
  next_show_ = now + interval;
  if (style == ProgressStyle::Tty) return console_.block(block_of(picture));
  if (style == ProgressStyle::Plain) return console_.progress_line(utc_now() + "  " + line_of(picture), Node());
  for (const Running& one : picture.running) {
    if (one.is_queued) continue;
    Node event = Console::event("progress");
    event.set("scan", picture.names[one.order.scan]);
    const PartCount* parts = parts_of(picture, one);  // of a cut scan they count, not the stages of a part
    event.set("stage", parts ? one.order.part : one.stage);
    event.set("done", parts ? static_cast<std::uint64_t>(parts->done) : one.done);
    event.set("total", parts ? static_cast<std::uint64_t>(parts->all) : one.total);
    event.set("per_second", 0.0);
    event.set("eta_s", 0.0);
    console_.progress_line("", event);
  }
}

void RunView::snapshot(const RunPicture& picture) {
  for (const std::string& line : block_of(picture)) console_.remark(line);
}

void RunView::end() {
  console_.end();
  (void)store::remove_tree(live_file_);
}

}  // namespace scanmill::runner
