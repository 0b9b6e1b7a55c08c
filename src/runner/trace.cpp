// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>

#include "base/utf8.hpp"
#include "runner/advice.hpp"
#include "runner/run_texts.hpp"

namespace scanmill::runner {
namespace {

std::string cell(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\\')
      escaped += "\\\\";
    else if (c == '\t')
      escaped += "\\t";
    else if (c == '\n')
      escaped += "\\n";
    else
      escaped += c;
  }
  return printable(escaped);
}

std::string seconds(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6f", value);
  return text;
}

std::string count(const ScanEntry& entry, const char* key) {
  const auto value = entry.counts.find(key);
  return value ? document::to_json(*value) : "";
}

/// Every stage of any scan, each after the one it follows in the first scan that has it.
std::vector<std::string> stages_of(const RunReport& report) {
  std::vector<std::string> stages;
  for (const ScanEntry& entry : report.scans) {
    auto at = stages.begin();
    for (const auto& [stage, _] : entry.stage_seconds) {
      const auto found = std::find(stages.begin(), stages.end(), stage);
      at = (found != stages.end() ? found : stages.insert(at, stage)) + 1;
    }
  }
  return stages;
}

}  // namespace

std::string trace_tsv(const RunReport& report) {
  const std::vector<std::string> stages = stages_of(report);
  std::string out =
      "name\tstate\tclass\tattempts\tstarted\tended\tseconds\tcpu_seconds\tpeak_memory_bytes\tpoints\ttriangles";
  for (const std::string& stage : stages) out += "\t" + cell(stage) + "_seconds";
  out += "\n";
  for (const ScanEntry& entry : report.scans) {
    const FailureClass failure = failure_of(entry);
    out += cell(entry.name) + "\t" + name_of(entry.fate) + "\t" +
           (failure == FailureClass::None ? "" : name_of(failure)) + "\t" + std::to_string(entry.attempts) + "\t" +
           cell(entry.started) + "\t" + cell(entry.ended) + "\t" + seconds(entry.seconds) + "\t" +
           seconds(entry.cpu_seconds) + "\t" + std::to_string(entry.peak_memory) + "\t" + count(entry, "points_read") +
           "\t" + count(entry, "triangles");
    for (const std::string& stage : stages) {
      double sum = 0;
      bool ran = false;
      for (const auto& [name, took] : entry.stage_seconds)
        if (name == stage) {
          sum += took;
          ran = true;
        }
      out += "\t" + (ran ? seconds(sum) : std::string());
    }
    out += "\n";
  }
  return out;
}

}  // namespace scanmill::runner
