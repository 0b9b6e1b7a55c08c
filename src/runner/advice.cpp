// SPDX-License-Identifier: Apache-2.0
#include "runner/advice.hpp"

#include "base/text.hpp"

namespace scanmill::runner {
namespace {

std::string for_input(const Error& error) {
  switch (error.code) {
    case Code::Unsupported:
      return "Convert the file to a format that this version reads, or leave the scan out with scans:.";
    case Code::BadParameter:
    case Code::BadUsage:
      return "Correct the key that the message names, for all scans or for this one under overrides:.";
    default:
      return "Do what the message says about the input: repair it, replace it or describe it otherwise. The scan is "
             "tried again as soon as a file or a key of it changes.";
  }
}

std::string for_failure(const ScanEntry& entry) {
  switch (failure_of(entry)) {
    case FailureClass::BadInput:
      return for_input(entry.error);
    case FailureClass::Resource:
      if (entry.error.where == "disk" || entry.error.message.starts_with("disk: "))
        return "Raise resources.disk (--disk), or resources.memory (--memory) so that less is paged, or choose a "
               "larger "
               "lattice.bin_mm for this scan under overrides:.";
      return "Raise resources.memory (--memory), or choose a larger lattice.bin_mm for this scan under overrides:" +
             (entry.peak_memory > 0 ? "; it held " + bytes_text(entry.peak_memory) + " at its peak." : ".");
    case FailureClass::Transient:
      if (entry.error.code == Code::NoSpace)
        return "Free space on the disk that the message names and run again: finished scans are skipped.";
      return "Look at the disk or network share that the message names; the next run tries again by itself.";
    case FailureClass::Cancelled:
      return "Run the job again: it goes on where it stopped.";
    case FailureClass::Internal:
      if (entry.error.message.find("resources.scan_time_limit") != std::string::npos)
        return "Raise resources.scan_time_limit, or choose a larger lattice.bin_mm for this scan under overrides:.";
      return "A fault of the program, not of the scan: report it with the scan's log. The other scans are not touched "
             "by it.";
    case FailureClass::None:
      break;
  }
  return {};
}

}  // namespace

FailureClass failure_of(const ScanEntry& entry) {
  if (entry.failure != FailureClass::None) return entry.failure;
  return entry.error.message.empty() ? FailureClass::None : class_of(entry.error);
}

std::string advice_for(const ScanEntry& entry) {
  std::string advice = for_failure(entry);
  if (entry.fate == ScanFate::Quarantined)
    return std::string("Skipped until a file, a key or the program changes, ") +
           (failure_of(entry) == FailureClass::Resource ? "there is more for it, " : "") +
           "or until --only names it. " + advice;
  if (entry.fate == ScanFate::Stale) return advice + " The last good result is kept meanwhile.";
  if (!advice.empty()) return advice;
  if (!entry.failed_gates.empty())
    return "Look at the scan's report.html: scan again, choose a smaller lattice.bin_mm, or raise the limit where the "
           "part may be so. The files are there, marked rejected.";
  if (entry.fate == ScanFate::Pending) return "Not reached: run the job again, it goes on where it stopped.";
  return {};
}

std::string verdict_of(const RunReport& report) {
  std::string words;
  const auto add = [&](std::uint64_t count, const char* thing, const char* what) {
    if (count > 0) words += (words.empty() ? "" : ", ") + counted(count, thing) + " " + what;
  };
  add(report.count(ScanFate::Failed) + report.count(ScanFate::Stale), "scan", "failed");
  add(report.rejected(), "scan", "rejected by a gate");
  add(report.count(ScanFate::Interrupted) + report.count(ScanFate::Pending), "scan", "not finished");
  const int code = report.exit_code;
  if (code >= 128) return "interrupted" + (words.empty() ? "" : ": " + words);
  if (code == 1) return "stopped by a fault of machine or program" + (words.empty() ? "" : ": " + words);
  if (words.empty() && (code == 0 || code == 3)) add(report.count(ScanFate::Quarantined), "scan", "quarantined");
  return words.empty() ? code == 0 ? "all good" : "exit " + std::to_string(code) : words;
}

}  // namespace scanmill::runner
