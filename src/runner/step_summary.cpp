// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>

#include "base/text.hpp"
#include "base/utf8.hpp"
#include "runner/advice.hpp"
#include "runner/machine.hpp"
#include "runner/run_texts.hpp"

namespace scanmill::runner {
namespace {

constexpr std::size_t kRows = 50;          // GitHub takes 1 MiB per step
constexpr std::size_t kLongestCell = 600;  // bytes

/// Text inside a table: nothing of it is markup.
std::string cell(std::string_view text) {
  std::string shown = printable(text, true);
  if (shown.size() > kLongestCell) {
    std::size_t end = kLongestCell;
    while (end > 0 && (static_cast<unsigned char>(shown[end]) & 0xc0) == 0x80) --end;
    shown.resize(end);
    shown += " ...";
  }
  std::string out;
  for (const char c : shown) {
    if (c == '\n')
      out += "<br>";
    else if (std::string_view("&<>|*_`[]\\~\"'@#:!").find(c) != std::string_view::npos)
      out += "&#" + std::to_string(static_cast<int>(c)) + ";";
    else
      out += c;
  }
  return out;
}

std::string code(std::string_view text) { return text.empty() ? "" : "<code>" + cell(text) + "</code>"; }

void add_rest(std::size_t all, std::string& out) {
  if (all > kRows) out += "\n" + grouped(all - kRows) + " more stand in report.html.\n";
}

void add_failed(const RunReport& report, std::string& out) {
  std::vector<const ScanEntry*> failed;
  for (const ScanEntry& entry : report.scans)
    if (entry.fate == ScanFate::Failed || entry.fate == ScanFate::Stale || entry.fate == ScanFate::Interrupted)
      failed.push_back(&entry);
  if (failed.empty()) return;
  out += "\n### Failed\n\n| scan | class | found | what to do | again |\n|---|---|---|---|---|\n";
  for (std::size_t k = 0; k < std::min(failed.size(), kRows); ++k) {
    const ScanEntry& entry = *failed[k];
    out += "| " + cell(entry.name) + (entry.fate == ScanFate::Stale ? " (last good result kept)" : "") + " | " +
           cell(name_of(failure_of(entry))) + (entry.failed_stage.empty() ? "" : ", in " + cell(entry.failed_stage)) +
           " | " + cell(entry.error.text()) + " | " + cell(advice_for(entry)) + " | " + code(entry.repeat) + " |\n";
  }
  add_rest(failed.size(), out);
}

void add_rejected(const RunReport& report, std::string& out) {
  const std::uint64_t all = report.rejected();
  if (all == 0) return;
  out += "\n### Rejected by a gate\n\n| scan | gate |\n|---|---|\n";
  std::size_t rows = 0;
  for (const ScanEntry& entry : report.scans) {
    if (entry.failed_gates.empty() || ++rows > kRows) continue;
    std::string gates;
    for (const std::string& gate : entry.failed_gates) gates += (gates.empty() ? "" : "\n") + gate;
    out += "| " + cell(entry.name) + " | " + cell(gates) + " |\n";
  }
  add_rest(static_cast<std::size_t>(all), out);
}

void add_worse(const std::vector<WorseScan>& worse, std::string& out) {
  if (worse.empty()) return;
  out += "\n### Worse than the run before\n\n| scan | figure | before | now |\n|---|---|---:|---:|\n";
  for (std::size_t k = 0; k < std::min(worse.size(), kRows); ++k) {
    for (const Figure& f : worse[k].figures)
      out += "| " + cell(worse[k].name) + " | " + cell(f.name + (f.unit.empty() ? "" : ", " + f.unit)) + " | " +
             number_text(f.then) + " | " + number_text(f.now) + " |\n";
    for (const std::string& gate : worse[k].new_gates)
      out += "| " + cell(worse[k].name) + " | " + cell(gate) + " | kept | failed |\n";
  }
  add_rest(worse.size(), out);
}

}  // namespace

std::string step_summary(const RunReport& report, const std::vector<WorseScan>& worse) {
  const std::string job = std::filesystem::path(report.job_path).filename().string();
  std::string out = "## scanmill " + cell(job) + ": " + cell(verdict_of(report)) + "\n\n";
  out +=
      "| unchanged | done | failed | quarantined | vanished | gates | time | exit "
      "|\n|---:|---:|---:|---:|---:|---:|---:|"
      "---:|\n";
  const auto number = [&](ScanFate fate) { return " " + grouped(report.count(fate)) + " |"; };
  out += "|" + number(ScanFate::Unchanged) + number(ScanFate::Done) + " " +
         grouped(report.count(ScanFate::Failed) + report.count(ScanFate::Stale)) + " |" +
         number(ScanFate::Quarantined) + number(ScanFate::Vanished) + " " + grouped(report.rejected()) + " | " +
         clock_text(report.seconds) + " | " + std::to_string(report.exit_code) + " |\n";
  add_failed(report, out);
  add_rejected(report, out);
  add_worse(worse, out);
  return out + "\n";
}

}  // namespace scanmill::runner
