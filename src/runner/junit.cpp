// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>

#include "base/utf8.hpp"
#include "runner/advice.hpp"
#include "runner/run_texts.hpp"

namespace scanmill::runner {
namespace {

/// XML 1.0 takes few control characters, not even as references; printable() shows them instead.
std::string xml(std::string_view text, bool in_attribute) {
  std::string out;
  for (const char c : printable(text, true)) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\n':
        out += in_attribute ? "&#10;" : "\n";  // a parser makes a blank of a bare one
        break;
      case '\t':
        out += in_attribute ? "&#9;" : "\t";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string attribute(const char* name, std::string_view value) {
  return std::string(" ") + name + "=\"" + xml(value, true) + "\"";
}

std::string seconds(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3f", value);
  return text;
}

struct Tally {
  std::uint64_t tests = 0, failures = 0, errors = 0, skipped = 0;
};

std::string line(const char* name, const std::string& value) {
  return value.empty() ? std::string() : std::string(name) + ": " + value + "\n";
}

std::string story_of(const ScanEntry& entry) {
  std::string gates;
  for (const std::string& gate : entry.failed_gates) gates += line("gate", gate);
  return line("class", entry.error.message.empty() ? "gate" : name_of(failure_of(entry))) +
         line("stage", entry.failed_stage) + line("found", entry.error.text()) + gates +
         line("what to do", advice_for(entry)) + line("again", entry.repeat) +
         line("log", entry.attempts > 0 ? "logs/" + entry.name + ".log" : "");
}

std::string result_of(const ScanEntry& entry, Tally& tally) {
  switch (entry.fate) {
    case ScanFate::Pending:
      ++tally.skipped;
      return "      <skipped message=\"not reached\"/>\n";
    case ScanFate::Quarantined:
      ++tally.skipped;
      return "      <skipped" + attribute("message", "quarantined: " + entry.error.text() + " | " + advice_for(entry)) +
             "/>\n";
    case ScanFate::Failed:
    case ScanFate::Stale:
    case ScanFate::Interrupted: {
      const FailureClass failure = failure_of(entry);
      const bool is_failure = failure == FailureClass::BadInput;
      ++(is_failure ? tally.failures : tally.errors);
      const std::string tag = is_failure ? "failure" : "error";
      return "      <" + tag + attribute("type", name_of(failure)) + attribute("message", entry.error.text()) + ">" +
             xml(story_of(entry), false) + "</" + tag + ">\n";
    }
    default:
      break;
  }
  if (entry.failed_gates.empty()) return {};
  ++tally.failures;
  return "      <failure" + attribute("type", "gate") + attribute("message", entry.failed_gates.front()) + ">" +
         xml(story_of(entry), false) + "</failure>\n";
}

}  // namespace

std::string junit_xml(const RunReport& report) {
  const std::string job = std::filesystem::path(report.job_path).filename().string();
  Tally tally;
  std::string cases;
  for (const ScanEntry& entry : report.scans) {
    if (entry.fate == ScanFate::Vanished) continue;
    ++tally.tests;
    std::string inside = result_of(entry, tally);
    if (!entry.notes.empty()) {
      inside += "      <system-out>";
      for (const std::string& note : entry.notes) inside += xml(note, false) + "\n";
      inside += "</system-out>\n";
    }
    cases += "    <testcase" + attribute("classname", job) + attribute("name", entry.name) +
             attribute("time", seconds(entry.seconds));
    cases += inside.empty() ? "/>\n" : ">\n" + inside + "    </testcase>\n";
  }
  const std::string sums = attribute("tests", std::to_string(tally.tests)) +
                           attribute("failures", std::to_string(tally.failures)) +
                           attribute("errors", std::to_string(tally.errors));
  std::string out = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites" + attribute("name", "scanmill") + sums +
                    attribute("time", seconds(report.seconds)) + ">\n  <testsuite" + attribute("name", job) + sums +
                    attribute("skipped", std::to_string(tally.skipped)) + attribute("time", seconds(report.seconds)) +
                    // Schemas of JUnit files want a time without zone.
                    attribute("timestamp", report.started.substr(0, report.started.find('Z'))) +
                    attribute("hostname", report.host) + ">\n    <properties>\n";
  const std::pair<const char*, std::string> properties[] = {{"version", report.version},
                                                            {"archive", report.archive},
                                                            {"out", report.out},
                                                            {"exit", std::to_string(report.exit_code)},
                                                            {"verdict", verdict_of(report)}};
  for (const auto& [name, value] : properties)
    out += "      <property" + attribute("name", name) + attribute("value", value) + "/>\n";
  return out + "    </properties>\n" + cases + "  </testsuite>\n</testsuites>\n";
}

}  // namespace scanmill::runner
