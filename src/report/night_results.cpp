// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>

#include "base/text.hpp"
#include "report/html.hpp"
#include "report/night_sections.hpp"
#include "report/numbers.hpp"

namespace scanmill::report {
namespace {

constexpr std::size_t kCards = 1000;      // with a picture each; the rest by name
constexpr std::size_t kLongestWhy = 180;  // bytes

std::string figures_of(const NightScan& scan) {
  std::string words;
  const auto add = [&](const std::string& text) { words += (words.empty() ? "" : " \xc2\xb7 ") + text; };
  if (scan.max_error_mm) add("fit " + figure(*scan.max_error_mm) + " mm");
  if (scan.triangles) add(counted(*scan.triangles, "triangle"));
  if (scan.loops && *scan.loops > 0) add(counted(*scan.loops, "open loop"));
  if (scan.state == NightState::Done) add(duration(scan.seconds));
  return escaped(words);
}

std::string why_of(const NightScan& scan) {
  std::string words;
  for (const std::string& why : scan.why) words += (words.empty() ? "" : "; ") + why;
  if (words.size() > kLongestWhy) {
    std::size_t end = kLongestWhy;
    while (end > 0 && (static_cast<unsigned char>(words[end]) & 0xc0) == 0x80) --end;
    words.resize(end);
    words += " ...";
  }
  return escaped(words);
}

void add_card(const NightScan& scan, std::string& out) {
  const bool bad = !scan.failed_gates.empty();
  out += std::string("<article class=\"card") + (bad ? " bad" : "") + "\">" + thumbnail(scan, scan.picture) + "<h3>" +
         linked_name(scan) + "</h3><p>" + figures_of(scan);
  if (bad) out += " <span class=\"bad\">rejected</span>";
  if (!scan.log.empty()) out += " \xc2\xb7 <a href=\"" + link_of(scan.log) + "\">log</a>";
  out += "</p>";
  if (!scan.is_new && !scan.why.empty()) out += "<p>" + why_of(scan) + "</p>";
  out += "</article>\n";
}

/// Names in columns; `figures` after each.
void add_names(const std::vector<const NightScan*>& scans, bool figures, std::string& out) {
  out += "<ul class=\"names\">\n";
  for (const NightScan* scan : scans) {
    const std::string words = figures && scan->max_error_mm ? "fit " + figure(*scan->max_error_mm) + " mm" : "";
    out +=
        "<li>" + linked_name(*scan) + (words.empty() ? "" : " <span class=\"quiet\">" + words + "</span>") + "</li>\n";
  }
  out += "</ul>\n";
}

template <class Fits>
std::vector<const NightScan*> those(const NightReport& night, Fits&& fits) {
  std::vector<const NightScan*> found;
  for (const NightScan& scan : night.scans)
    if (fits(scan)) found.push_back(&scan);
  return found;
}

void add_gallery(std::vector<const NightScan*> scans, const char* id, const char* title, std::string& out) {
  if (scans.empty()) return;
  add_counted_heading(out, id, title, scans.size());
  out += "<div class=\"cards\">\n";
  for (std::size_t k = 0; k < std::min(scans.size(), kCards); ++k) add_card(*scans[k], out);
  out += "</div>\n";
  if (scans.size() <= kCards) return;
  scans.erase(scans.begin(), scans.begin() + kCards);
  out += "<p>And without pictures:</p>\n";
  add_names(scans, true, out);
}

void add_bars(const std::vector<std::pair<std::string, double>>& rows, const char* heading, double whole,
              std::string& out) {
  out += std::string("<div class=\"scroll short\"><table>\n<thead><tr><th scope=\"col\">") + heading +
         "</th><th scope=\"col\" class=\"n\">time</th><th scope=\"col\"></th></tr></thead>\n<tbody>\n";
  for (const auto& [name, seconds] : rows) {
    char width[32];
    std::snprintf(width, sizeof width, "%.1f%%", whole > 0 ? std::clamp(seconds / whole, 0.0, 1.0) * 100 : 0.0);
    out += "<tr><th scope=\"row\">" + name + "</th><td class=\"n\">" + duration(seconds) +
           "</td><td class=\"w\"><span class=\"bar\" style=\"width:" + width + "\"></span></td></tr>\n";
  }
  out += "</tbody></table></div>\n";
}

}  // namespace

void add_made(const NightReport& night, std::string& out) {
  add_gallery(those(night, [](const NightScan& s) { return s.state == NightState::Done && s.is_new; }), "new", "New",
              out);
  add_gallery(those(night, [](const NightScan& s) { return s.state == NightState::Done && !s.is_new; }), "changed",
              "Changed", out);
}

void add_others(const NightReport& night, std::string& out) {
  const auto list = [&](NightState state, const char* id, const char* title, const char* words) {
    const auto scans = those(night, [&](const NightScan& s) { return s.state == state; });
    if (scans.empty()) return;
    add_counted_heading(out, id, title, scans.size());
    out += std::string("<p class=\"quiet\">") + words + "</p>\n";
    const bool fold = scans.size() > 40;
    if (fold) out += "<details><summary>Show them</summary>\n";
    add_names(scans, state == NightState::Unchanged, out);
    if (fold) out += "</details>\n";
  };
  list(NightState::Pending, "unfinished", "Not finished", "Not reached; the next run goes on here.");
  list(NightState::Vanished, "vanished", "Vanished", "The archive no longer holds them; their results are kept.");
  list(NightState::Unchanged, "unchanged", "Unchanged", "Same input, keys and program: the earlier result stands.");
}

void add_cost(const NightReport& night, std::string& out) {
  auto made = those(night, [](const NightScan& s) { return s.state == NightState::Done; });
  if (made.empty()) return;
  out += "<h2 id=\"cost\">Times</h2>\n<div class=\"columns\">\n";
  std::vector<std::pair<std::string, double>> rows;
  double whole = 0;
  for (const auto& [stage, seconds] : night.stage_seconds) {
    rows.emplace_back(escaped(stage), seconds);
    whole = std::max(whole, seconds);
  }
  add_bars(rows, "stage, all scans", whole, out);
  std::stable_sort(made.begin(), made.end(),
                   [](const NightScan* a, const NightScan* b) { return a->seconds > b->seconds; });
  made.resize(std::min<std::size_t>(made.size(), 10));
  rows.clear();
  for (const NightScan* scan : made) rows.emplace_back(linked_name(*scan), scan->seconds);
  add_bars(rows, "slowest scans", made.front()->seconds, out);
  out += "</div>\n";
}

}  // namespace scanmill::report
