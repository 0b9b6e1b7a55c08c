// SPDX-License-Identifier: Apache-2.0
// Bins finer than the points allow, and meshes that stand for few of the points, are told of.
#include <gtest/gtest.h>

#include "base/random.hpp"
#include "base/text.hpp"
#include "pipeline/density.hpp"
#include "pipeline/run_scan.hpp"
#include "support/meshing.hpp"
#include "support/temp_folder.hpp"

namespace scanmill::pipeline {
namespace {

constexpr std::size_t kDense = 40 * 40, kSparse = 30 * 30;

/// A plate with a point every 0.5 mm beside one with a point every 3 mm.
struct TwoPlates {
  support::TempFolder folder;
  explicit TwoPlates(bool sparse) {
    std::string text;
    Random random(3, 1, 4);
    auto plate = [&](double from, double step, std::size_t side) {
      for (std::size_t i = 0; i < side * side; ++i)
        text += number_text(from + step * static_cast<double>(i % side) + 0.1 * random.uniform()) + " " +
                number_text(step * static_cast<double>(i / side) + 0.1 * random.uniform()) + " 0\n";
    };
    plate(0, 0.5, 40);
    if (sparse) plate(100, 3, 30);
    folder.write("archive/plates.xyz", text);
  }
  Result<ScanResult> run(const std::string& keys, const std::string& out) const {
    TRY_ASSIGN(const auto root, document::parse_yaml(keys, "job.yaml"));
    TRY_ASSIGN(const What what, what_from(root, "job.yaml"));
    TRY_ASSIGN(const Discovery found, discover(folder.file("archive"), false));
    std::filesystem::create_directories(folder.file(out));
    const support::Workers workers(2);
    NoProgress progress;
    return run_scan(folder.file("archive"), found.scans.at(0), what, folder.file(out), {}, workers.context(), progress);
  }
};

std::string notes_of(const ScanResult& result) {
  std::string text;
  for (const std::string& note : result.notes) text += note + "\n";
  return text;
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(Density, SaysHowManyPointsTheMeshStandsForAndWhichBinsWouldMeshTheRest) {
  const TwoPlates scene(true);
  const auto run = scene.run("lattice: {bin_mm: 1}\n", "out");
  ASSERT_TRUE(run.ok()) << run.error().text();
  EXPECT_EQ(run->points_used, kDense + kSparse);
  EXPECT_EQ(run->points_meshed, kDense);
  const std::string notes = notes_of(*run);
  EXPECT_TRUE(has(notes, "the mesh stands for 64 % of the points: 1,600 of 2,500 lie within a bin edge")) << notes;
  EXPECT_TRUE(has(notes, "apart, too far for bins of 1 mm: set lattice.bin_mm to about ")) << notes;
  EXPECT_FALSE(has(notes, "bare surroundings")) << notes;
  const std::string page = scene.folder.read("out/report.html");
  EXPECT_TRUE(has(page, "<div class=\"bad\"><dt>points on the mesh</dt><dd>64.00 %</dd>"));
  EXPECT_TRUE(has(page, "<b>Warning:</b> the mesh stands for 64 %"));
}

TEST(Density, SaysNothingWhereTheMeshStandsForThePoints) {
  const TwoPlates scene(false);
  const auto run = scene.run("lattice: {bin_mm: 1}\n", "out");
  ASSERT_TRUE(run.ok()) << run.error().text();
  EXPECT_EQ(run->points_meshed, kDense);
  EXPECT_FALSE(has(notes_of(*run), "lattice.bin_mm")) << notes_of(*run);
}

TEST(Density, SaysWhenBinsAreFinerThanThePoints) {
  const TwoPlates scene(false);
  const auto fine = scene.run("lattice: {bin_mm: 0.5}\n", "fine");
  ASSERT_TRUE(fine.ok()) << fine.error().text();
  EXPECT_TRUE(has(notes_of(*fine), "bins of 0.5 mm are too fine: the points lie about 0.")) << notes_of(*fine);
  const auto good = scene.run("lattice: {bin_mm: 0.8}\n", "good");
  ASSERT_TRUE(good.ok()) << good.error().text();
  EXPECT_FALSE(has(notes_of(*good), "too fine")) << notes_of(*good);
}

TEST(Density, DoesNotBlameBinsForFacesTheJobLeavesOut) {
  const TwoPlates scene(true);
  const auto run = scene.run("lattice: {bin_mm: 4}\nseeds: {points: [[10, 10, 0]], cover: false}\n", "out");
  ASSERT_TRUE(run.ok()) << run.error().text();
  const std::string notes = notes_of(*run);
  EXPECT_TRUE(has(notes, "the job leaves out what no given seed reaches (seeds.cover: false)")) << notes;
  EXPECT_FALSE(has(notes, "lattice.bin_mm") || has(notes, "larger bins")) << notes;
}

TEST(Density, TimesStagesUnderTheNamesThatProgressTells) {
  const TwoPlates scene(false);
  const auto run = scene.run("lattice: {bin_mm: 1}\n", "out");
  ASSERT_TRUE(run.ok()) << run.error().text();
  std::string names;
  for (const auto& stage : run->stage_times.wall_s) names += stage.first + " ";
  EXPECT_EQ(names, "open reduce stars complete merge grow optimise verify hash inputs export record pictures report ");
}

TEST(Density, WritesTwoDigits) {
  for (const auto& [value, digits] :
       {std::pair{0.12345, 0.12}, {9.96, 10.0}, {1234.0, 1200.0}, {0.0, 0.0}, {47.6, 48.0}})
    EXPECT_DOUBLE_EQ(two_digits(value), digits);
}

}  // namespace
}  // namespace scanmill::pipeline
