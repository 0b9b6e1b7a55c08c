// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdlib>

#include "pipeline/scale_report.hpp"

namespace scanmill::pipeline {
namespace {

ScaleRun run_of(std::uint64_t points, std::int64_t bricks, std::int64_t threads, const std::string& digest) {
  ScaleRun run;
  run.points = points;
  run.bricks = bricks;
  run.threads = threads;
  run.stl_sha256 = digest;
  run.cpu_s = 1;
  run.peak_bytes = std::uint64_t{20} << 20;
  return run;
}

ScaleReport report_of(std::vector<ScaleRun> runs) {
  ScaleReport report;
  report.version = "1";
  report.per_bin = 60;
  report.runs = std::move(runs);
  return report;
}

bool is_near(render::Rgb a, render::Rgb b) {  // the borders of lines are smoothed
  return std::abs(a.r - b.r) < 60 && std::abs(a.g - b.g) < 60 && std::abs(a.b - b.b) < 60;
}

int pixels_of(const render::Image& image, render::Rgb colour, int y0) {
  int count = 0;
  for (int y = y0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) count += is_near(image.pixel(x, y), colour) ? 1 : 0;
  return count;
}

TEST(ScaleReport, NamesTheRunsWhoseMeshesDiffer) {
  const ScaleReport report = report_of({run_of(1000, 0, 1, "aa"), run_of(5000, 0, 1, "bb")});
  EXPECT_TRUE(check_same_mesh(report, run_of(1000, 64, 2, "aa")).ok());
  EXPECT_TRUE(check_same_mesh(report, run_of(9000, 64, 2, "cc")).ok());
  const auto other = check_same_mesh(report, run_of(5000, 64, 2, "cc"));
  ASSERT_FALSE(other.ok());
  EXPECT_EQ(other.error().code, Code::Internal);
  const std::string text = other.error().text();
  EXPECT_NE(text.find("5,000 points with 1 thread in one piece"), std::string::npos) << text;
  EXPECT_NE(text.find("5,000 points with 2 threads in bricks of 64 bins"), std::string::npos) << text;
  EXPECT_NE(text.find("SHA-256 bb and cc"), std::string::npos) << text;
}

TEST(ScaleReport, FailuresAreSentences) {
  EXPECT_EQ(
      failure_in("scan cloud: failed: no | again: scanmill run\n"
                 R"({"type":"note","text":"cut into 1 inputs"})"
                 "\n"
                 R"({"type":"scan","name":"cloud","state":"failed","error":{"code":"BadInput","text":"a.ply: no"}})"
                 "\n"
                 R"({"type":"summary","scans":1,"exit":3})"
                 "\n"),
      "a.ply: no");
  EXPECT_EQ(failure_in(R"({"type":"error","code":"BadUsage","text":"memory cap: low"})"), "memory cap: low");
  EXPECT_EQ(failure_in(R"({"type":"gate","scan":"cloud","text":"too rough"})"), "too rough");
  EXPECT_EQ(failure_in("1\n2\n3\n4\n5\n6\n"), "2; 3; 4; 5; 6");
  EXPECT_EQ(failure_in(R"({"type":"summary","scans":1,"exit":3})"), "");
}

TEST(ScaleReport, CutScansHaveNoStages) {
  ScaleRun whole = run_of(1000, 0, 1, "aa");
  whole.stages = {{"reduce", "points", 1000, {2, 1, 3}, {1.5, 1, 2}, 4096}};
  const ScaleReport report = report_of({whole, run_of(1000, 64, 1, "aa")});
  const document::Node rows = *to_document(report).find("runs");
  EXPECT_NE(rows.items()[0].find("stages"), nullptr);
  EXPECT_EQ(rows.items()[1].find("stages"), nullptr);
  EXPECT_EQ(rows.items()[1].find("bricks")->as_integer(), 64);
  const std::string table = scale_table(report);
  EXPECT_NE(table.find("reduce, points"), std::string::npos) << table;
  EXPECT_EQ(scale_table(report_of({run_of(1000, 64, 1, "aa")})).find("stage, per"), std::string::npos);
}

TEST(ScaleReport, PictureShowsTheCapAndDashesBricks) {
  constexpr render::Rgb kFirst{31, 104, 173}, kCap{176, 24, 48};
  constexpr int kBelowLegend = 80;
  ScaleReport report = report_of({run_of(1000, 0, 1, "aa"), run_of(100'000, 0, 1, "bb")});
  const render::Image whole = scale_picture(report);
  EXPECT_EQ(pixels_of(whole, kCap, 0), 0);
  report.memory = "512M";
  EXPECT_GT(pixels_of(scale_picture(report), kCap, kBelowLegend), 300);
  report.memory.clear();
  for (ScaleRun& run : report.runs) run.bricks = 64;
  const render::Image cut = scale_picture(report);
  EXPECT_LT(pixels_of(cut, kFirst, kBelowLegend), 0.9 * pixels_of(whole, kFirst, kBelowLegend));
  EXPECT_GT(pixels_of(cut, kFirst, kBelowLegend), 0.3 * pixels_of(whole, kFirst, kBelowLegend));
}

}  // namespace
}  // namespace scanmill::pipeline
