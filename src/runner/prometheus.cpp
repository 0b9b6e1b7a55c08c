// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <ctime>
#include <filesystem>
#include <map>

#include "base/text.hpp"
#include "base/utf8.hpp"
#include "runner/advice.hpp"
#include "runner/run_texts.hpp"

namespace scanmill::runner {
namespace {

constexpr const char* kLastSuccess = "scanmill_last_success_timestamp_seconds";

/// Label values take any UTF-8; backslash, quote and line feed are escaped.
std::string label(const char* name, std::string_view value) {
  std::string out = std::string(name) + "=\"";
  for (const char c : printable(value, true)) {
    if (c == '\n')
      out += "\\n";
    else if (c == '"' || c == '\\')
      out += std::string("\\") + c;
    else
      out += c;
  }
  return out + "\"";
}

/// Metrics one after the other, each with its help and type in front.
class Metrics {
 public:
  explicit Metrics(const RunReport& report) {
    std::error_code error;
    const auto out = std::filesystem::absolute(report.out, error);
    common_ = label("job_file", std::filesystem::path(report.job_path).filename().string()) + "," +
              label("out", error ? report.out : out.lexically_normal().string());
  }
  void begin(const char* name, const char* help) {
    name_ = name;
    text += std::string("# HELP ") + name + " " + help + "\n# TYPE " + name + " gauge\n";
  }
  void sample(const std::string& value, const std::string& more = {}) {
    text += std::string(name_) + "{" + common_ + (more.empty() ? "" : "," + more) + "} " + value + "\n";
  }
  void sample(double value, const std::string& more = {}) { sample(number_text(value), more); }
  void one(const char* name, const char* help, double value) {
    begin(name, help);
    sample(value);
  }
  std::string text;

 private:
  std::string common_;
  const char* name_ = "";
};

/// The value that an earlier file gives a metric without further labels.
std::string value_in(const std::string& file, const std::string& metric) {
  for (const std::string& line : lines_of(file))
    if (line.starts_with(metric + "{") || line.starts_with(metric + " ")) {
      const std::string value = line.substr(line.rfind(' ') + 1);
      if (parse_number(value)) return value;
    }
  return {};
}

double count(const ScanEntry& entry, const char* key) {
  const auto value = entry.counts.find(key);
  return value ? value->as_number() : 0;
}

void add_outcome(const RunReport& report, Metrics& m) {
  m.begin("scanmill_run_scans", "Scans of the latest run by state.");
  for (int k = 0; k <= static_cast<int>(ScanFate::Vanished); ++k) {
    const auto fate = static_cast<ScanFate>(k);
    m.sample(static_cast<double>(report.count(fate)), label("state", name_of(fate)));
  }
  m.begin("scanmill_run_failures", "Scans of the latest run without a new result, by class of failure.");
  for (int k = static_cast<int>(FailureClass::BadInput); k <= static_cast<int>(FailureClass::Internal); ++k) {
    const auto failure = static_cast<FailureClass>(k);
    const auto fits = [&](const ScanEntry& e) {
      return failure_of(e) == failure && (e.fate == ScanFate::Failed || e.fate == ScanFate::Stale);
    };
    m.sample(static_cast<double>(std::count_if(report.scans.begin(), report.scans.end(), fits)),
             label("class", name_of(failure)));
  }
  m.one("scanmill_run_scans_rejected", "Scans whose result fails a gate.", static_cast<double>(report.rejected()));
  m.one("scanmill_run_exit_code", "Exit code of the latest run.", report.exit_code);
}

void add_cost(const RunReport& report, Metrics& m) {
  double cpu = 0, points = 0, triangles = 0, made = 0, peak = 0;
  std::map<std::string, double> stages;
  for (const ScanEntry& entry : report.scans) {
    cpu += entry.cpu_seconds;
    peak = std::max(peak, static_cast<double>(entry.peak_memory));
    for (const auto& [stage, seconds] : entry.stage_seconds) stages[stage] += seconds;
    if (entry.fate != ScanFate::Done) continue;
    made += 1;
    points += count(entry, "points_read");
    triangles += count(entry, "triangles");
  }
  m.one("scanmill_run_duration_seconds", "Wall time of the latest run.", report.seconds);
  m.one("scanmill_run_cpu_seconds", "User and system time spent on scans.", cpu);
  m.begin("scanmill_run_stage_seconds", "Wall time of each stage, summed over the scans made.");
  for (const auto& [stage, seconds] : stages) m.sample(seconds, label("stage", stage));
  m.one("scanmill_run_points", "Points read for the scans made.", points);
  m.one("scanmill_run_triangles", "Triangles of the scans made.", triangles);
  const double hours = std::max(report.seconds - report.waited, 1e-3) / 3600;
  m.one("scanmill_run_scans_per_hour", "Scans made per hour of wall time, without waits for files to settle.",
        made / hours);
  m.one("scanmill_run_points_per_second", "Points read per second of wall time, without such waits.",
        points / hours / 3600);
  m.one("scanmill_run_peak_memory_bytes", "Greatest resident memory of a process that made a scan.", peak);
  m.one("scanmill_run_threads", "Threads given to the run.", report.threads);
}

void add_times(const RunReport& report, const std::string& before, Metrics& m) {
  if (const auto started = unix_seconds(report.started))
    m.one("scanmill_run_start_timestamp_seconds", "When the latest run began.", static_cast<double>(*started));
  const auto ended = unix_seconds(report.ended);
  if (ended) m.one("scanmill_run_end_timestamp_seconds", "When the latest run ended.", static_cast<double>(*ended));
  const std::string success = report.exit_code == 0 && ended ? std::to_string(*ended) : value_in(before, kLastSuccess);
  if (success.empty()) return;  // never: absent, so that an alert on absence works
  m.begin(kLastSuccess, "When a run last ended with exit code 0.");
  m.sample(success);
}

}  // namespace

std::optional<std::int64_t> unix_seconds(const std::string& utc) {
  std::tm parts{};
  const char* end = strptime(utc.c_str(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  if (!end || *end != '\0') return std::nullopt;
  return static_cast<std::int64_t>(timegm(&parts));
}

std::string prometheus_text(const RunReport& report, const std::string& before) {
  Metrics metrics(report);
  add_outcome(report, metrics);
  add_times(report, before, metrics);
  add_cost(report, metrics);
  metrics.begin("scanmill_build_info", "Version of the program; always 1.");
  metrics.sample(1, label("version", report.version));
  return metrics.text;
}

}  // namespace scanmill::runner
