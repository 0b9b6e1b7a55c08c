// SPDX-License-Identifier: Apache-2.0
// The page of a run: sound, nothing alive in it, what needs somebody first, small for a thousand scans.
#include <gtest/gtest.h>

#include "outline.hpp"
#include "report/night_report.hpp"

namespace scanmill::report {
namespace {

NightScan scan_of(const std::string& name, NightState state) {
  NightScan scan;
  scan.name = name;
  scan.state = state;
  if (state == NightState::Failed || state == NightState::Quarantined || state == NightState::Stale) {
    scan.failure = "bad_input";
    scan.stage = "reduce";
    scan.error = name + ".ply: byte 7: cut\nsecond problem";
    scan.advice = "Repair it.";
    scan.repeat = "scanmill run job.yaml --only " + name;
  }
  if (state == NightState::Done || state == NightState::Unchanged || state == NightState::Stale) {
    scan.page = "scans/" + name + "/report.html";
    scan.picture = "scans/" + name + "/preview-shaded.png";
    scan.error_picture = "scans/" + name + "/preview-error.png";
    scan.max_error_mm = 0.5;
    scan.triangles = 6240;
    scan.loops = 1;
    scan.points = 30000;
  }
  scan.seconds = 2;
  scan.cpu_seconds = 3;
  scan.log = "logs/" + name + ".log";
  scan.why = {"new"};
  scan.is_new = true;
  return scan;
}

NightReport sample_night() {
  NightReport night;
  night.job = "nightly.yaml";
  night.archive = "/srv/scans";
  night.host = "mill";
  night.tool = "scanmill 0.1.0";
  night.started = "2026-01-31T22:15:00Z";
  night.ended = "2026-02-01T00:07:30Z";
  night.compared_with = "2026-01-31T00:01:00Z";
  night.verdict = "2 scans failed, 1 scan rejected by a gate";
  night.exit_code = 3;
  night.seconds = 6750;
  night.notes = {"1 file of the suffix .las is not read"};
  for (const NightState state :
       {NightState::Pending, NightState::Unchanged, NightState::Done, NightState::Failed, NightState::Stale,
        NightState::Quarantined, NightState::Interrupted, NightState::Vanished})
    night.scans.push_back(scan_of("state" + std::to_string(static_cast<int>(state)), state));
  NightScan changed = scan_of("changed", NightState::Done);
  changed.is_new = false;
  changed.why = {"input v1.ply changed"};
  changed.failed_gates = {"verify.max_error_mm: found 2 mm, allowed 1 mm"};
  night.scans.push_back(changed);
  for (int k = 0; k < 12; ++k)
    night.worse.push_back({"worse" + std::to_string(k), {{"greatest fit error", "mm", 0.25, 0.75 - 0.01 * k}}, {}});
  night.worse[1].scan = "changed";
  night.worse[1].new_gates = {"verify.max_error_mm: found 2 mm, allowed 1 mm"};
  night.stage_seconds = {{"reduce", 0.5}, {"mesh", 1.5}};
  return night;
}

void expect_sound(const std::string& page) {
  const Outline outline = outline_of(page);
  EXPECT_EQ(outline.fault, "");
  for (const std::string& tag : outline.opened) {
    for (const char* word : {"<script", "<link", "<iframe", "<form", " on", "://", "url("})
      EXPECT_EQ(("<" + tag).find(word), std::string::npos) << tag;
    for (const char* name : {"href=\"", "src=\""}) {
      const std::size_t at = tag.find(name);
      if (at == std::string::npos) continue;
      const std::string link = tag.substr(at + std::string(name).size(), 6);
      EXPECT_TRUE(link.starts_with("scans/") || link.starts_with("logs/") || link.starts_with("#") ||
                  link.starts_with("run.js") || link.starts_with("trace."))
          << tag;
    }
  }
  EXPECT_EQ(page.find("@import"), std::string::npos);
  EXPECT_EQ(page.find("url("), std::string::npos);
  std::set<std::string> ids;
  for (std::size_t at = page.find(" id=\""); at != std::string::npos; at = page.find(" id=\"", at + 1))
    EXPECT_TRUE(ids.insert(page.substr(at + 5, page.find('"', at + 5) - at - 5)).second);
  for (std::size_t at = page.find("href=\"#"); at != std::string::npos; at = page.find("href=\"#", at + 1))
    EXPECT_EQ(ids.count(page.substr(at + 7, page.find('"', at + 7) - at - 7)), 1u);
}

TEST(NightPage, IsWellFormedAndFetchesNothingFromElsewhere) {
  expect_sound(night_page(sample_night()));
  expect_sound(night_page(NightReport()));
}

TEST(NightPage, TellsWhatNeedsSomebodyFirst) {
  const std::string page = night_page(sample_night());
  std::size_t before = 0;
  for (const char* part : {"SCANS FAILED",
                           "id=\"worse\"",
                           "worse0",
                           "0.25 mm",
                           "0.75 mm (+200",
                           "failed</span><br/>",
                           "<summary>2 more",
                           "id=\"failed\"",
                           "state3.ply: byte 7: cut<br/>second problem",
                           "<b>What to do:</b> Repair it.",
                           "scanmill run job.yaml --only state3",
                           "last good result kept",
                           "id=\"rejected\"",
                           "id=\"quarantined\"",
                           "id=\"new\"",
                           "scans/state2/preview-shaded.png",
                           "id=\"changed\"",
                           "input v1.ply changed",
                           "id=\"unfinished\"",
                           "id=\"vanished\"",
                           "id=\"unchanged\"",
                           "id=\"cost\""}) {
    const std::size_t at = page.find(part, before);
    EXPECT_NE(at, std::string::npos) << part << " is not there, or not in its order";
    if (at != std::string::npos) before = at;
  }
  for (const char* part : {"1 h 52 min", "compared with the run of 2026-01-31T00:01:00Z", "1 new, 1 changed",
                           "Note: 1 file of the suffix .las", "archive /srv/scans"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
}

TEST(NightPage, LinksToNamesOfAnyBytes) {
  EXPECT_EQ(link_of("scans/a b/100%25#?\"\xff.png"), "scans/a%20b/100%2525%23%3F%22%FF.png");
  const std::string evil = "\"><script>alert(1)</script>&lt;'\xff\x01\xe2\x80\xae\n%20";
  NightReport night = sample_night();
  night.job = night.archive = night.host = night.tool = night.started = night.ended = night.verdict = evil;
  night.compared_with = evil;
  night.notes = {evil};
  for (NightScan& scan : night.scans) {
    scan.name = scan.failure = scan.stage = scan.error = scan.advice = scan.repeat = evil;
    scan.why = {evil};
    if (!scan.failed_gates.empty()) scan.failed_gates = {evil};
    for (std::string* path : {&scan.page, &scan.log, &scan.picture, &scan.error_picture})
      if (!path->empty()) *path = "scans/" + evil;
  }
  for (NightWorse& worse : night.worse) {
    worse.scan = evil;
    worse.figures[0].name = worse.figures[0].unit = evil;
    worse.new_gates = {evil};
  }
  for (auto& [stage, seconds] : night.stage_seconds) stage = evil;
  const std::string page = night_page(night);
  expect_sound(page);
  for (const char* bad : {"<script", "\xff", "\x01", "\xe2\x80\xae"}) EXPECT_EQ(page.find(bad), std::string::npos);
}

TEST(NightPage, StaysSmallForManyScans) {
  NightReport night = sample_night();
  night.scans.clear();
  night.worse.clear();
  const auto add = [&](int count, NightState state, bool is_new) {
    for (int k = 0; k < count; ++k) {
      NightScan scan = scan_of("customer/part-" + std::to_string(night.scans.size()) + "/plan", state);
      scan.is_new = is_new;
      scan.why = {"input customer/part/plan/view-1.ply changed", "lattice.bin_mm 1 -> 1.5"};
      night.scans.push_back(scan);
      if (state == NightState::Done) night.worse.push_back({scan.name, {{"greatest fit error", "mm", 0.25, 0.5}}, {}});
    }
  };
  add(1000, NightState::Done, false);
  const std::string worst = night_page(night);  // all of them changed, all of them worse
  EXPECT_LT(worst.size(), 2000000u);
  EXPECT_EQ(count_of(worst, "class=\"card\""), 1000u);
  EXPECT_EQ(count_of(worst, "<img "), count_of(worst, "<img loading=\"lazy\""));
  add(1000, NightState::Done, true);
  add(8000, NightState::Unchanged, false);
  night.worse.clear();
  const std::string page = night_page(night);
  EXPECT_LT(page.size(), 4000000u);
  std::set<std::string> links;
  for (std::size_t at = page.find("href=\""); at != std::string::npos; at = page.find("href=\"", at + 1))
    links.insert(page.substr(at + 6, page.find('"', at + 6) - at - 6));
  for (const NightScan& scan : night.scans) EXPECT_EQ(links.count(link_of(scan.page)), 1u) << scan.name;
}

}  // namespace
}  // namespace scanmill::report
