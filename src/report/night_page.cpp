// SPDX-License-Identifier: Apache-2.0
// The order of the page: verdict and totals, what needs somebody, what was made, what it cost.
#include <algorithm>
#include <cstdio>

#include "base/text.hpp"
#include "report/html.hpp"
#include "report/night_sections.hpp"
#include "report/numbers.hpp"
#include "report/style.hpp"

namespace scanmill::report {
namespace {

// What the pages of scans have no use for.
constexpr const char* kNightStyle = R"(
a{color:#0b5394}
.held{background:#8a5a00}
.thumb{width:8rem;padding:.3rem .6rem .3rem 0}
.thumb img{display:block;width:8rem;height:auto;border:1px solid var(--line);border-radius:.25rem;background:#fff}
.cards{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,13.5rem),1fr));gap:1rem}
.card{min-width:0;border:1px solid var(--line);border-radius:.4rem;overflow:hidden;break-inside:avoid}
.card img{display:block;width:100%;height:auto;background:#fff;border-bottom:1px solid var(--line)}
.card h3{margin:.45rem .6rem .1rem;font-size:.98rem;overflow-wrap:anywhere}
.card p{margin:.1rem .6rem .3rem;font-size:.86rem;color:var(--faint)}
.card.bad{border:2px solid var(--fail)}.card .bad{color:var(--fail);font-weight:600}
.fault{margin:.7rem 0;padding:.55rem .9rem;border:1px solid var(--line);border-left:.35rem solid var(--fail);
border-radius:.3rem;break-inside:avoid}
.fault.kept{border-left-color:#d98200}.fault.old{border-left-color:var(--faint)}
.fault h3{margin:0;overflow-wrap:anywhere}.fault p{margin:.25rem 0}
.fault code{display:block;padding:.3rem .5rem;background:var(--wash);border-radius:.25rem;font-size:.84rem;
overflow-wrap:anywhere;white-space:pre-wrap}
.tag{margin-left:.5rem;padding:.05rem .45rem;border:1px solid var(--line);border-radius:.7rem;color:var(--faint);
font-size:.8rem;font-weight:400;white-space:nowrap}
.up{color:var(--fail);font-weight:600}span.up{white-space:nowrap}
td p{margin:0 0 .35rem}
.names{padding:0;list-style:none;columns:16rem}.names li{padding:.08rem 0;font-size:.9rem;break-inside:avoid}
summary{cursor:pointer;padding:.3rem 0}
.bar{display:block;height:.55rem;min-width:1px;background:#7d8b99;border-radius:.15rem;
-webkit-print-color-adjust:exact;print-color-adjust:exact}
.columns table{width:100%}td.w{width:40%;min-width:6rem;vertical-align:middle}
@media (max-width:40rem){.cards{grid-template-columns:1fr 1fr;gap:.6rem}.thumb,.thumb img{width:5rem}
.fault{padding:.45rem .6rem}.names{columns:9rem}}
@media print{.cards{grid-template-columns:repeat(4,1fr);gap:.5rem}.thumb,.thumb img{width:2.6cm}
.card p,.card h3{font-size:7.5pt}details{display:none}}
)";

void add_head(const NightReport& night, std::string& out) {
  const std::string title = (night.job.empty() ? "run" : night.job) + ": " + night.verdict;
  out +=
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
      // Pictures from beside the page and nothing from anywhere else, whatever a name may hold.
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src 'self' file:; style-src "
      "'unsafe-inline'\"/>\n<title>" +
      escaped(title) + "</title>\n<style>" + kStyleSheet + kNightStyle + "</style>\n</head>\n<body>\n<header>\n<h1>" +
      escaped(night.job.empty() ? "Run" : night.job) + "</h1>\n<p class=\"sub\">" + escaped(night.started) + " to " +
      escaped(night.ended) + (night.host.empty() ? "" : " on " + escaped(night.host)) +
      (night.compared_with.empty() ? "; no earlier run to compare with"
                                   : "; compared with the run of " + escaped(night.compared_with)) +
      "</p>\n";
}

void add_verdict(const NightReport& night, std::string& out) {
  const int code = night.exit_code;
  const auto held =
      static_cast<std::uint64_t>(std::count_if(night.scans.begin(), night.scans.end(), [](const NightScan& scan) {
        return scan.state == NightState::Quarantined;
      }));
  const bool good = code == 0, interrupted = code >= 128;
  const std::string word = good && held > 0 ? grouped(held) + " QUARANTINED"
                           : good           ? "\xe2\x9c\x93 ALL GOOD"
                           : interrupted    ? "INTERRUPTED"
                           : code == 3      ? "\xe2\x9c\x97 SCANS FAILED"
                           : code == 4      ? "\xe2\x9c\x97 GATES FAILED"
                                            : "\xe2\x9c\x97 STOPPED";
  const std::string words = !good      ? night.verdict
                            : held > 0 ? "failed before and not tried again; every other scan is done or unchanged"
                                       : "every scan is done or unchanged";
  const char* colour = good && held > 0 ? "held" : good ? "pass" : interrupted ? "none" : "fail";
  out += std::string("<div class=\"verdict ") + colour + "\"><strong>" + word + "</strong><span>" + escaped(words) +
         "; exit code " + std::to_string(code) + "</span></div>\n";
}

struct Counts {
  std::size_t made = 0, fresh = 0, changed = 0, unchanged = 0, failed = 0, stale = 0, quarantined = 0, vanished = 0;
  std::size_t unfinished = 0, rejected = 0;
  double cpu_seconds = 0, points = 0;
  std::uint64_t peak = 0;
};

Counts counts_of(const NightReport& night) {
  Counts n;
  for (const NightScan& scan : night.scans) {
    n.cpu_seconds += scan.cpu_seconds;
    n.peak = std::max(n.peak, scan.peak_bytes);
    n.rejected += scan.failed_gates.empty() ? 0 : 1;
    n.unchanged += scan.state == NightState::Unchanged;
    n.failed += scan.state == NightState::Failed || scan.state == NightState::Stale;
    n.stale += scan.state == NightState::Stale;
    n.quarantined += scan.state == NightState::Quarantined;
    n.vanished += scan.state == NightState::Vanished;
    n.unfinished += scan.state == NightState::Pending || scan.state == NightState::Interrupted;
    if (scan.state != NightState::Done) continue;
    ++n.made;
    ++(scan.is_new ? n.fresh : n.changed);
    n.points += static_cast<double>(scan.points.value_or(0));
  }
  return n;
}

void add_tile(std::string& out, const char* name, const std::string& value, const std::string& below,
              bool bad = false) {
  out += std::string(bad ? "<div class=\"bad\">" : "<div>") + "<dt>" + name + "</dt><dd>" + escaped(value) +
         "</dd><dd>" + escaped(below) + "</dd></div>\n";
}

/// 1234567 as "1.23 M": the second figure of a tile must stay short.
std::string short_number(double value) {
  char text[40];
  const bool mega = value >= 1e6, kilo = value >= 1e4;
  std::snprintf(text, sizeof text, mega ? "%.2f M" : kilo ? "%.1f k" : "%.0f", value / (mega ? 1e6 : kilo ? 1e3 : 1));
  return text;
}

void add_tiles(const NightReport& night, const Counts& n, std::string& out) {
  out += "<dl class=\"tiles\">\n";
  add_tile(out, "made", grouped(n.made), grouped(n.fresh) + " new, " + grouped(n.changed) + " changed");
  add_tile(out, "unchanged", grouped(n.unchanged), "an earlier result stands");
  add_tile(out, "failed", grouped(n.failed),
           n.stale > 0 ? grouped(n.stale) + " with the last good result kept" : "without a new result", n.failed > 0);
  add_tile(out, "rejected", grouped(n.rejected), "beyond a gate; files kept", n.rejected > 0);
  add_tile(out, "worse", night.compared_with.empty() ? "-" : grouped(night.worse.size()), "than the run before");
  add_tile(out, "quarantined", grouped(n.quarantined), "failed before, not tried again");
  if (n.unfinished > 0) add_tile(out, "not finished", grouped(n.unfinished), "the next run goes on here", true);
  if (n.vanished > 0) add_tile(out, "vanished", grouped(n.vanished), "source gone, result kept");
  add_tile(out, "time", duration(night.seconds), duration(n.cpu_seconds) + " CPU");
  const double hours = std::max(night.seconds, 1e-3) / 3600;
  add_tile(out, "scans per hour", grouped(static_cast<std::uint64_t>(static_cast<double>(n.made) / hours + 0.5)),
           short_number(n.points / hours / 3600) + " points/s");
  if (n.peak > 0)
    add_tile(out, "peak memory", bytes_text(n.peak),
             night.memory_cap > 0 ? "cap " + bytes_text(night.memory_cap) : "no cap");
  out += "</dl>\n";
}

void add_notes(const NightReport& night, std::string& out) {
  constexpr std::size_t kNotes = 30;
  if (night.notes.empty()) return;
  out += "<ul class=\"notes\" aria-label=\"notes\">\n";
  for (std::size_t k = 0; k < std::min(night.notes.size(), kNotes); ++k)
    out += "<li>Note: " + escaped(night.notes[k]) + "</li>\n";
  if (night.notes.size() > kNotes)
    out += "<li>" + grouped(night.notes.size() - kNotes) + " more notes stand in run.json.</li>\n";
  out += "</ul>\n";
}

/// Links to the sections that `body` has.
std::string navigation(std::string_view body) {
  static constexpr std::pair<const char*, const char*> kSections[] = {{"worse", "Worse"},
                                                                      {"failed", "Failed"},
                                                                      {"rejected", "Rejected"},
                                                                      {"quarantined", "Quarantined"},
                                                                      {"new", "New"},
                                                                      {"changed", "Changed"},
                                                                      {"vanished", "Vanished"},
                                                                      {"unfinished", "Not finished"},
                                                                      {"unchanged", "Unchanged"},
                                                                      {"cost", "Times"}};
  std::string nav = "<nav aria-label=\"on this page\">";
  for (const auto& [id, name] : kSections)
    if (body.find(std::string("<h2 id=\"") + id + "\"") != std::string_view::npos)
      nav += std::string("<a href=\"#") + id + "\">" + name + "</a> ";
  return nav + "<a href=\"run.json\">run.json</a> <a href=\"trace.tsv\">trace.tsv</a></nav>\n";
}

}  // namespace

std::string duration(double seconds) {
  char text[64];
  const auto whole = static_cast<unsigned long long>(std::max(0.0, seconds) + 0.5);
  if (seconds < 60)
    std::snprintf(text, sizeof text, seconds < 1 ? "%.2f s" : "%.1f s", std::max(0.0, seconds));
  else if (whole < 3600)
    std::snprintf(text, sizeof text, "%llu min %02llu s", whole / 60, whole % 60);
  else
    std::snprintf(text, sizeof text, "%llu h %02llu min", whole / 3600, whole / 60 % 60);
  return text;
}

std::string link_of(std::string_view path) {
  static constexpr char kHex[] = "0123456789ABCDEF";
  std::string out;
  for (const char c : path) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
                       c == '.' || c == '_' || c == '~' || c == '/';
    if (plain)
      out += c;
    else
      out += {'%', kHex[byte >> 4], kHex[byte & 15]};
  }
  return out;
}

std::string linked_name(const NightScan& scan) {
  if (scan.page.empty()) return escaped(scan.name);
  return "<a href=\"" + link_of(scan.page) + "\">" + escaped(scan.name) + "</a>";
}

std::string thumbnail(const NightScan& scan, const std::string& picture) {
  if (picture.empty()) return {};
  const std::string image =
      "<img loading=\"lazy\" width=\"640\" height=\"480\" alt=\"\" src=\"" + link_of(picture) + "\"/>";
  return scan.page.empty() ? image : "<a href=\"" + link_of(scan.page) + "\">" + image + "</a>";
}

void add_counted_heading(std::string& out, const char* id, const char* title, std::size_t count) {
  out += std::string("<h2 id=\"") + id + "\">" + title + " <span class=\"quiet\">" + grouped(count) + "</span></h2>\n";
}

std::string night_page(const NightReport& night) {
  std::string out;
  add_head(night, out);
  add_verdict(night, out);
  add_tiles(night, counts_of(night), out);
  add_notes(night, out);
  const std::size_t top = out.size();
  out += "</header>\n<main>\n";
  add_worse(night, out);
  add_failed(night, out);
  add_rejected(night, out);
  add_quarantined(night, out);
  add_made(night, out);
  add_others(night, out);
  add_cost(night, out);
  out.insert(top, navigation(std::string_view(out).substr(top)));
  out += "</main>\n<footer><p>" + escaped(night.tool) + ", archive " + escaped(night.archive) + ", " +
         counted(static_cast<std::uint64_t>(night.threads), "thread") + ".</p></footer>\n</body>\n</html>\n";
  return out;
}

}  // namespace scanmill::report
