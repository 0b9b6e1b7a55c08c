// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <map>

#include "base/text.hpp"
#include "report/html.hpp"
#include "report/night_sections.hpp"
#include "report/numbers.hpp"

namespace scanmill::report {
namespace {

constexpr std::size_t kWorst = 10;

/// Line feeds part problems of one message.
std::string lines(const std::string& text) {
  std::string out;
  for (const std::string& line : lines_of(text)) out += (out.empty() ? "" : "<br/>") + escaped(line);
  return out;
}

std::string growth(const NightFigure& figure) {
  if (figure.then <= 0) return "";
  char text[32];
  std::snprintf(text, sizeof text, "%.0f", (figure.now / figure.then - 1) * 100);
  return std::string(" (+") + text + "\xc2\xa0%)";
}

void add_worse_rows(const NightReport& night, std::size_t from, std::size_t to,
                    const std::map<std::string_view, const NightScan*>& scans, std::string& out) {
  out +=
      "<div class=\"scroll\"><table>\n<thead><tr><th scope=\"col\">fit error</th><th scope=\"col\">scan</th><th "
      "scope=\"col\">before \xe2\x86\x92 now</th></tr></thead>\n<tbody>\n";
  for (std::size_t k = from; k < to; ++k) {
    const NightWorse& worse = night.worse[k];
    const auto found = scans.find(worse.scan);
    NightScan unknown;
    unknown.name = worse.scan;
    const NightScan& scan = found == scans.end() ? unknown : *found->second;
    out += "<tr><td class=\"thumb\">" + thumbnail(scan, scan.error_picture) + "</td><th scope=\"row\">" +
           linked_name(scan) + "</th><td>";
    for (const NightFigure& figure : worse.figures) {
      const std::string unit = figure.unit.empty() ? "" : " " + escaped(figure.unit);
      out += "<p>" + escaped(figure.name) + "<br/>" + escaped(report::figure(figure.then)) + unit +
             " \xe2\x86\x92 <span class=\"up\">" + escaped(report::figure(figure.now)) + unit + growth(figure) +
             "</span></p>";
    }
    for (const std::string& gate : worse.new_gates)
      out += "<p>gate kept \xe2\x86\x92 <span class=\"up\">failed</span><br/>" + escaped(gate) + "</p>";
    out += "</td></tr>\n";
  }
  out += "</tbody></table></div>\n";
}

void add_fault(const NightScan& scan, const char* kind, const std::string& tags, std::string& out) {
  out += std::string("<article class=\"fault") + kind + "\"><h3>" + linked_name(scan) + tags + "</h3>\n<p>" +
         lines(scan.error) + "</p>\n";
  if (!scan.advice.empty()) out += "<p><b>What to do:</b> " + escaped(scan.advice) + "</p>\n";
  if (!scan.repeat.empty()) out += "<code>" + escaped(scan.repeat) + "</code>\n";
  if (!scan.log.empty()) out += "<p><a href=\"" + link_of(scan.log) + "\">log</a></p>\n";
  out += "</article>\n";
}

std::string tag(const std::string& word) {
  return word.empty() ? "" : "<span class=\"tag\">" + escaped(word) + "</span>";
}

bool has_failed(const NightScan& scan) {
  return scan.state == NightState::Failed || scan.state == NightState::Stale || scan.state == NightState::Interrupted;
}

std::size_t count_if(const NightReport& night, bool (*fits)(const NightScan&)) {
  return static_cast<std::size_t>(std::count_if(night.scans.begin(), night.scans.end(), fits));
}

}  // namespace

void add_worse(const NightReport& night, std::string& out) {
  if (night.worse.empty()) return;
  std::map<std::string_view, const NightScan*> scans;
  for (const NightScan& scan : night.scans) scans[scan.name] = &scan;
  add_counted_heading(out, "worse", "Worse than the run before", night.worse.size());
  const std::size_t first = std::min(kWorst, night.worse.size());
  add_worse_rows(night, 0, first, scans, out);
  if (first == night.worse.size()) return;
  out += "<details><summary>" + grouped(night.worse.size() - first) + " more</summary>\n";
  add_worse_rows(night, first, night.worse.size(), scans, out);
  out += "</details>\n";
}

void add_failed(const NightReport& night, std::string& out) {
  const std::size_t count = count_if(night, has_failed);
  if (count == 0) return;
  add_counted_heading(out, "failed", "Failed", count);
  for (const NightScan& scan : night.scans) {
    if (!has_failed(scan)) continue;
    const bool kept = scan.state == NightState::Stale;
    add_fault(scan, kept ? " kept" : "",
              tag(scan.failure) + tag(scan.stage.empty() ? "" : "in " + scan.stage) +
                  tag(kept ? "last good result kept" : ""),
              out);
  }
}

void add_rejected(const NightReport& night, std::string& out) {
  const std::size_t count = count_if(night, [](const NightScan& scan) { return !scan.failed_gates.empty(); });
  if (count == 0) return;
  add_counted_heading(out, "rejected", "Rejected by a gate", count);
  out +=
      "<div class=\"scroll\"><table>\n<thead><tr><th scope=\"col\">fit error</th><th scope=\"col\">scan</th><th "
      "scope=\"col\">gates</th></tr></thead>\n<tbody>\n";
  for (const NightScan& scan : night.scans) {
    if (scan.failed_gates.empty()) continue;
    out += "<tr><td class=\"thumb\">" + thumbnail(scan, scan.error_picture) + "</td><th scope=\"row\">" +
           linked_name(scan) + "</th><td>";
    for (const std::string& gate : scan.failed_gates) out += "<p class=\"up\">" + escaped(gate) + "</p>";
    out += "</td></tr>\n";
  }
  out += "</tbody></table></div>\n";
}

void add_quarantined(const NightReport& night, std::string& out) {
  const auto held = [](const NightScan& scan) { return scan.state == NightState::Quarantined; };
  const std::size_t count = count_if(night, held);
  if (count == 0) return;
  add_counted_heading(out, "quarantined", "Quarantined", count);
  for (const NightScan& scan : night.scans)
    if (held(scan)) add_fault(scan, " old", tag(scan.failure), out);
}

}  // namespace scanmill::report
