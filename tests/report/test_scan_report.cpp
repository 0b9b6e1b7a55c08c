// SPDX-License-Identifier: Apache-2.0
// The page as a stranger's reader sees it: sound HTML, nothing alive in it, every number there, the same bytes twice.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "outline.hpp"
#include "report/html.hpp"
#include "report/numbers.hpp"
#include "sample.hpp"

namespace scanmill::report {
namespace {

std::string page_of(const ScanReport& report) {
  std::string bytes;
  auto sink = memory_sink("report.html", bytes);
  EXPECT_TRUE(write_scan_report(report, *sink).ok());
  EXPECT_TRUE(sink->commit().ok());
  return bytes;
}

TEST(WriteScanReport, IsWellFormedAndFetchesNothing) {
  for (const ScanReport& report : {sample_report(), bare_report(), ScanReport()}) {
    const std::string page = page_of(report);
    const Outline o = outline_of(page);
    EXPECT_EQ(o.fault, "");
    for (const char* word : {"http://", "https://", "<link", "@import", "url(", "javascript:", " on"})
      for (const std::string& tag : o.opened) EXPECT_EQ(("<" + tag).find(word), std::string::npos) << tag;
    EXPECT_EQ(count_of(page, "<script"), report.view ? 2u : 0u);
    EXPECT_EQ(page.find("@import"), std::string::npos);
    EXPECT_EQ(page.find("url("), std::string::npos);
    EXPECT_EQ(count_of(page, "<h1>"), 1u);
    EXPECT_EQ(count_of(page, "<title>"), 1u + count_of(page, "<rect"));  // bars have titles
    EXPECT_EQ(count_of(page, "<table"), count_of(page, "<thead>"));
    std::set<std::string> ids;  // links on the page lead somewhere, and every id is given once
    for (std::size_t at = page.find(" id=\""); at != std::string::npos; at = page.find(" id=\"", at + 1))
      EXPECT_TRUE(ids.insert(page.substr(at + 5, page.find('"', at + 5) - at - 5)).second);
    for (std::size_t at = page.find("href=\"#"); at != std::string::npos; at = page.find("href=\"#", at + 1))
      EXPECT_EQ(ids.count(page.substr(at + 7, page.find('"', at + 7) - at - 7)), 1u);
  }
}

TEST(WriteScanReport, EscapesHostileNamesEverywhere) {
  const std::string evil = "\"><script>alert(1)</script>&lt;'\xff\x01\xe2\x80\xae.ply";
  ScanReport r = sample_report();
  r.title = r.scan = r.job = r.tool = r.record = r.date = evil;
  for (Gate& g : r.gates) g.key = g.unit = evil;
  r.gates[0].passed = false;
  for (Note& n : r.notes) n.text = evil;
  for (Picture& p : r.pictures) p.caption = evil;
  for (Dropped& d : r.points.dropped) d.reason = evil;
  for (Dropped& d : r.reduction->thinned) d.reason = evil;
  r.mesh.crossings = 1;
  r.mesh.crossing_places = {{1, 2, {3, 4, 5}, evil}};
  for (WorstPoint& p : r.fit->worst) p.file = p.row_meaning = evil;
  for (PatchRow& p : r.patches) p.name = p.origin = evil;
  for (Swaps& s : r.swaps) s.pass = evil;
  for (Parameter& p : r.parameters) p.key = p.symbol = p.value = p.unit = p.default_value = evil;
  for (InputFile& f : r.inputs) f.path = f.format = f.sha256 = evil;
  for (OutputFile& f : r.outputs) f.path = f.sha256 = evil;
  for (auto& [stage, version] : r.stage_versions) stage = version = evil;
  for (auto& [stage, seconds] : r.stage_seconds) stage = evil;
  const std::string page = page_of(r);
  EXPECT_EQ(outline_of(page).fault, "");
  EXPECT_EQ(count_of(page, "<script"), 2u) << "the view's numbers and its script, nothing else";
  EXPECT_EQ(page.find('\xff'), std::string::npos);
  EXPECT_EQ(page.find('\x01'), std::string::npos);
  EXPECT_EQ(page.find("\xe2\x80\xae"), std::string::npos);
  EXPECT_GT(count_of(page, "&quot;&gt;&lt;script&gt;alert(1)&lt;/script&gt;&amp;lt;&#39;\\xff\\x01\\u{202e}.ply"), 60u);
}

TEST(WriteScanReport, HasEveryNumber) {
  const std::string page = page_of(sample_report());
  for (const char* text : {"stanford/bunny",
                           "jobs/nightly.yaml",
                           "scanmill 0.1.0",
                           "PASSED",
                           "All 2 gates are kept",
                           "362,272",
                           "359,813",
                           "99.32 %",
                           "1,647",
                           "812",
                           "78,766",
                           "59,994",
                           "18,772",
                           "118,924",
                           "59,562",
                           "5,412",
                           ">-6<",
                           "27.32",
                           "5.012",
                           "1.047",
                           "57,113",
                           "0.9135",
                           "0.05211",
                           "-0.00123",
                           "0.02346",
                           "0.08124",
                           "0.1054",
                           "0.1712",
                           "0.5222",
                           "0.4876",
                           "0.2713",
                           "0.4339",
                           "0.0508",
                           "0.9643",
                           "99.87 %",
                           "(12.250, -104.500, 7.062)",
                           "vertex 40,256",
                           "open border",
                           "views/top &lt;b&gt;&amp;amp; side.ply",
                           "(81.250, 3.000, -44.500)",
                           "22.41",
                           "29.87",
                           "20,117",
                           "3,121",
                           "921,334",
                           "913,007",
                           "1,371",
                           "1,340",
                           "lattice.bin_mm",
                           "must be given",
                           "changed",
                           "missing",
                           "1.2",
                           "min_component_share",
                           "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08",
                           "fcde2b2edba56bf408601fb721fe9b5c338d10ee429ea04fae5511b68fbf8fb9",
                           "5d41402abc4b2a76b9719d911017c592ae2b1b5a0c7ad7a6f2d3b8c9e0f1a2b3",
                           "3,145,880",
                           "Warning:",
                           "stage stars",
                           "7 more loops are not listed here",
                           "2025-03-01 05:58 UTC",
                           "verify 0.19 s",
                           "0 ear",
                           "data:image/png;base64,iVBORw0KGgo"})
    EXPECT_NE(page.find(text), std::string::npos) << text;
  EXPECT_EQ(count_of(page, "<figure>"), 4u);
  EXPECT_EQ(count_of(page, "<svg"), 1u);
}

TEST(WriteScanReport, LeavesOutWhatIsNotKnown) {
  const std::string page = page_of(bare_report());
  for (const char* text :
       {"Fit error", "Gates<", "Pictures", "Parameters", "Patches", "Creases", "NaN", "nan", "not known"})
    EXPECT_EQ(page.find(text), std::string::npos) << text;
  EXPECT_NE(page.find("NO GATES"), std::string::npos);
  EXPECT_NE(page.find("self-intersections not looked for"), std::string::npos);
  EXPECT_NE(page.find("the surface is closed"), std::string::npos);
  EXPECT_EQ(page.find(kRunLine), std::string::npos);
}

TEST(WriteScanReport, PutsTheVerdictFirst) {
  ScanReport r = sample_report();
  r.gates[1].passed = false;
  r.gates[1].found = 0.0771;
  r.mesh.misoriented_edges = 4;
  const std::string page = page_of(r);
  const std::size_t verdict = page.find("FAILED"), why = page.find("verify.rms_mm: 0.0771 mm, limit 0.06 mm");
  EXPECT_LT(verdict, why);
  EXPECT_LT(why, page.find("<dl"));
  EXPECT_LT(page.find("4 mis-oriented edges"), page.find("<main>"));
  EXPECT_EQ(page.find("PASSED"), std::string::npos);
  EXPECT_NE(page.find("rejected"), std::string::npos);
}

TEST(WriteScanReport, ShowsTheWorstPointsOnceWhenAllLieInTheInterior) {
  ScanReport r = sample_report();
  EXPECT_EQ(count_of(page_of(r), "Worst points"), 2u);
  r.fit->worst = r.fit->worst_interior;
  for (WorstPoint& p : r.fit->worst) p.row_meaning = "vertex from 0";
  const std::string page = page_of(r);
  EXPECT_EQ(count_of(page, "Worst points"), 1u);
  EXPECT_NE(page.find("vertex 40,256 (from 0)"), std::string::npos);
}

TEST(WriteScanReport, OrdersLoopsByLength) {
  const std::string page = page_of(sample_report());
  // 57 loops of 3.3 .. 143.3 mm in steps of 2.5: the fifty longest are 143.3 .. 20.8.
  const std::size_t loops = page.find("id=\"loops\"");
  const std::size_t longest = page.find(">143.3<", loops), next = page.find(">140.8<", loops),
                    last = page.find(">20.8<", loops);
  EXPECT_LT(loops, longest);
  EXPECT_LT(longest, next);
  EXPECT_LT(next, last);
  EXPECT_NE(last, std::string::npos);
  EXPECT_EQ(page.substr(loops, page.find("id=\"patches\"") - loops).find(">18.3<"), std::string::npos);
}

TEST(WriteScanReport, DiffersBetweenRunsOnOneLineOnly) {
  const std::string page = page_of(sample_report());
  EXPECT_EQ(page, page_of(sample_report()));
  ScanReport later = sample_report();
  later.date = "2026-01-01 00:00 UTC";
  later.stage_seconds[0].second = 99;
  const std::string other = page_of(later);
  const auto without = [](std::string text) {
    const std::size_t at = text.find(kRunLine);
    return text.erase(at, text.find('\n', at) - at);
  };
  EXPECT_NE(page, other);
  EXPECT_EQ(without(page), without(other));
  EXPECT_EQ(count_of(page, kRunLine), 1u);
}

TEST(WriteScanReport, HandsOnWhatTheSinkReports) {
  class FullSink final : public ByteSink {
   public:
    const std::string& name() const override { return name_; }
    Result<void> write(std::span<const char>) override { return fail(Code::NoSpace, "the disk is full", name_); }
    Result<void> commit() override { return {}; }

   private:
    std::string name_ = "report.html";
  } sink;
  const auto result = write_scan_report(sample_report(), sink);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, Code::NoSpace);
}

TEST(Histogram, SurvivesEveryKindOfCounts) {
  ScanReport r = sample_report();
  for (const double low : {-2.0, 0.0, 5.0, -1e-9, -1e9}) {
    for (const std::size_t steps : {std::size_t{1}, std::size_t{7}, std::size_t{128}}) {
      r.fit->histogram = {low, 1.0 / 32, std::vector<std::uint64_t>(steps, 0), 0, 0};
      EXPECT_EQ(page_of(r).find("<svg"), std::string::npos);
      r.fit->histogram.counts.back() = 1;
      r.fit->histogram.above = 1000000;
      EXPECT_EQ(outline_of(page_of(r)).fault, "");
    }
  }
  r.fit->histogram = {-2, NAN, {1, 2, 3}, 0, 0};
  EXPECT_EQ(page_of(r).find("<svg"), std::string::npos);
}

TEST(Figure, HasFourSignificantDigits) {
  EXPECT_EQ(figure(0), "0");
  EXPECT_EQ(figure(0.0123456), "0.01235");
  EXPECT_EQ(figure(-12.3456), "-12.35");
  EXPECT_EQ(figure(1234.567), "1,235");
  EXPECT_EQ(figure(1234567.8), "1,234,568");
  EXPECT_EQ(figure(1.0), "1");
  EXPECT_EQ(figure(2.5), "2.5");
  EXPECT_EQ(figure(0.99996), "1.000");
  EXPECT_EQ(figure(1.2345e-7), "1.235e-07");
  EXPECT_EQ(figure(1e300), "1.000e+300");
  EXPECT_EQ(figure(NAN), "not known");
  EXPECT_EQ(figure(-INFINITY), "-infinite");
  EXPECT_EQ(signed_figure(0.25), "+0.25");
  EXPECT_EQ(signed_figure(-0.25), "-0.25");
  EXPECT_EQ(signed_figure(0), "0");
}

TEST(Place, HasThreeDecimals) {
  EXPECT_EQ(place({-1234.5678, 0.0004, -0.0001}), "(-1,234.568, 0.000, 0.000)");
  EXPECT_EQ(fixed3(1e300), "1.000e+300");
}

TEST(Share, NeverRoundsToAllOrNone) {
  EXPECT_EQ(share(1, 1000000), "0.01 %");
  EXPECT_EQ(share(999999, 1000000), "99.99 %");
  EXPECT_EQ(share(5, 5), "100 %");
  EXPECT_EQ(share(0, 5), "0 %");
  EXPECT_EQ(share(0, 0), "-");
  EXPECT_EQ(share(1, 3), "33.33 %");
}

TEST(Escaped, KeepsGoodTextAndShowsBadBytes) {
  EXPECT_EQ(escaped("Geh\xc3\xa4use \xe6\x97\xa5 \xf0\x9f\x90\xb0"), "Geh\xc3\xa4use \xe6\x97\xa5 \xf0\x9f\x90\xb0");
  EXPECT_EQ(escaped("a\nb\tc\x7f"), "a\\x0ab\\x09c\\x7f");
  EXPECT_EQ(escaped("\xc0\xaf\xed\xa0\x80\xf5"), "\\xc0\\xaf\\xed\\xa0\\x80\\xf5");
  EXPECT_EQ(escaped("x\xe2\x82"), "x\\xe2\\x82");
  EXPECT_EQ(escaped("\xe2\x80\x8f\xef\xbb\xbf\xc2\x85"), "\\u{200f}\\u{feff}\\u{0085}");
}

TEST(Base64, FollowsItsRule) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64(std::string("\xff\xfe\xfd\0", 4)), "//79AA==");
}

}  // namespace
}  // namespace scanmill::report
