// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "pipeline/discovery.hpp"
#include "pipeline/scan_names.hpp"
#include "support/temp_folder.hpp"

namespace scanmill::pipeline {
namespace {

using support::TempFolder;
using Names = std::vector<std::string>;

const std::string kPly =
    "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 "
    "3\n";
const std::string kMesh =
    "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
    "property list uchar int v\nend_header\n1 2 3\n3 0 0 0\n";
const std::string kPlan = "scanmill_plan: 1\nunits: cm\nsensor: {perspective: false}\nstations:\n";

Names names_of(const Result<Discovery>& found) {
  Names names;
  if (found.ok())
    for (const ScanSpec& scan : found->scans) names.push_back(scan.name);
  else
    names.push_back(found.error().text());
  return names;
}

const ScanSpec& scan_of(const Discovery& found, const std::string& name) {
  for (const ScanSpec& scan : found.scans)
    if (scan.name == name) return scan;
  static const ScanSpec none;
  ADD_FAILURE() << "no scan " << name;
  return none;
}

bool has_note(const std::vector<std::string>& notes, const std::string& part) {
  for (const std::string& note : notes)
    if (note.find(part) != std::string::npos) return true;
  return false;
}

TEST(Discover, TakesPointFilesAndNothingElse) {
  const TempFolder folder;
  folder.write("b/part.ply", kPly);
  folder.write("a.xyz", "1 2 3\n");
  folder.write("table.csv", "x,y,z\n1,2,3\n");
  folder.write("empty.ply", "");
  folder.write("cut.ply", "ply\nformat asc");
  folder.write("mesh.ply", kMesh);
  folder.write("README.txt", "Scans of a part.\n");
  folder.write("README.md", "1 2 3\n");
  folder.write("photo.png", "\x89PNG");
  folder.write("poses.txt", "1 0 0 5\n0 1 0 6\n0 0 1 7\n0 0 0 1\n");
  folder.write("trajectory.log", "0 0 1\n1 0 0 5\n0 1 0 6\n0 0 1 7\n0 0 0 1\n");
  folder.write("old.ply~", kPly);
  folder.write(".hidden.ply", kPly);
  folder.write("job.yaml", "scanmill: 1\narchive: .\n# not a scanmill_plan\n");
  folder.write("other.json", "{\"scanmill_planner\": 1}");
  folder.write("x.laz", "LASF");
  folder.write("y.laz", "LASF");
  folder.write("lies.ply", "glTF");
  folder.write("depth.xyz", "\x89PNG");
  folder.write("scanner.las", "LASF");
  folder.write("capture.pcd", "VERSION .7\n");
  const auto found = discover(folder.path(), false);
  EXPECT_EQ(names_of(found), (Names{"a", "b/part", "capture", "cut", "empty", "scanner", "table"}));
  ASSERT_TRUE(found.ok());
  EXPECT_TRUE(has_note(found->notes, "2 files of the suffix .laz not read by this version, the first is x.laz"));
  EXPECT_TRUE(has_note(found->notes, "1 file of the format glTF not read by this version: lies.ply"));
  EXPECT_TRUE(has_note(found->notes, "1 file of depth maps (name them in views, with intrinsics): depth.xyz"));
  EXPECT_TRUE(has_note(found->notes, "mesh.ply"));
  EXPECT_TRUE(scan_of(*found, "cut").broken.empty());
  EXPECT_EQ(scan_of(*found, "b/part").views[0].path, "b/part.ply");
  EXPECT_EQ(names_of(discover(folder.path(), true)),
            (Names{"a", "b/part", "capture", "cut", "empty", "mesh", "scanner", "table"}));
}

TEST(Discover, LeavesOutWhatARunWroteIntoTheArchive) {
  const TempFolder folder;
  folder.write("part.xyz", "0 0 0\n1 0 0\n");
  folder.write("night/run.json", "{}");
  folder.write("night/journal/1.jsonl", "");
  folder.write("night/scans/part/mesh.ply",
               "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
               "property float z\nend_header\n1 2 3\n");
  folder.write("other/run.json", "{}");
  folder.write("other/more.xyz", "0 0 0\n1 0 0\n");
  const auto found = discover(folder.path(), true);
  ASSERT_TRUE(found.ok());
  ASSERT_EQ(found->scans.size(), 2u);
  EXPECT_EQ(found->scans[0].name, "other/more");
  EXPECT_EQ(found->scans[1].name, "part");
  ASSERT_FALSE(found->notes.empty());
  EXPECT_EQ(found->notes.back(), "1 output folder of scanmill is left out, the first is night/");
}

TEST(Discover, FindsItsScansWhereARunWroteBesideThem) {
  const TempFolder folder;
  folder.write("part.xyz", "0 0 0\n1 0 0\n");
  folder.write("scans/own.xyz", "0 0 0\n1 0 0\n");
  folder.write("run.json", "{}");
  folder.write("journal/1.jsonl", "");
  folder.write("scans/part/mesh.ply", kMesh);
  folder.write("scans/part/record.h5", "");
  const auto found = discover(folder.path(), true);
  EXPECT_EQ(names_of(found), (Names{"part", "scans/own"}));
  EXPECT_EQ(found->notes.back(), "1 output folder of scanmill is left out, the first is the archive itself");
}

TEST(Discover, BreaksScansWhoseNamesDifferByLetterCaseOnly) {
  const TempFolder folder;
  for (const char* file : {"GOOD.xyz", "good.xyz", "other.xyz"}) folder.write(file, "0 0 0\n1 0 0\n");
  const auto found = discover(folder.path(), false);
  ASSERT_EQ(names_of(found), (Names{"GOOD", "good", "other"}));
  EXPECT_EQ(found->scans[0].broken.rfind("GOOD.xyz and good.xyz make scans", 0), 0u) << found->scans[0].broken;
  EXPECT_EQ(found->scans[1].broken.rfind("good.xyz and GOOD.xyz make scans", 0), 0u) << found->scans[1].broken;
  EXPECT_EQ(found->scans[2].broken, "");
}

TEST(Discover, SaysWhenTheArchiveIsNotThere) {
  const auto found = discover("/no/such/archive", false);
  ASSERT_FALSE(found.ok());
  EXPECT_EQ(found.error().text(), "/no/such/archive: there is no such folder; check the path");
}

TEST(Discover, GivesFilesOfAPlanToIt) {
  const TempFolder folder;
  folder.write("part/plan.yaml",
               kPlan +
                   "  - {name: b, pose: {eye: [0,0,10], target: [0,0,0]}, data: ./views//b.ply}\n"
                   "  - {name: a, pose: {eye: [0,0,10], target: [0,0,0]}, data: views/a.ply, sha256: " +
                   std::string(64, 'A') +
                   "}\n  - {name: c, pose: {eye: [0,0,1], target: [0,0,0]}, data: none.ply}\n"
                   "  - {name: d, pose: {eye: [0,0,1], target: [0,0,0]}}\n");
  for (const char* file : {"part/views/a.ply", "part/views/b.ply", "part/views/c.ply"}) folder.write(file, kMesh);
  folder.write("part/extra.ply", kPly);
  const auto found = discover(folder.path(), false);
  EXPECT_EQ(names_of(found), (Names{"part/extra", "part/plan"}));
  const ScanSpec& scan = scan_of(*found, "part/plan");
  EXPECT_EQ(scan.kind, ScanKind::Plan);
  EXPECT_EQ(scan.units_mm, 10);
  ASSERT_EQ(scan.views.size(), 3u);
  EXPECT_EQ(scan.views[0].path, "part/none.ply");
  EXPECT_TRUE(scan.views[0].missing);
  EXPECT_EQ(scan.views[1].path, "part/views/a.ply");
  EXPECT_EQ(scan.views[1].expected_sha256, std::string(64, 'a'));
  EXPECT_EQ(scan.views[2].path, "part/views/b.ply");
  EXPECT_EQ(*scan.views[2].view_point.direction, (Vec3{0, 0, -1}));
  EXPECT_FALSE(scan.views[2].view_point.eye.has_value());
  EXPECT_TRUE(has_note(scan.notes, "station d"));
  // A plan says what the scan is made of: it is not made of what happens to be there.
  EXPECT_NE(scan.broken.find("part/plan.yaml: station c: the file part/none.ply is not there"), std::string::npos)
      << scan.broken;
}

TEST(Discover, JudgesThePlacesOfAPlanOnItsMachine) {
  const std::string machine =
      "scanmill_plan: 1\nmachine: {joints: [{name: x, type: linear, axis: [1, 0, 0], limits: [0, 10], lead_mm: 5, "
      "counts_per_rev: 2000}]}\nstations:\n";
  const TempFolder folder;
  folder.write("far.yaml", machine + "  - {name: a, joints: {x: 11}, data: a.ply}\n");
  folder.write("near.yaml", machine + "  - {name: b, counts: {x: 400}, joints: {x: 2}, data: b.ply}\n");
  folder.write("a.ply", kPly);
  folder.write("b.ply", kPly);
  const auto found = discover(folder.path(), false);
  EXPECT_EQ(scan_of(*found, "far").broken, "far.yaml: station a: joint x at 11 mm is beyond its limit of 10 mm");
  const ScanSpec& near = scan_of(*found, "near");
  EXPECT_EQ(near.broken, "");
  EXPECT_EQ(near.views[0].pose.translation, (Vec3{1, 0, 0}));
  EXPECT_TRUE(has_note(near.notes, "its counts say 1, 1 mm off"));
}

TEST(Discover, KeepsABrokenPlanAsABrokenScanWithItsFiles) {
  const TempFolder folder;
  folder.write("bad.yaml", kPlan + "  - {name: a, pose: {}, data: a.ply}\n");
  folder.write("torn.yaml", "scanmill_plan: 1\nstations: [\n");
  folder.write("a.ply", kPly);
  folder.write("outside.yaml", kPlan + "  - {name: a, pose: {eye: [0,0,10], target: [0,0,0]}, data: ../a.ply}\n");
  const auto found = discover(folder.path(), false);
  EXPECT_EQ(names_of(found), (Names{"bad", "outside", "torn"}));
  EXPECT_NE(scan_of(*found, "bad").broken.find("bad.yaml:5:"), std::string::npos) << scan_of(*found, "bad").broken;
  EXPECT_NE(scan_of(*found, "torn").broken.find("torn.yaml:"), std::string::npos);
  EXPECT_NE(scan_of(*found, "outside").broken.find("inside the folder"), std::string::npos);
}

TEST(Discover, TakesAConfWithItsViews) {
  const TempFolder folder;
  folder.write("bunny/bun.conf",
               "camera 1 2 3\nbmesh z.ply 0 0 0 0 0 0 1\nbmesh b.ply 1 0 0 0 0 0 1\nbmesh gone.ply 0 0 0 0 0 0 1\n");
  folder.write("bunny/z.ply", kMesh);
  folder.write("bunny/b.ply", kPly);
  folder.write("bunny/zipper.ply", kMesh);
  folder.write("none/all.conf", "bmesh x.ply 0 0 0 0 0 0 1\n");
  folder.write("wrong/w.conf", "bmesh x.ply 0 0\n");
  folder.write("etc/server.conf", "listen 80;\n");
  const auto found = discover(folder.path(), false);
  EXPECT_EQ(names_of(found), (Names{"bunny/bun", "none/all", "wrong/w"}));
  const ScanSpec& scan = scan_of(*found, "bunny/bun");
  EXPECT_EQ(scan.kind, ScanKind::Conf);
  ASSERT_EQ(scan.views.size(), 3u);
  EXPECT_EQ(scan.views[0].path, "bunny/b.ply");
  EXPECT_EQ(scan.views[0].pose.translation, (Vec3{1, 0, 0}));
  EXPECT_TRUE(scan.views[0].pose_in_file_units);
  EXPECT_TRUE(scan.views[1].missing);
  EXPECT_TRUE(scan.broken.empty());
  EXPECT_NE(scan_of(*found, "none/all").broken.find("none of the 1 files"), std::string::npos);
  EXPECT_NE(scan_of(*found, "wrong/w").broken.find("wrong/w.conf:1"), std::string::npos);
}

TEST(Discover, KeepsTheViewsOfADescriptionThatCannotBeRead) {
  const TempFolder folder;
  const std::string good = " 0 0 0 0 0 0 1\n";
  const std::string stations = "units: mm\nstations:\n  - {name: one, data: p1.ply}\n  - {name: two, data: p2.ply}\n";
  folder.write("slip/s.conf", "bmesh a.ply" + good + "bmesh b.ply 0 0 zero 0 0 0 1\n");
  folder.write("kinds/k.conf", "bmsh a.ply" + good + "bmsh ./b.ply" + good);
  folder.write("rotated/r.aln", "2\na.ply\n#\n1 0 0\nb.ply\n");
  folder.write("colon/c.yaml", "scanmill_plan 1\n" + stations);
  folder.write("letter/l.yaml", "scanmil_plan: 1\n" + stations);
  for (const char* place : {"slip/", "kinds/", "rotated/"})
    for (const char* name : {"a.ply", "b.ply", "aa.ply"}) folder.write(std::string(place) + name, kPly);
  for (const char* place : {"colon/", "letter/"})
    for (const char* name : {"p1.ply", "p2.ply", "xp1.ply"}) folder.write(std::string(place) + name, kPly);
  folder.write("other/settings.conf", "log = run.ply.log\n");
  folder.write("other/stations.yaml", "stations: [north, south]\n");
  folder.write("other/run.ply", kPly);
  const auto found = discover(folder.file(""), false);
  EXPECT_EQ(names_of(found), (Names{"colon/c", "colon/xp1", "kinds/aa", "kinds/k", "letter/l", "letter/xp1",
                                    "other/run", "rotated/aa", "rotated/r", "slip/aa", "slip/s"}));
  EXPECT_NE(scan_of(*found, "slip/s").broken.find("s.conf:2"), std::string::npos);
  EXPECT_NE(scan_of(*found, "kinds/k").broken.find("k.conf:1: found \"bmsh\""), std::string::npos);
  EXPECT_NE(scan_of(*found, "colon/c").broken.find("c.yaml:"), std::string::npos) << scan_of(*found, "colon/c").broken;
  EXPECT_NE(scan_of(*found, "letter/l").broken.find("scanmill_plan"), std::string::npos)
      << scan_of(*found, "letter/l").broken;
}

TEST(Discover, TellsOfWhatItPassesOver) {
  const TempFolder folder;
  for (const char* name : {"a.xyz.gz", "b.ply.gz", "c.zip", "d.tar.gz", "e.7z"}) folder.write(name, "\x1f\x8b");
  folder.write("points", "1 2 3\n4 5 6\n");
  folder.write("model", kPly);
  folder.write("LICENSE", "Do as you please, in 3 ways.\n");
  const std::string head = std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\1\0\0\0\1", 24);
  folder.write("f1.png", head + std::string("\x10\0", 2));
  folder.write("f2.png", head + std::string("\x10\0", 2));
  folder.write("photo.png", head + std::string("\x08\2", 2));
  const auto found = discover(folder.file(""), false);
  ASSERT_TRUE(found.ok()) << found.error().text();
  EXPECT_TRUE(found->scans.empty());
  const auto& notes = found->notes;
  EXPECT_TRUE(has_note(notes, "3 files packed (.gz) and not looked into; unpack, the first is a.xyz.gz"));
  EXPECT_TRUE(has_note(notes, "1 file packed (.zip) and not looked into; unpack: c.zip"));
  EXPECT_TRUE(has_note(notes, "packed (.7z)"));
  EXPECT_TRUE(has_note(notes, "1 file without a suffix holding points (rename to .xyz, or name in views): points"));
  EXPECT_TRUE(has_note(notes, "1 file without a suffix holding points (rename to .ply, or name in views): model"));
  EXPECT_TRUE(has_note(notes, "2 files of 16-bit grey PNG, perhaps depth maps"));
  EXPECT_EQ(notes.size(), 6u);
}

TEST(Discover, FindsOneScanInTheBunnyFolder) {
  const std::string data = support::data_folder();
  if (data.empty()) GTEST_SKIP() << "no development data";
  const auto found = discover(data + "/range-views/bunny", false);
  EXPECT_EQ(names_of(found), (Names{"bun"}));
  EXPECT_EQ(found->scans[0].views.size(), 10u);
  EXPECT_TRUE(found->scans[0].notes.empty());
  EXPECT_EQ(names_of(discover(data + "/range-views", false)),
            (Names{"bunny/bun", "pair-small-gicp/source", "pair-small-gicp/target", "pcl-capture/capture0001",
                   "pcl-capture/capture0002"}));
}

TEST(ScanNames, KeepSuffixesWhereTheRestIsNotEnough) {
  EXPECT_EQ(scan_names({"a.ply", "a.xyz", "b/a.ply", "a b.ply", "c", "d.tar.ply"}),
            (Names{"a.ply", "a.xyz", "b/a", "a%20b", "c", "d.tar"}));
  EXPECT_EQ(scan_names({"a.ply", "a.xyz", "a.ply.xyz"}), (Names{"a.ply", "a.xyz", "a.ply.xyz"}));
  EXPECT_EQ(scan_names({"a.ply", "a/b.ply"}), (Names{"a.ply", "a/b"}));
  EXPECT_EQ(scan_names({"\xc3\xa4%.ply"}), (Names{"%C3%A4%25"}));
}

TEST(ScanNames, StayShortEnoughForFoldersAndLogs) {
  std::string part;
  for (int i = 0; i < 20; ++i) part += "Деталь ";  // 240 bytes, 720 when they are all encoded
  const auto names = scan_names({part + "1.xyz", part + "2.xyz", "deep/" + part + "/" + part + ".ply", "plain.xyz"});
  for (const std::string& name : names)
    for (std::size_t begin = 0; begin <= name.size();) {
      const std::size_t end = std::min(name.find('/', begin), name.size());
      EXPECT_LE(end - begin, 200u) << name;
      begin = end + 1;
    }
  EXPECT_EQ(names[0].substr(0, 6), "%D0%94");
  EXPECT_NE(names[0], names[1]);
  EXPECT_EQ(names[2].substr(0, 5), "deep/");
  EXPECT_EQ(names[3], "plain");
}

TEST(ScanNames, ThatDifferByLetterCaseOnlyClash) {
  const Names paths{"Part.ply", "fine.ply", "part.xyz"};
  const auto clashes = case_clashes(scan_names(paths), paths);
  EXPECT_EQ(clashes[0].rfind("Part.ply and part.xyz make scans", 0), 0u) << clashes[0];
  EXPECT_EQ(clashes[1], "");
  EXPECT_EQ(clashes[2].rfind("part.xyz and Part.ply make scans", 0), 0u) << clashes[2];
}

}  // namespace
}  // namespace scanmill::pipeline
