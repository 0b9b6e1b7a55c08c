// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/hash_cache.hpp"
#include "pipeline/run_scan.hpp"
#include "pipeline/scan_points.hpp"
#include "pipeline/what.hpp"
#include "support/temp_folder.hpp"

namespace scanmill::pipeline {
namespace {

using support::TempFolder;

Result<What> what(const std::string& text) {
  return what_from(*document::parse_yaml("lattice: {bin_mm: 1}\n" + text, "job.yaml"), "job.yaml");
}

std::string error_of(const std::string& text) {
  const auto result = what(text);
  return result.ok() ? "no error" : result.error().text();
}

DiscoveryKeys keys_of(const std::string& text) {
  const auto tree = document::parse_yaml(text, "job.yaml");
  return discovery_keys(*tree);
}

/// Shift by k along x.
std::string matrix(int k) { return "1 0 0 " + std::to_string(k) + "\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"; }

TEST(ViewsKey, ReadsEveryKeyAndWritesItBack) {
  const auto read = what(
      "views:\n  - {name: a/b, files: 'd/*.png', every: 3, poses: d/t.log, eye: [1, -2, 3.5], intrinsics: [525, 525.5, "
      "319.5, 239], "
      "depth_scale: 5000}\n  - {name: 7, files: x.pcd, pose: [1,0,0,5, 0,1,0,6, 0,0,1,7, 0,0,0,1], x-who: me}\n");
  ASSERT_TRUE(read.ok()) << read.error().text();
  ASSERT_EQ(read->views.size(), 2u);
  const ViewsSpec& first = read->views[0];
  EXPECT_EQ(first.name, "a/b");
  EXPECT_EQ(first.every, 3);
  EXPECT_EQ(first.poses, "d/t.log");
  EXPECT_EQ(first.eye, (Vec3{1, -2, 3.5}));
  EXPECT_EQ(*first.camera, (formats::DepthCamera{525, 525.5, 319.5, 239, 5000}));
  EXPECT_EQ(read->views[1].name, "7");
  EXPECT_EQ(pose_from_matrix(*read->views[1].pose)->translation, (Vec3{5, 6, 7}));
  EXPECT_FALSE(read->views[1].camera.has_value());
  const document::Node tree = to_document(*read);
  const auto again = what_from(tree, "again");
  ASSERT_TRUE(again.ok()) << again.error().text();
  EXPECT_EQ(document::to_canonical_json(to_document(*again)), document::to_canonical_json(tree));
  EXPECT_EQ(what_for(*read, "7").views.size(), 1u);
  EXPECT_EQ(to_document(what_for(*read, "other")).find("views"), nullptr);
}

TEST(ViewsKey, ReportsEveryProblemWithPlaceAndNearest) {
  const std::string text = error_of(
      "views:\n"
      "  - {name: a, file: x}\n"
      "  - {name: .a, files: ../x, every: 0.5, poses: /p.log, intrinsics: [1, 2, 3]}\n"
      "  - {name: a, files: x, depth_scale: 0}\n"
      "  - {name: c, files: x, intrinsics: [0, 1, 2, 3], poses: p, pose: [1]}\n"
      "  - {name: d, files: x, pose: [[2,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]], intrinsics: [1,1,1,1], depth_scale: "
      "0}\n"
      "  - 7\n"
      "format: psd\n");
  for (const char* line :
       {"job.yaml:3:15: views[0].file: unknown key; allowed name, files, every, poses, pose, eye, intrinsics, "
        "depth_scale; "
        "nearest files",
        "job.yaml:3:5: views[0]: found no files; add files:",
        "job.yaml:4:12: views[1].name: found .a; allowed a name of letters",
        "views[1].files: found ../x; allowed a pattern of files inside the archive",
        "views[1].every: found 0.5; allowed a whole number in [1, 1000000000]",
        "views[1].poses: found /p.log; allowed a file inside the archive",
        "views[1].intrinsics: found a list; allowed four numbers [fx, fy, cx, cy]",
        "views[2].name: found a a second time", "views[2].depth_scale: found no intrinsics with it",
        "views[3].intrinsics: found a list; allowed [fx, fy, cx, cy] with fx and fy other than 0",
        "views[3].pose: found both poses and pose; keep one",
        "views[4].pose: the rotation of a pose matrix is off orthonormal",
        "views[4].depth_scale: found 0; allowed a number above 0", "views[5]: found 7; allowed a map of name, files",
        "format: found psd; allowed auto, ply, text, pts, ptx, pcd, las, png"})
    EXPECT_NE(text.find(line), std::string::npos) << line << "\nin\n" << text;
}

TEST(NaturalOrder, ComparesRunsOfDigitsAsNumbers) {
  std::vector<std::string> names{"f10.png", "f2.png", "f1.png", "f01.png", "f2a.png", "g", "f", "f002.png", "d/f3"};
  std::sort(names.begin(), names.end(), natural_before);
  EXPECT_EQ(names, (std::vector<std::string>{"d/f3", "f", "f01.png", "f1.png", "f002.png", "f2.png", "f2a.png",
                                             "f10.png", "g"}));
}

TEST(Views, GivePoseKToFileKBeforeThinning) {
  const TempFolder folder;
  std::string log;
  for (int k = 0; k < 12; ++k) {
    folder.write("seq/f" + std::to_string(k) + ".xyz", "0 0 " + std::to_string(k) + "\n");
    log += std::to_string(k) + " " + std::to_string(k) + " " + std::to_string(k + 1) + "\n" + matrix(10 * k);
  }
  folder.write("seq/poses.log", log);
  folder.write("other.xyz", "1 2 3\n");
  const auto found =
      discover(folder.path(), keys_of("views:\n  - {name: all, files: 'seq/*.xyz', every: 5, poses: seq/poses.log}\n"));
  ASSERT_TRUE(found.ok()) << found.error().text();
  ASSERT_EQ(found->scans.size(), 2u);  // thinned files are no scans of their own
  const ScanSpec& scan = found->scans[0];
  EXPECT_EQ(scan.name, "all");
  EXPECT_EQ(scan.kind, ScanKind::Views);
  EXPECT_EQ(scan.description, "seq/poses.log");
  ASSERT_EQ(scan.views.size(), 3u);
  EXPECT_EQ(scan.views[0].path, "seq/f0.xyz");
  EXPECT_EQ(scan.views[1].path, "seq/f10.xyz");  // byte order of paths gives the view ids
  EXPECT_EQ(scan.views[2].path, "seq/f5.xyz");
  const auto points = ScanPoints::open(folder.path(), scan, 1000);
  ASSERT_TRUE(points.ok()) << points.error().text();
  PointBlock block;
  ASSERT_TRUE((*points)->read_block(1, block).ok());
  EXPECT_EQ(block.positions, (std::vector<Vec3>{{100000, 0, 10000}}));  // poses are in the files' units
}

TEST(Views, TellWhereTheSensorSat) {
  const TempFolder folder;
  folder.write("a.xyz", "1 0 0\n2 0 0\n");
  const auto found = discover(folder.path(), keys_of("views:\n  - {name: a, files: a.xyz, eye: [0, 0, 3], "
                                                     "pose: [1,0,0,5, 0,1,0,6, 0,0,1,7, 0,0,0,1]}\n"));
  ASSERT_TRUE(found.ok()) << found.error().text();
  const auto points = ScanPoints::open(folder.path(), found->scans[0], 10);
  ASSERT_TRUE(points.ok()) << points.error().text();
  PointBlock block;
  ASSERT_TRUE((*points)->read_block(0, block).ok());
  EXPECT_EQ(block.positions[0], (Vec3{60, 60, 70}));
  EXPECT_EQ(block.view_point.eye, (Vec3{50, 60, 100}));  // in the files' units, moved with them
}

TEST(ScanPoints, RefuseUnitsThatTheFileContradicts) {
  const TempFolder folder;
  folder.write("a.xyz", "X [m],Y [m],Z [m]\n1,0,0\n2,0,0\n");
  const auto found = discover(folder.path(), DiscoveryKeys{});
  ASSERT_TRUE(found.ok()) << found.error().text();
  EXPECT_TRUE(ScanPoints::open(folder.path(), found->scans[0], 1000).ok());
  const auto in_mm = ScanPoints::open(folder.path(), found->scans[0], 1);
  ASSERT_FALSE(in_mm.ok());
  EXPECT_EQ(in_mm.error().text(),
            "a.xyz: the names of the columns say m, the points are to be read as mm; set units: m (--units m), or take "
            "the unit out of the names where it is wrong");
}

TEST(Views, SayWhatDoesNotFit) {
  const TempFolder folder;
  for (const char* name : {"a.xyz", "b.xyz", "c.xyz"}) folder.write(name, "1 2 3\n");
  folder.write("two.txt", matrix(1) + matrix(2));
  folder.write("two.aln", "2\na.xyz\n#\n" + matrix(1) + "b.xyz\n#\n" + matrix(2) + "0\n");
  folder.write("cut.log", "0 0 1\n1 0 0 0\n");
  auto broken = [&](const std::string& entry) {
    const auto found = discover(folder.path(), keys_of("views:\n  - {name: v, " + entry + "}\n"));
    if (!found.ok()) return found.error().text();
    for (const ScanSpec& scan : found->scans)
      if (scan.name == "v") return scan.broken;
    return std::string("no scan");
  };
  EXPECT_EQ(broken("files: '*.xyz', poses: two.txt"),
            "views.v: 3 files match '*.xyz', two.txt holds 2 poses; wanted one pose per file");
  EXPECT_EQ(broken("files: '*.xyz', poses: two.aln"),
            "views.v: 3 files match '*.xyz', two.aln holds 2 poses, none of them for c.xyz");
  EXPECT_EQ(broken("files: '?.xyz', poses: cut.log"),
            "views.v: cut.log:3: the file ends, wanted a row of four numbers of a 4x4 matrix; it was cut");
  EXPECT_EQ(broken("files: a.xy"), "views.v: found no file of the archive that matches 'a.xy'; nearest a.xyz");
  EXPECT_NE(broken("files: a.xyz, poses: gone.log").find("gone.log"), std::string::npos);
  EXPECT_EQ(broken("files: 'a.xyz', poses: two.aln"), "");
  const auto same = discover(folder.path(), keys_of("views:\n  - {name: C, files: a.xyz}\n"));
  ASSERT_FALSE(same.ok());
  EXPECT_EQ(same.error().code, Code::BadParameter);
  EXPECT_NE(same.error().text().find("found the name C, which the scan c of the archive has already"),
            std::string::npos);
}

TEST(Views, WithoutAPoseAreToldOfAndDepthMapsRefused) {
  const auto scan = [](const std::string& keys, const std::vector<std::string>& files) {
    std::vector<std::string> matched;
    const auto spec = keys_of("lattice: {bin_mm: 1}\nviews:\n  - {name: cap, files: '*', " + keys + "}\n").views.at(0);
    return scan_of_views(spec, files, std::vector<formats::NamedPose>(), matched);
  };
  const std::string camera = "intrinsics: [525, 525, 320, 240]";
  const auto stacked = scan("every: 1", {"a.pcd", "b.pcd", "c.pcd"});
  ASSERT_EQ(stacked.notes.size(), 1u);
  EXPECT_EQ(stacked.notes[0].rfind("3 views and no pose: all are taken to lie in one frame already", 0), 0u);
  EXPECT_TRUE(stacked.broken.empty());
  const auto depth = scan(camera, {"a.png", "b.png"});
  EXPECT_NE(depth.broken.find("views.cap: found 2 depth maps and no poses"), std::string::npos) << depth.broken;
  const std::string unit = "pose: [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]";
  for (const auto& fine : {scan("every: 1", {"a.pcd"}), scan(camera, {"a.png"}), scan("every: 1", {"a.ptx", "b.ptx"}),
                           scan(unit, {"a.pcd", "b.pcd"})}) {
    EXPECT_TRUE(fine.notes.empty());
    EXPECT_TRUE(fine.broken.empty()) << fine.broken;
  }
}

TEST(Views, OfOneScanLeaveTheFingerprintsOfOthersAlone) {
  const TempFolder folder;
  folder.write("a.xyz", "1 2 3\n");
  folder.write("b.xyz", "1 2 3\n");
  folder.write("p.txt", matrix(1));
  HashCache cache;
  auto fingerprint = [&](const std::string& text, std::size_t number) {
    const auto found = discover(folder.path(), keys_of(text));
    EXPECT_TRUE(found.ok()) << found.error().text();
    return digests_of(folder.path(), found->scans[number], key_texts(*what(text), found->scans[number].name), cache)
        ->all;
  };
  const std::string none = "units: m\n", with = "units: m\nviews:\n  - {name: v, files: b.xyz, poses: p.txt}\n";
  EXPECT_EQ(fingerprint(none, 0), fingerprint(with, 0));
  const std::string other = "units: m\nviews:\n  - {name: v, files: b.xyz, poses: p.txt, every: 2}\n";
  EXPECT_NE(fingerprint(with, 1), fingerprint(other, 1));
  const std::string before = fingerprint(with, 1);
  folder.write("p.txt", matrix(2));
  EXPECT_NE(fingerprint(with, 1), before);
}

TEST(ScanPoints, TakeEveryScanOfAPtxAsAView) {
  const TempFolder folder;
  const std::string head = "1\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  folder.write("b.ptx", head + "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 0\n0 0 0 0\n" + head +
                            "0 1 0 0\n-1 0 0 0\n0 0 1 0\n10 20 30 1\n1 0 0 0\n2 0 0 0\n");
  folder.write("c.xyz", "4 5 6\n");
  ScanSpec scan;
  ViewSpec missing, ptx, text;
  missing.path = "a.xyz";
  missing.missing = true;
  ptx.path = "b.ptx";
  ptx.pose.translation = {1000, 0, 0};  // the scan's pose comes after the file's own
  text.path = "c.xyz";
  scan.views = {missing, ptx, text};
  const auto points = ScanPoints::open(folder.path(), scan, 10);
  ASSERT_TRUE(points.ok()) << points.error().text();
  ASSERT_EQ((*points)->specs().size(), 4u);
  EXPECT_TRUE((*points)->specs()[0].missing);
  ASSERT_EQ((*points)->views().size(), 3u);
  EXPECT_EQ((*points)->views()[2].id, ViewId{3});
  PointBlock block;
  ASSERT_TRUE((*points)->read_block(0, block).ok());
  EXPECT_EQ(block.view, ViewId{1});
  EXPECT_EQ(block.positions, (std::vector<Vec3>{{1010, 20, 30}}));
  EXPECT_EQ(*block.view_point.eye, (Vec3{1000, 0, 0}));
  ASSERT_TRUE((*points)->read_block(1, block).ok());
  EXPECT_EQ(block.view, ViewId{2});
  EXPECT_EQ(block.positions, (std::vector<Vec3>{{1100, 210, 300}, {1100, 220, 300}}));
  EXPECT_EQ(*block.view_point.eye, (Vec3{1100, 200, 300}));
  EXPECT_EQ((*points)->counts()[0].sensor_invalid, 1u);
  const ChunkLoop loop(3);
  const CancelFlag cancel;
  const auto digests = (*points)->digests({loop, cancel});
  ASSERT_TRUE(digests.ok());
  EXPECT_EQ((*digests)[0], (*digests)[1]);
  EXPECT_NE((*digests)[0], (*digests)[2]);
}

TEST(Discover, TakesAnAlnLikeAConf) {
  const TempFolder folder;
  folder.write("part/all.aln", "2\na.xyz\n#\n" + matrix(1) + "b.xyz\n#\n" + matrix(2) + "0\n");
  folder.write("part/a.xyz", "1 2 3\n");
  folder.write("part/b.xyz", "1 2 3\n");
  folder.write("plain.aln", matrix(1));
  const auto found = discover(folder.path(), false);
  ASSERT_TRUE(found.ok()) << found.error().text();
  ASSERT_EQ(found->scans.size(), 2u);
  EXPECT_EQ(found->scans[0].name, "part/all");
  ASSERT_EQ(found->scans[0].views.size(), 2u);
  EXPECT_EQ(found->scans[0].views[1].pose.translation, (Vec3{2, 0, 0}));
  EXPECT_TRUE(found->scans[0].broken.empty());
  EXPECT_NE(found->scans[1].broken.find("poses without names"), std::string::npos);
}

TEST(Discover, TakesAForcedFormatAtItsWord) {
  const TempFolder folder;
  folder.write("a.txt", "2\n1 2 3\n4 5 6\n");
  const auto points = [&](formats::Format format) {
    ScanSpec scan;
    scan.views.emplace_back().path = "a.txt";
    return ScanPoints::open(folder.path(), scan, 1, format);
  };
  EXPECT_EQ((*points(formats::Format::Auto))->views()[0].header.format, "text");
  EXPECT_EQ((*points(formats::Format::Pts))->views()[0].header.format, "pts");
  const auto las = points(formats::Format::Las);
  ASSERT_FALSE(las.ok());
  EXPECT_NE(las.error().text().find("wanted LASF"), std::string::npos);
}

TEST(Views, OfDepthFramesGiveOneMeshForAnyThreads) {
  const std::string data = support::data_folder();
  if (data.empty()) GTEST_SKIP() << "no development data";
  const std::string archive = data + "/range-views/livingroom-depth";
  const std::string text =
      "units: m\nlattice: {bin_mm: 50}\nviews:\n  - {name: room, files: '*.png', every: 70, poses: trajectory.log, "
      "intrinsics: [525, 525, 319.5, 239.5]}\n";
  const auto found = discover(archive, keys_of(text));
  ASSERT_TRUE(found.ok()) << found.error().text();
  ASSERT_EQ(found->scans.size(), 1u);
  EXPECT_EQ(found->scans[0].views.size(), 4u);
  const auto keys = what_from(*document::parse_yaml(text, "job.yaml"), "job.yaml");
  ASSERT_TRUE(keys.ok()) << keys.error().text();
  std::string mesh, record;
  for (const int threads : {1, 2, 7}) {
    const TempFolder folder;
    const ChunkLoop loop(threads);
    const CancelFlag cancel;
    NoProgress progress;
    const auto result = run_scan(archive, found->scans[0], *keys, folder.path(), {}, {loop, cancel}, progress);
    ASSERT_TRUE(result.ok()) << result.error().text();
    EXPECT_EQ(result->points_read, 4u * 640 * 480);
    EXPECT_GT(result->triangles, 5000u);
    if (threads == 1) mesh = folder.read("mesh.stl"), record = folder.read("record.h5");
    EXPECT_EQ(folder.read("mesh.stl"), mesh) << threads;
    EXPECT_EQ(folder.read("record.h5"), record) << threads;
  }
}

}  // namespace
}  // namespace scanmill::pipeline
