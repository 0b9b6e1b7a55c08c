// SPDX-License-Identifier: Apache-2.0
#include "runner/scan_maker.hpp"

#include <algorithm>
#include <chrono>
#include <new>

#include "base/paged_memory.hpp"
#include "base/text.hpp"
#include "runner/forecast.hpp"
#include "runner/journal.hpp"
#include "runner/machine.hpp"
#include "runner/part_seconds.hpp"
#include "runner/scan_messages.hpp"
#include "runner/test_fault.hpp"
#include "store/files.hpp"

namespace scanmill::runner {

using document::Node;

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kReadAtOnce = 1 << 20;  // bytes: hashing them takes less than a process does
constexpr std::uint64_t kLargestHashes = 1ull << 30;
constexpr const char* kPartHashes = "hashes";  // in the folder of a scan's parts
constexpr const char* kFromRecord = "outputs changed: written again from the record";

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

template <class F>
Result<Outcome> guarded(std::uint64_t memory, std::uint64_t cap, F&& body) {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    if (const std::string why = paged::refusal(); !why.empty())
      return paged::limit_was_reached()
                 ? fail(Code::NoSpace,
                        why + "; raise resources.memory or disk (--memory, --disk), or choose larger bins", "disk")
                 : fail(Code::NoSpace, why + "; free space there, and run again");
    return fail(Code::NoSpace,
                (memory < cap ? bytes_text(memory) + ", the worker's share of the memory cap of " + bytes_text(cap) +
                                    ", were used up"
                              : "the memory cap of " + bytes_text(memory) + " was reached") +
                    "; raise resources.memory (--memory) or choose larger bins",
                "memory");
  } catch (const std::exception& error) {
    return fail(Code::Internal, std::string("unexpected: ") + error.what() + "; please report it with the scan's log");
  }
}

/// Passes stages on and remembers the latest.
class StageWatch final : public Progress {
 public:
  StageWatch(Progress& onward, std::string& latest) : onward_(onward), latest_(latest) {}
  void stage(std::string_view name, std::uint64_t done, std::uint64_t total) override {
    {
      const std::lock_guard<std::mutex> guard(mutex_);
      if (latest_ != name) latest_ = name;
    }
    onward_.stage(name, done, total);
  }

 private:
  Progress& onward_;
  std::mutex mutex_;
  std::string& latest_;
};

}  // namespace

namespace {

std::vector<Word> names_of(const std::vector<OutputFile>& outputs) {
  std::vector<Word> files;
  files.reserve(outputs.size());
  for (const OutputFile& output : outputs) files.emplace_back(output.name);
  return files;
}

}  // namespace

std::vector<Word> result_files(const OutputTree& tree, const std::string& name) {
  const auto state = load_state(tree.scan(name));
  return state ? names_of(state->outputs) : std::vector<Word>();
}

Node to_document(const Attempt& attempt) {
  Node tree = Node::map();
  tree.set("scan", to_document(attempt.entry));
  tree.set("fingerprint", attempt.fingerprint);
  tree.set("output_is_bad", attempt.output_is_bad);
  tree.set("hashes", attempt.hashes);
  tree.set("message", attempt.entry.error.message);
  tree.set("where", attempt.entry.error.where);
  if (attempt.forecast) tree.set("forecast", to_document(*attempt.forecast));
  return tree;
}

Result<Attempt> attempt_from(const Node& tree) {
  const Node *scan = tree.find("scan"), *bad = tree.find("output_is_bad");
  std::string texts[4];
  const char* const keys[] = {"fingerprint", "hashes", "message", "where"};
  for (std::size_t i = 0; i < 4; ++i) {
    const Node* text = tree.find(keys[i]);
    if (!scan || !bad || !bad->is_bool() || !text || !text->is_string())
      return fail(Code::Internal, "a worker's answer has another form than expected");
    texts[i] = text->as_string();
  }
  Attempt attempt;
  TRY_ASSIGN(attempt.entry, entry_from(*scan));
  attempt.fingerprint = texts[0];
  attempt.hashes = texts[1];
  attempt.entry.error.message = texts[2];
  attempt.entry.error.where = texts[3];
  attempt.output_is_bad = bad->as_bool();
  if (const Node* forecast = tree.find("forecast")) attempt.forecast = cut_forecast_from(*forecast);
  return attempt;
}

/// True when the scan's result stands, or the same work failed before.
bool ScanMaker::settle(const SelectedScan& scan, const Fingerprint& fingerprint, const std::optional<ScanState>& state,
                       ScanEntry& entry) const {
  const std::string& name = scan.task.name;
  entry.why = reasons_to_run(state, frame_.tree.scan(name), fingerprint, *scan.what);
  if (!entry.why.empty() && mesh_stands(state, fingerprint)) entry.why.push_back(kFromRecord);
  if (entry.why.empty()) {
    entry.fate = ScanFate::Unchanged;
    entry.counts = state->counts;
    entry.record_identity = state->record_identity;
    entry.failed_gates = state->failed_gates;
    entry.files = names_of(state->outputs);
    return true;
  }
  const Quarantine::Entry* held =
      frame_.options.only.empty()
          ? frame_.quarantine.find(name, fingerprint.value, {frame_.memory, frame_.time_limit_s, frame_.disk})
          : nullptr;
  if (!held) return false;
  entry.fate = ScanFate::Quarantined;
  entry.error = fail(Code::BadInput, held->error);
  entry.failure = held->failure;
  return true;
}

Judgement ScanMaker::judge(const SelectedScan& scan, ScanEntry entry) const {
  const auto state = load_state(frame_.tree.scan(scan.task.name));
  auto fingerprint = frame_.work.known_fingerprint(scan.number, *scan.what);
  if (!fingerprint && state && frame_.work.look_at(scan.number).bytes <= kReadAtOnce)
    if (auto read = frame_.work.fingerprint(scan.number, *scan.what)) fingerprint = *std::move(read);
  Judgement judgement;
  judgement.entry = std::move(entry);
  if (fingerprint) judgement.needs_work = !settle(scan, *fingerprint, state, judgement.entry);
  return judgement;
}

Attempt ScanMaker::make(const SelectedScan& scan, ScanEntry entry, int threads, std::uint64_t memory,
                        Progress& progress) const {
  const std::string& name = scan.task.name;
  const auto began = Clock::now();
  const double cpu = cpu_seconds();
  const std::string started = utc_now();
  Attempt result;
  std::string latest;
  StageWatch watch(progress, latest);
  watch.stage("check inputs", 0, 0);
  auto fingerprint = frame_.work.fingerprint(scan.number, *scan.what);
  const auto state = load_state(frame_.tree.scan(name));
  if (fingerprint) {
    result.fingerprint = fingerprint->value;
    result.hashes = frame_.work.save_hashes_of(scan.number);
  }
  const auto end = [&] {
    if (entry.attempts > 0) {
      entry.started = entry.started.empty() ? started : entry.started;
      entry.ended = utc_now();
    }
    entry.seconds += seconds_since(began);
    entry.cpu_seconds += cpu_seconds() - cpu;
    entry.peak_memory = peak_memory();
    result.entry = std::move(entry);
    return std::move(result);
  };
  if (!fingerprint) {
    entry.why = {state ? "its inputs cannot be read" : "new"};
    fail_entry(scan.task.broken.empty() ? fingerprint.error() : fail(Code::BadInput, scan.task.broken),
               state.has_value(), entry);
    entry.failed_stage = latest;
    return end();
  }
  if (settle(scan, *fingerprint, state, entry) || frame_.options.dry_run) {
    if (entry.fate == ScanFate::Unchanged && !frame_.options.dry_run) frame_.tree.remove_parts(name);
    return end();
  }
  if (!scan.task.broken.empty()) {
    const Error broken = fail(Code::BadInput, scan.task.broken);
    if (const auto log = begin_log(scan, entry, threads, watch)) (*log)->line("failed: " + broken.text());
    fail_entry(broken, state.has_value(), entry);
    return end();
  }
  if (auto made = attempt(scan, *fingerprint, entry, threads, memory, watch); made) {
    entry.fate = ScanFate::Done;
  } else {
    const Error& error = made.error();
    const bool machine = class_of(error) == FailureClass::Transient;
    result.output_is_bad = machine && ((" " + error.where).find(" " + frame_.tree.root() + "/") != std::string::npos ||
                                       frame_.tree.is_unwritable());
    fail_entry(error, state.has_value(), entry);
    entry.failed_stage = latest;
  }
  return end();
}

CutParts ScanMaker::parts_of(const SelectedScan& scan) const {
  return frame_.work.parts_of(scan.number, *scan.what, frame_.bricks, frame_.tree.parts(scan.task.name));
}

/// Content hashes that an earlier part of the scan found: inputs of many gigabytes are hashed once, not by every node.
void ScanMaker::recall_hashes(const std::string& folder) const {
  const std::string path = folder + "/" + kPartHashes;
  if (!store::exists(path)) return;
  if (const auto source = store::open_file(path, path))
    if (const auto text = read_all(**source, kLargestHashes)) frame_.work.load_hashes(*text);
}

/// The result of the scan stands, or its mesh does, or it failed before: no part of it is of use.
bool ScanMaker::needs_no_part(const SelectedScan& scan, const Fingerprint& fingerprint, const ScanEntry& entry) const {
  const auto state = load_state(frame_.tree.scan(scan.task.name));
  ScanEntry judged = entry;
  return mesh_stands(state, fingerprint) || settle(scan, fingerprint, state, judged);
}

namespace {

/// What the log says of parts that are there.
std::vector<std::string> part_lines(const CutParts& parts) {
  std::vector<std::string> lines;
  for (const PartSeconds& took : seconds_in(parts))
    lines.push_back("part " + took.part + " took " + seconds_text(took.wall) + ", " + seconds_text(took.cpu) +
                    " of CPU time, " + took.ended + " on " + took.host);
  return lines;
}

}  // namespace

Attempt ScanMaker::make_part(const SelectedScan& scan, ScanEntry entry, const std::string& part, int threads,
                             std::uint64_t memory, Progress& progress) const {
  const auto began = Clock::now();
  const double cpu = cpu_seconds();
  if (entry.started.empty()) entry.started = utc_now();
  std::string latest;
  StageWatch watch(progress, latest);
  watch.stage(part, 0, 0);
  const std::string folder = frame_.tree.parts(scan.task.name);
  bool is_idle = false;
  Attempt result;
  const auto made = [&]() -> Result<void> {
    recall_hashes(folder);
    TRY_ASSIGN(const Fingerprint fingerprint, frame_.work.fingerprint(scan.number, *scan.what));
    result.fingerprint = fingerprint.value;  // of what it began with: a file that changes later is other work
    is_idle = needs_no_part(scan, fingerprint, entry);
    if (is_idle) return {};
    TRY(store::make_folders(folder));
    if (!store::exists(folder + "/" + kPartHashes))
      TRY(store::write_text(folder + "/" + kPartHashes, frame_.work.save_hashes_of(scan.number)));
    page_beyond(memory, frame_.disk, folder);
    auto outcome = guarded(memory, frame_.cap, [&]() -> Result<Outcome> {
      act_on_test_fault(scan.task.name);
      const ChunkLoop loop(threads);
      const Context context{loop, frame_.stop.flag};
      TRY(frame_.work.make_part(scan.number, *scan.what, frame_.bricks, folder, part, context, watch));
      if (const CutParts parts = parts_of(scan); part == parts.waves.front().front()) {
        TRY_ASSIGN(result.forecast,
                   frame_.work.forecast_parts(scan.number, *scan.what, frame_.bricks, folder, context, watch));
      }
      return Outcome{};
    });
    if (!outcome) return std::move(outcome).error();
    return {};
  }();
  result.hashes = frame_.work.save_hashes_of(scan.number);
  if (!made) {
    const Error& error = made.error();
    const bool machine = class_of(error) == FailureClass::Transient;
    result.output_is_bad = machine && frame_.tree.is_unwritable();
    fail_entry(error, load_state(frame_.tree.scan(scan.task.name)).has_value(), entry);
    entry.failed_stage = part;
  }
  const double wall = seconds_since(began), cpu_spent = cpu_seconds() - cpu;
  if (made && !is_idle) add_seconds(folder, {part, frame_.host, utc_now(), wall, cpu_spent});
  if (!made)
    if (const auto log = begin_log(scan, entry, threads, progress)) {
      for (const std::string& line : part_lines(parts_of(scan))) (*log)->line(line);
      (*log)->line("part " + part + " failed: " + made.error().text());
    }
  if (is_idle) entry.fate = ScanFate::Unchanged;
  if (entry.why.empty()) entry.why = {"new or changed"};
  entry.ended = utc_now();
  entry.seconds += wall;
  entry.cpu_seconds += cpu_spent;
  entry.peak_memory = std::max(entry.peak_memory, peak_memory());
  result.entry = std::move(entry);
  return result;
}

/// A log that says when, with what and why.
Result<std::unique_ptr<ScanLog>> ScanMaker::begin_log(const SelectedScan& scan, const ScanEntry& entry, int threads,
                                                      Progress& progress) const {
  TRY_ASSIGN(auto log, ScanLog::begin(frame_.tree.log(scan.task.name), progress));
  log->line("scan " + scan.task.name + ", " + utc_now() + ", scanmill " + frame_.options.version + " on " +
            frame_.host + ", " + counted(static_cast<std::uint64_t>(threads), "thread") +
            (entry.attempts > 1 ? ", attempt " + std::to_string(entry.attempts) : ""));
  log->line("why: " + joined_lines(entry.why, "; "));
  log->line("what: " + document::to_canonical_json(*scan.what));
  return log;
}

/// Where the processor had more to do with moving memory than with the scan, the operator should know what helps.
std::string paging_note(const paged::Usage& used, double user_s, double system_s) {
  if (used.most_in_file == 0 || system_s < 5 || system_s < user_s) return {};
  const auto whole = [](double seconds) { return std::to_string(static_cast<long>(seconds + 0.5)); };
  return whole(system_s) + " of " + whole(user_s + system_s) +
         " CPU seconds went into moving memory to disk and back, up to " + bytes_text(used.most_in_file) +
         " of it: points that lie far apart, or too many bins for the memory; more memory (resources.memory, --memory) "
         "or larger bins would spare that";
}

/// From an empty folder to the switch.
Result<void> ScanMaker::attempt(const SelectedScan& scan, const Fingerprint& fingerprint, ScanEntry& entry, int threads,
                                std::uint64_t memory, Progress& progress) const {
  ++entry.attempts;
  const CpuTimes before = cpu_times();
  TRY_ASSIGN(const auto log, begin_log(scan, entry, threads, progress));
  for (const std::string& line : part_lines(parts_of(scan))) log->line(line);
  TRY_ASSIGN(const std::string folder, frame_.tree.begin_attempt(scan.task.name));
  auto made = fill(scan, fingerprint, folder, entry, threads, memory, *log);
  if (made && frame_.stop.flag.is_set()) made = fail(Code::Cancelled, "stopped before the result was put in place");
  if (made) made = still_ours();
  if (made) made = frame_.tree.commit(folder, scan.task.name);
  if (made) frame_.tree.remove_parts(scan.task.name);
  if (!made) {
    log->line("failed: " + made.error().text());
    (void)store::remove_tree(folder);
    return made;
  }
  const CpuTimes times = cpu_times();
  if (std::string note = paging_note(paged::usage(), times.user_s - before.user_s, times.system_s - before.system_s);
      !note.empty())
    entry.notes.push_back(std::move(note));
  for (const std::string& note : entry.notes) log->line("note: " + note);
  for (const std::string& gate : entry.failed_gates) log->line("gate failed: " + gate);
  for (const auto& [stage, seconds] : entry.stage_seconds)
    log->line("stage " + stage + " took " + seconds_text(seconds));
  const Node counts = entry.counts.document();
  for (const Node::Entry& count : counts.entries())
    log->line(count.key + " " + document::to_canonical_json(count.value));
  if (const paged::Usage used = paged::usage(); used.most_in_file > 0)
    log->line("memory beyond the cap: up to " + bytes_text(used.most_in_file) + " in a file, " +
              counted(used.evictions, "round") + " of letting go");
  log->line("done, record " + entry.record_identity + ", " + utc_now());
  entry.files = result_files(frame_.tree, scan.task.name);
  return {};
}

Result<void> ScanMaker::fill(const SelectedScan& scan, const Fingerprint& fingerprint, const std::string& folder,
                             ScanEntry& entry, int threads, std::uint64_t memory, Progress& progress) const {
  page_beyond(memory, frame_.disk, folder);
  auto outcome = guarded(memory, frame_.cap, [&]() -> Result<Outcome> {
    act_on_test_fault(scan.task.name);
    const ChunkLoop loop(threads);
    const Context context{loop, frame_.stop.flag};
    const std::string standing = frame_.tree.scan(scan.task.name);
    if (const auto state = load_state(standing); mesh_stands(state, fingerprint)) {
      std::string refusal;
      TRY_ASSIGN(auto again, frame_.work.rewrite(scan.number, *scan.what, standing, state->outputs, folder, context,
                                                 progress, refusal));
      if (again) return *std::move(again);
      std::erase(entry.why, kFromRecord);
      entry.notes.push_back("meshed again, the earlier record is of no use: " + refusal);
    }
    if (const CutParts parts = parts_of(scan); !parts.waves.empty()) {
      TRY(store::make_folders(parts.folder));
      frame_.work.use_parts(scan.number, frame_.bricks, parts.folder, by_kind(seconds_in(parts)));
    }
    return frame_.work.run(scan.number, *scan.what, folder, context, progress);
  });
  if (!outcome) return std::move(outcome).error();
  entry.notes.insert(entry.notes.end(), outcome->notes.begin(), outcome->notes.end());
  entry.counts = outcome->counts;
  entry.record_identity = outcome->record_identity;
  entry.stage_seconds = outcome->stage_seconds;
  entry.stage_cpu_seconds = outcome->stage_cpu_seconds;
  entry.failed_gates = outcome->failed_gates;
  TRY_ASSIGN(const Fingerprint after, frame_.work.fingerprint(scan.number, *scan.what));
  if (after.value != fingerprint.value)
    return fail(Code::BadInput, "an input changed while the scan was made; run again when its writer has finished",
                scan.task.name);
  ScanState state{fingerprint, *scan.what, outcome->counts, outcome->record_identity, outcome->failed_gates, {}};
  return save_state(state, folder);
}

/// A run that was held up while another took the output over must not put anything in place.
Result<void> ScanMaker::still_ours() const {
  if (frame_.may_commit ? frame_.may_commit() : latest_epoch(frame_.tree.journal()) <= frame_.epoch) return {};
  return fail(Code::Cancelled, "another run has taken over this output; nothing was put in place");
}

void ScanMaker::fail_entry(const Error& error, bool has_result, ScanEntry& entry) const {
  entry.error = error;
  entry.failure = class_of(error);
  entry.fate = error.code == Code::Cancelled ? ScanFate::Interrupted : has_result ? ScanFate::Stale : ScanFate::Failed;
  if (!has_result) return;
  entry.files = result_files(frame_.tree, entry.name);
  if (const auto state = load_state(frame_.tree.scan(entry.name))) entry.failed_gates = state->failed_gates;
}

}  // namespace scanmill::runner
