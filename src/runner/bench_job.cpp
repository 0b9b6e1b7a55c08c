// SPDX-License-Identifier: Apache-2.0
#include "runner/bench_job.hpp"

#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>

#include "base/text.hpp"
#include "runner/machine.hpp"
#include "store/files.hpp"
#include "timing/yardstick.hpp"

namespace scanmill::runner {

using document::Node;
using timing::Band;

namespace {

constexpr int kConfirmations = 4;
constexpr std::uint64_t kLongestDocument = 1ull << 30;

/// What one run said about itself.
struct Sample {
  double cpu_s = 0, wall_s = 0;
  std::uint64_t peak_bytes = 0;
  std::vector<std::pair<std::string, double>> stages;
  std::uint64_t scans = 0, points = 0, bins = 0;
};

/// All samples of one number of threads.
struct Samples {
  std::vector<double> cpu_s, wall_s, yardsticks;
  std::uint64_t peak_bytes = 0;
  std::vector<std::pair<std::string, std::vector<double>>> stages;

  void add(const Sample& sample, double yardstick) {
    yardsticks.push_back(sample.cpu_s / yardstick);
    cpu_s.push_back(sample.cpu_s);
    wall_s.push_back(sample.wall_s);
    peak_bytes = std::max(peak_bytes, sample.peak_bytes);
    for (const auto& [name, seconds] : sample.stages) {
      auto at = std::find_if(stages.begin(), stages.end(), [&](const auto& row) { return row.first == name; });
      if (at == stages.end()) at = stages.insert(stages.end(), {name, {}});
      at->second.push_back(seconds);
    }
  }
};

double number_in(const Node* map, const char* key) {
  const Node* value = map ? map->find(key) : nullptr;
  return value && value->is_number() ? value->as_number() : 0;
}

Result<Node> read_document(const std::string& path) {
  TRY_ASSIGN(const auto source, store::open_file(path, path));
  TRY_ASSIGN(const std::string text, read_all(*source, kLongestDocument));
  return document::parse_json(text, path);
}

Result<Sample> sample_of(const std::string& run_file) {
  TRY_ASSIGN(const Node run, read_document(run_file));
  Sample sample;
  sample.wall_s = number_in(&run, "seconds");
  const Node* scans = run.find("scans");
  if (!scans || !scans->is_sequence()) return fail(Code::Internal, "found no scans; please report this", run_file);
  for (const Node& scan : scans->items()) {
    ++sample.scans;
    sample.cpu_s += number_in(&scan, "cpu_seconds");
    sample.peak_bytes = std::max(sample.peak_bytes, static_cast<std::uint64_t>(number_in(&scan, "peak_memory_bytes")));
    sample.points += static_cast<std::uint64_t>(number_in(scan.find("counts"), "points_read"));
    sample.bins += static_cast<std::uint64_t>(number_in(scan.find("counts"), "bins"));
    const Node* stages = scan.find("stage_seconds");
    if (!stages || !stages->is_map()) continue;
    for (const Node::Entry& stage : stages->entries()) {
      auto at = std::find_if(sample.stages.begin(), sample.stages.end(),
                             [&](const auto& row) { return row.first == stage.key; });
      if (at == sample.stages.end()) at = sample.stages.insert(sample.stages.end(), {stage.key, 0});
      at->second += stage.value.is_number() ? stage.value.as_number() : 0;
    }
  }
  return sample;
}

/// A folder of its own, removed with everything in it.
class Scratch {
 public:
  static Result<std::unique_ptr<Scratch>> make() {
    std::error_code error;
    std::string path = (std::filesystem::temp_directory_path(error) / "scanmill-bench-XXXXXX").string();
    if (error || !mkdtemp(path.data()))
      return fail(Code::IoFailed, "takes no folder; set TMPDIR to one that does", error ? "TMPDIR" : path);
    return std::make_unique<Scratch>(path);
  }
  explicit Scratch(std::string path) : path_(std::move(path)) {}
  ~Scratch() { (void)store::remove_tree(path_); }
  Scratch(const Scratch&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

std::string band2(const Band& band) {
  return timing::fixed(band.median, 2) + " [" + timing::fixed(band.least, 2) + ", " + timing::fixed(band.greatest, 2) +
         "]";
}

std::string drained(std::FILE* file) {
  std::string text(static_cast<std::size_t>(std::max(0L, std::ftell(file))), '\0');
  std::rewind(file);
  text.resize(std::fread(text.data(), 1, text.size(), file));
  return text;
}

class Bench {
 public:
  Bench(const BenchJobOptions& options, Console& console, Stop& stop)
      : options_(options), console_(console), stop_(stop) {}

  int run() {
    const auto done = measure();
    console_.end();
    if (!done) {
      if (stop_.signal.load() != 0) return 128 + stop_.signal.load();
      console_.complain(done.error());
      return code_ != kExitGood ? code_ : exit_code_of(done.error());
    }
    return show();
  }

 private:
  Result<void> measure() {
    if (!options_.against.empty()) {
      TRY_ASSIGN(const Node root, read_document(options_.against));
      TRY_ASSIGN(then_, job_bench_from(root, options_.against));
    }
    unsetenv("GITHUB_STEP_SUMMARY");  // the runs below are none of the build's steps
    TRY_ASSIGN(scratch_, Scratch::make());
    const int greatest = options_.threads ? static_cast<int>(options_.threads) : usable_cores();
    bench_.version = options_.version;
    bench_.processor = processor_name();
    bench_.job = options_.job;
    bench_.cores = usable_cores();
    bench_.repeats = options_.repeats;
    counts_ = thread_counts(greatest);
    samples_.resize(counts_.size());
    console_.begin("bench " + options_.job);
    TRY_ASSIGN(const Sample warm, run_once(greatest));
    bench_.scans = warm.scans;
    bench_.points = warm.points;
    bench_.bins = warm.bins;
    if (then_) TRY(check_same_work());
    for (int round = 0; round <= kConfirmations; ++round) {
      TRY(measure_round());
      sum_up();
      if (!then_ || slowdowns().empty()) break;
    }
    return {};
  }

  /// Thread counts and yardstick in turn, so that a busy minute reaches all of them.
  Result<void> measure_round() {
    for (std::int64_t repeat = 0; repeat < options_.repeats; ++repeat)
      for (std::size_t k = 0; k < counts_.size(); ++k) {
        const std::uint64_t done = static_cast<std::uint64_t>(repeat) * counts_.size() + k;
        console_.stage(counted(static_cast<std::uint64_t>(counts_[k]), "thread"), done,
                       static_cast<std::uint64_t>(options_.repeats) * counts_.size());
        const double before = timing::yardstick_cpu_seconds();
        TRY_ASSIGN(const Sample sample, run_once(counts_[k]));
        const double after = timing::yardstick_cpu_seconds();
        yardstick_.insert(yardstick_.end(), {before, after});
        samples_[k].add(sample, (before + after) / 2);
      }
    return {};
  }

  Result<Sample> run_once(int threads) {
    const std::string out = scratch_->path() + "/out";
    RunOptions run;
    run.job = options_.job;
    run.out = out;
    run.sets = {"notify=[]", "settle_s=0"};
    run.threads = threads;
    run.memory = options_.memory;
    run.version = options_.version;
    run.libraries = options_.libraries;
    std::ofstream("/proc/self/clear_refs") << "5";  // the peak begins again; refused: it is that of the whole process
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> text(std::tmpfile(), std::fclose);
    if (!text) return fail(Code::IoFailed, "no temporary file can be made", "TMPDIR");
    {
      const std::unique_ptr<Work> work = options_.work();
      Console quiet({ProgressStyle::None, false, true}, text.get(), text.get());
      code_ = run_job(run, *work, quiet, stop_);
    }
    if (code_ != kExitGood && code_ != kExitGate) {
      const std::string said = drained(text.get());
      return fail(Code::BadInput, "the job ends with exit code " + std::to_string(code_) +
                                      "; a bench needs one whose scans are all made:\n" +
                                      said.substr(0, said.find_last_not_of('\n') + 1));
    }
    code_ = kExitGood;
    auto sample = sample_of(out + "/run.json");
    TRY(store::remove_tree(out));
    return sample;
  }

  Result<void> check_same_work() const {
    const auto told = [](const JobBench& bench) {
      return counted(bench.scans, "scan") + " of " + counted(bench.points, "point") + " in " +
             counted(bench.bins, "bin");
    };
    if (told(bench_) == told(*then_)) return {};
    return fail(Code::BadUsage,
                "was measured on " + told(*then_) + ", this job has " + told(bench_) +
                    "; give the same job and archive, or measure both again",
                options_.against);
  }

  void sum_up() {
    bench_.yardstick_s = timing::band_of(yardstick_);
    bench_.runs.clear();
    for (std::size_t k = 0; k < counts_.size(); ++k) {
      const Samples& s = samples_[k];
      JobTiming timing;
      timing.threads = counts_[k];
      timing.cpu_s = timing::band_of(s.cpu_s);
      timing.wall_s = timing::band_of(s.wall_s);
      timing.yardsticks = timing::band_of(s.yardsticks);
      timing.peak_bytes = s.peak_bytes;
      for (const auto& [stage, seconds] : s.stages) timing.stages.emplace_back(stage, timing::band_of(seconds));
      bench_.runs.push_back(std::move(timing));
    }
  }

  const JobTiming* earlier(int threads) const {
    if (then_)
      for (const JobTiming& timing : then_->runs)
        if (timing.threads == threads) return &timing;
    return nullptr;
  }

  std::vector<std::string> slowdowns() const {
    std::vector<std::string> found;
    for (const JobTiming& now : bench_.runs) {
      const JobTiming* then = earlier(now.threads);
      if (!then || !is_slower(now, *then)) continue;
      found.push_back(
          "bench of " + options_.job + " with " + counted(static_cast<std::uint64_t>(now.threads), "thread") +
          ": found " + timing::fixed(now.yardsticks.median, 2) + " yardsticks, confirmed by " +
          counted(static_cast<std::uint64_t>(kConfirmations), "more round") + "; allowed " + number_text(kJobSlower) +
          " times the " + timing::fixed(then->yardsticks.median, 2) + " of version " + then_->version);
    }
    return found;
  }

  std::string table() const {
    std::string text = options_.job + ": " + counted(bench_.scans, "scan") + ", " + counted(bench_.points, "point") +
                       ", " + counted(bench_.bins, "bin") + "; " +
                       counted(static_cast<std::uint64_t>(bench_.cores), "core") + ", " + bench_.processor +
                       "; median [least, greatest] of " +
                       counted(static_cast<std::uint64_t>(samples_[0].cpu_s.size()), "repeat") + "\nyardstick " +
                       timing::band_text(bench_.yardstick_s) + " CPU s\n\n";
    std::vector<std::vector<std::string>> rows{{"threads", "scans/h", "CPU s", "yardsticks", "wall s", "peak"}};
    if (then_) rows.front().push_back("yardsticks before");
    for (const JobTiming& run : bench_.runs) {
      rows.push_back({std::to_string(run.threads), timing::fixed(run.scans_per_hour(bench_.scans), 0),
                      timing::band_text(run.cpu_s), band2(run.yardsticks), timing::band_text(run.wall_s),
                      bytes_text(run.peak_bytes)});
      const JobTiming* then = earlier(run.threads);
      if (then_) rows.back().push_back(then ? band2(then->yardsticks) : "-");
    }
    text += timing::aligned(rows) + "\n\n";
    rows.assign(1, {"stage, wall s"});
    for (const JobTiming& run : bench_.runs)
      rows.front().push_back(counted(static_cast<std::uint64_t>(run.threads), "thread"));
    for (std::size_t k = 0; k < bench_.runs.front().stages.size(); ++k) {
      rows.push_back({bench_.runs.front().stages[k].first});
      for (const JobTiming& run : bench_.runs)
        rows.back().push_back(k < run.stages.size() ? timing::band_text(run.stages[k].second) : "-");
    }
    return text + timing::aligned(rows);
  }

  int show() {
    const Node values = to_document(bench_);
    if (!options_.out.empty())
      if (const auto written = store::write_text(options_.out, document::to_json(values, 2) + "\n"); !written) {
        console_.complain(written.error());
        return kExitInternal;
      }
    Node event = Console::event("report");
    event.set("command", "bench");
    event.set("values", values);
    console_.result(table(), event);
    if (then_ && (then_->processor != bench_.processor || then_->cores != bench_.cores))
      console_.note("", "the earlier bench ran on another machine: " + then_->processor + ", " +
                            counted(static_cast<std::uint64_t>(then_->cores), "core"));
    const std::vector<std::string> slower = slowdowns();
    for (const std::string& sentence : slower) {
      Node gate = Console::event("gate");
      gate.set("scan", "");
      gate.set("text", sentence);
      console_.problem("rejected: " + sentence, gate);
    }
    return slower.empty() ? kExitGood : kExitGate;
  }

  const BenchJobOptions& options_;
  Console& console_;
  Stop& stop_;
  std::unique_ptr<Scratch> scratch_;
  std::optional<JobBench> then_;
  JobBench bench_;
  std::vector<int> counts_;
  std::vector<Samples> samples_;
  std::vector<double> yardstick_;
  int code_ = kExitGood;
};

}  // namespace

double JobTiming::scans_per_hour(std::uint64_t scans) const {
  return static_cast<double>(scans) * 3600 / std::max(wall_s.median, 1e-6);
}

bool is_slower(const JobTiming& now, const JobTiming& then) {
  // What others do on the machine moves the median of all repeats, but leaves the least of them; a slower build does
  // not.
  return now.yardsticks.median > kJobSlower * then.yardsticks.median &&
         now.yardsticks.least > kLeastSlower * then.yardsticks.least;
}

std::vector<int> thread_counts(int greatest) {
  std::vector<int> counts;
  for (int threads = 1; threads < greatest; threads += threads < 4 ? 1 : threads) counts.push_back(threads);
  counts.push_back(std::max(1, greatest));
  return counts;
}

int bench_job(const BenchJobOptions& options, Console& console, Stop& stop) {
  return Bench(options, console, stop).run();
}

}  // namespace scanmill::runner
