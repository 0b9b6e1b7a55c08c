// SPDX-License-Identifier: Apache-2.0
// A part on a deck with specks about it: the clean rules of a job leave the part alone.
#include <gtest/gtest.h>

#include "base/random.hpp"
#include "base/text.hpp"
#include "formats/mesh_reader.hpp"
#include "pipeline/run_scan.hpp"
#include "support/meshing.hpp"
#include "support/shapes.hpp"
#include "support/temp_folder.hpp"

namespace scanmill::pipeline {
namespace {

struct Scene {
  support::TempFolder folder;
  std::size_t deck = 9000, part = 9000, specks = 12;
  Scene() {
    std::string text;
    auto add = [&](Vec3 p) { text += number_text(p.x) + " " + number_text(p.y) + " " + number_text(p.z) + "\n"; };
    Random random(1, 1, 1);
    for (std::size_t i = 0; i < deck; ++i)
      add(support::snapped({random.uniform(-40, 40), random.uniform(-40, 40), 0.04 * random.gauss()}));
    for (const Vec3& p : support::box_points({0, 0, 8}, {20, 16, 14}, part, 2)) add(support::snapped(p));
    for (std::size_t i = 0; i < specks; ++i) add({-30 + 5.0 * static_cast<double>(i), 25, 30});
    folder.write("archive/part.xyz", text);
  }

  Result<ScanResult> run(const std::string& clean, int threads, const std::string& out) const {
    TRY_ASSIGN(const auto root, document::parse_yaml("lattice: {bin_mm: 1}\n" + clean, "job.yaml"));
    TRY_ASSIGN(const What what, what_from(root, "job.yaml"));
    TRY_ASSIGN(const Discovery found, discover(folder.file("archive"), false));
    std::filesystem::create_directories(folder.file(out));
    const support::Workers workers(threads);
    NoProgress progress;
    return run_scan(folder.file("archive"), found.scans.at(0), what, folder.file(out), {}, workers.context(), progress);
  }
};

const char* const kRules =
    "clean:\n  remove_plane: {fit: true, distance_mm: 0.3, below: true}\n"
    "  outliers: {statistical: {neighbours: 4, deviations: 3}, min_component_share: 0.01}\n";

bool has_note(const ScanResult& result, const std::string& part) {
  for (const std::string& note : result.notes)
    if (note.find(part) != std::string::npos) return true;
  return false;
}

TEST(CleanScan, LeavesThePartAlone) {
  const Scene scene;
  const auto raw = scene.run("", 1, "raw");
  const auto clean = scene.run(kRules, 1, "clean");
  ASSERT_TRUE(raw.ok() && clean.ok()) << (clean.ok() ? raw : clean).error().text();
  EXPECT_EQ(raw->points_used, scene.deck + scene.part + scene.specks);
  EXPECT_GT(raw->boundary_loops, 0u);
  EXPECT_EQ(clean->points_read, raw->points_read);
  EXPECT_EQ(clean->points_used, scene.part);
  EXPECT_EQ(clean->boundary_loops, 0u);
  EXPECT_EQ(clean->strays, 0u);
  EXPECT_TRUE(has_note(*clean, "clean: 9,012 of 18,012 points were removed (remove_plane 9,000, ")) << clean->notes[1];
  EXPECT_TRUE(has_note(*clean, "% of the points; it goes through"));
  EXPECT_FALSE(has_note(*raw, "clean:"));
  const auto mesh = formats::read_mesh(memory_source("mesh.stl", scene.folder.read("clean/mesh.stl")));
  ASSERT_TRUE(mesh.ok());
  for (const Vec3& p : mesh->positions) ASSERT_GE(p.z, 0.99);
}

TEST(CleanScan, GivesTheSameBytesForAnyThreads) {
  const Scene scene;
  ASSERT_TRUE(scene.run(kRules, 1, "one").ok());
  for (const int threads : {2, 7}) {
    const std::string out = "threads-" + std::to_string(threads);
    ASSERT_TRUE(scene.run(kRules, threads, out).ok());
    for (const char* file : {"/mesh.stl", "/record.h5"})
      EXPECT_TRUE(scene.folder.read(out + file) == scene.folder.read(std::string("one") + file)) << out << file;
  }
}

TEST(CleanScan, RulesThatTakeNothingChangeNoTriangle) {
  const Scene scene;
  ASSERT_TRUE(scene.run("", 1, "raw").ok());
  const auto wide = scene.run("clean: {keep_box: {min: [-99, -99, -99], max: [99, 99, 99]}}\n", 2, "wide");
  ASSERT_TRUE(wide.ok()) << wide.error().text();
  EXPECT_TRUE(has_note(*wide, "clean: no rule took a point"));
  EXPECT_TRUE(scene.folder.read("wide/mesh.stl") == scene.folder.read("raw/mesh.stl"));
}

TEST(CleanScan, SaysWhenTheRulesLeaveNothingOrFindNoPlane) {
  const Scene scene;
  const auto none = scene.run("clean: {keep_box: {min: [500, 0, 0], max: [501, 1, 1]}}\n", 2, "none");
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().code, Code::BadInput);
  EXPECT_EQ(none.error().text(),
            "part.xyz: the clean rules took all 18,012 points (keep_box 18,012); widen keep_box, or correct the rule "
            "that took them");
  const auto plane = scene.run("clean: {remove_plane: {fit: true, distance_mm: 0.3, min_share: 0.9}}\n", 2, "plane");
  ASSERT_FALSE(plane.ok());
  EXPECT_EQ(plane.error().text().rfind("part.xyz: clean.remove_plane: no plane holds 90 % of the points", 0), 0u)
      << plane.error().text();
}

}  // namespace
}  // namespace scanmill::pipeline
