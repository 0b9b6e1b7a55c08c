// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "pipeline/hash_cache.hpp"
#include "pipeline/what.hpp"

namespace scanmill::pipeline {
namespace {

Result<What> what(const std::string& text) { return what_from(*document::parse_yaml(text, "job.yaml"), "job.yaml"); }

std::string error_of(const std::string& text) {
  const auto result = what(text);
  return result ? "no error" : result.error().text();
}

TEST(WhatFrom, BinSizeAloneIsEnough) {
  const auto w = what("lattice: {bin_mm: 0.5}\nscanmill: 1\narchive: elsewhere\n");
  ASSERT_TRUE(w.ok()) << w.error().text();
  EXPECT_EQ(w->lattice.bin_mm, 0.5);
  EXPECT_EQ(w->reduce.representative, reduce::Representative::Surface);
  EXPECT_EQ(w->grow.range_bins, 2.5);
  EXPECT_EQ(w->outputs, (std::vector<Output>{{"stl", false}}));
}

TEST(WhatFrom, ProfilePaperSetsItsRulesAndSingleKeysOverride) {
  const auto paper = what("profile: paper\nlattice: {bin_mm: 1}\n");
  ASSERT_TRUE(paper.ok()) << paper.error().text();
  EXPECT_EQ(paper->reduce.representative, reduce::Representative::Centre);
  EXPECT_EQ(paper->reduce.min_neighbour_distance, 0.5);
  EXPECT_EQ(paper->reduce.neighbour_positions, reduce::NeighbourPositions::Measured);
  EXPECT_EQ(paper->grow.range_bins, 2);
  EXPECT_EQ(paper->lattice.origin, reduce::Origin::Bounds);
  const auto mixed = what(
      "grow: {range_bins: 2.2}\nreduce: {min_neighbour_distance: off}\nlattice: {bin_mm: 1, origin: "
      "absolute}\nprofile: paper\n");
  ASSERT_TRUE(mixed.ok()) << mixed.error().text();
  EXPECT_EQ(mixed->grow.range_bins, 2.2);
  EXPECT_FALSE(mixed->reduce.min_neighbour_distance.has_value());
  EXPECT_EQ(mixed->lattice.origin, reduce::Origin::Absolute);
}

TEST(WhatFrom, ReportsEveryProblemWithPlaceAllowedAndNearest) {
  const std::string text = error_of(
      "lattice:\n  bin_m: 1\ngrow: {range_bins: 2.6, engine: star, min_angle_deg: five}\nunits: mn\nprofile: papr\n"
      "outputs: [step, stll]\nreduce: 7\nmerge: {fill_holes_up_to_bins: 2}\n");
  for (const char* line :
       {"job.yaml:2:3: lattice.bin_m: unknown key; allowed bin_mm, target_points, target_bins, origin; nearest bin_mm",
        "job.yaml:2:3: lattice: found no bin size", "job.yaml:3:20: grow.range_bins: found 2.6; allowed (0, 2.5]",
        "grow.engine: found star; allowed stars, front; nearest stars",
        "grow.min_angle_deg: found five; allowed a number in [0, 45]",
        "job.yaml:4:8: units: found mn; allowed mm, cm, m, um, in; nearest mm",
        "profile: found papr; allowed scan, paper; nearest paper",
        "outputs: found step; allowed stl, ply, obj, iges, dxf, 3mf, vdb",
        "outputs: found stll; allowed stl, ply, obj, iges, dxf, 3mf, vdb; nearest stl",
        "reduce: found 7; allowed a map of representative", "merge.fill_holes_up_to_bins: not in this version"})
    EXPECT_NE(text.find(line), std::string::npos) << line << "\nin\n" << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 10) << text;
}

TEST(WhatFrom, PreviewsAreThoseAskedForInTheReportsOrder) {
  using List = std::vector<std::string>;
  EXPECT_EQ(what("lattice: {bin_mm: 1}\n")->previews, (List{"shaded", "error", "patches"}));
  EXPECT_EQ(what("lattice: {bin_mm: 1}\npreviews: [patches, shaded, patches]\n")->previews,
            (List{"shaded", "patches"}));
  for (const char* text : {"previews: []\n", "previews: [shadow]\n", "previews: shaded\n"})
    EXPECT_NE(error_of(text).find("allowed a list of shaded, error, patches, one at least"), std::string::npos) << text;
}

TEST(WhatFrom, NamesTheSlipsOfNumbers) {
  EXPECT_NE(error_of("lattice:\n  bin_mm: 1,5\n").find("; decimals take a point: 1.5"), std::string::npos);
  EXPECT_NE(error_of("lattice: {bin_mm: 1,5}\n").find("lattice.5: unknown key"), std::string::npos);
  EXPECT_NE(error_of("lattice: {bin_mm: 1,5}\n").find("Decimals take a point"), std::string::npos);
  for (const char* text : {"lattice: {bin_mm: 1mm}\n", "lattice: {bin_mm: 1 mm}\n"})
    EXPECT_NE(error_of(text).find("; the key's name says the unit, give the number alone: 1"), std::string::npos);
  EXPECT_EQ(error_of("lattice: {bin_mm: one}\n").find(";", error_of("lattice: {bin_mm: one}\n").find("off")),
            std::string::npos);
}

TEST(WhatFrom, BinSizesAndNormalLimitsExcludeEachOther) {
  EXPECT_NE(error_of("lattice: {bin_mm: 1, target_points: 100}\n").find("exclude each other"), std::string::npos);
  EXPECT_NE(
      error_of("lattice: {bin_mm: 1}\ngrow: {min_normal_dot: 0.5, max_normal_deg: 30}\n").find("exclude each other"),
      std::string::npos);
  EXPECT_TRUE(what("lattice: {bin_mm: off, target_bins: 3000}\n").ok());
  EXPECT_TRUE(what_from(document::Node::map(), "x", false).ok());
}

TEST(WhatFrom, OutputsTakeTheirStyleAndKeepIt) {
  const auto w = what("lattice: {bin_mm: 1}\noutputs: [stl, {iges: {style: wire}}]\n");
  ASSERT_TRUE(w.ok()) << w.error().text();
  EXPECT_EQ(w->outputs, (std::vector<Output>{{"stl", false, ""}, {"iges", false, "wire"}}));
  EXPECT_EQ(file_name_of(w->outputs[1]), "mesh.igs");
  const std::string tree = document::to_canonical_json(to_document(*w));
  EXPECT_NE(tree.find(R"("outputs":["stl",{"iges":{"style":"wire"}}])"), std::string::npos) << tree;
  EXPECT_EQ(what("lattice: {bin_mm: 1}\noutputs: [iges]\n")->outputs[0].style, "brep") << "the default is written out";
  const std::string text =
      error_of("lattice: {bin_mm: 1}\noutputs: [{iges: {style: brp}}, {iges: {stile: wire}}, {ply: {style: brep}}]\n");
  for (const char* line :
       {"outputs.iges.style: found brp; allowed brep, trimmed, patches, wire, surfaces; nearest brep",
        "outputs.iges.stile: unknown key; allowed style, tolerance_bins; nearest style",
        "outputs: found options for ply; it takes none", "iges is asked for twice"})
    EXPECT_NE(text.find(line), std::string::npos) << line << "\nin\n" << text;
}

TEST(WhatFrom, SurfacesTakeATolerance) {
  const auto w = what("lattice: {bin_mm: 1}\noutputs: [{iges: {style: surfaces}}]\n");
  ASSERT_TRUE(w.ok()) << w.error().text();
  EXPECT_EQ(w->outputs[0].tolerance_bins, 0.25);
  const auto wide = what("lattice: {bin_mm: 1}\noutputs: [{iges: {tolerance_bins: 0.5, style: surfaces}}]\n");
  ASSERT_TRUE(wide.ok()) << wide.error().text();
  EXPECT_EQ(wide->outputs[0].tolerance_bins, 0.5);
  const std::string tree = document::to_canonical_json(to_document(*wide));
  EXPECT_NE(tree.find(R"({"style":"surfaces","tolerance_bins":0.5})"), std::string::npos) << tree;
  EXPECT_NE(error_of("lattice: {bin_mm: 1}\noutputs: [{iges: {style: surfaces, tolerance_bins: 0}}]\n")
                .find("outputs.iges.tolerance_bins: found 0; allowed 0.001 to 10 bin edges"),
            std::string::npos);
  EXPECT_NE(error_of("lattice: {bin_mm: 1}\noutputs: [{iges: {tolerance_bins: 1}}]\n").find("found style brep"),
            std::string::npos);
}

TEST(WhatFrom, SectionsComeByPlaceCountAndFeature) {
  const auto w = what(
      "lattice: {bin_mm: 1}\nverify:\n  rms_mm: 2\n  sections:\n    - {axis: y, at_mm: -1.5, name: side}\n"
      "    - {axis: x, count: 3, slab_mm: 0.5}\n    - {axis: [1, 1, 0], through: worst, magnify: 20}\n"
      "    - {axis: z, through: [1, 2, 3]}\n");
  ASSERT_TRUE(w.ok()) << w.error().text();
  ASSERT_EQ(w->verify.sections.size(), 4u);
  EXPECT_EQ(w->verify.sections[0].at_mm, -1.5);
  EXPECT_EQ(w->verify.sections[1].count, 3);
  EXPECT_EQ(w->verify.sections[3].point, (Vec3{1, 2, 3}));
  const std::string tree = document::to_canonical_json(to_document(*w));
  const auto again = what_from(document::parse_yaml(tree, "again").value(), "again");
  ASSERT_TRUE(again.ok()) << again.error().text();
  EXPECT_EQ(again->verify.sections, w->verify.sections) << tree;
  EXPECT_EQ(what("lattice: {bin_mm: 1}\nverify: {sections: {axis: z, count: 2}}\n")->verify.sections.size(), 1u);
  EXPECT_TRUE(what("lattice: {bin_mm: 1}\nverify: {sections: off}\n")->verify.sections.empty());
  const std::string text = error_of(
      "lattice: {bin_mm: 1}\nverify:\n  sections:\n    - {axis: w, count: 2}\n    - {axis: x}\n    - {count: 101, "
      "axis: x}\n"
      "    - {axis: z, through: wurst}\n    - {axis: z, at_mm: 1, count: 1, slab: 3}\n");
  for (const char* line :
       {"job.yaml:4:14: verify.sections[0].axis: found w; allowed x, y, z, a direction",
        "verify.sections[1]: found no place", "verify.sections[2].count: found 101; allowed whole numbers in [1, 100]",
        "verify.sections[3].through: found wurst; allowed worst, loop, a point [x, y, z] in mm; nearest worst",
        "verify.sections[4]: found more than one place", "verify.sections[4].slab: unknown key", "nearest slab_mm"})
    EXPECT_NE(text.find(line), std::string::npos) << line << "\nin\n" << text;
}

TEST(WhatFrom, SeedsComeInThreeForms) {
  EXPECT_TRUE(what("lattice: {bin_mm: 1}\nseeds: auto\n")->seeds.points.empty());
  const auto list = what("lattice: {bin_mm: 1}\nseeds: [[1, 2, 3], [4, 5, 6]]\n");
  ASSERT_TRUE(list.ok()) << list.error().text();
  EXPECT_EQ(list->seeds.points[1], (Vec3{4, 5, 6}));
  const auto map = what("lattice: {bin_mm: 1}\nseeds: {points: [[1, 2, 3]], cover: false, spacing_bins: 9}\n");
  ASSERT_TRUE(map.ok()) << map.error().text();
  EXPECT_FALSE(map->seeds.cover);
  EXPECT_EQ(map->seeds.spacing_bins, 9);
  for (const char* bad : {"seeds: many", "seeds: [1, 2, 3]", "seeds: [[1, 2]]", "seeds: {point: auto}", "seeds: []"})
    EXPECT_NE(error_of(std::string("lattice: {bin_mm: 1}\n") + bad + "\n").find("seeds"), std::string::npos) << bad;
}

TEST(WhatFrom, CleanRulesAreRead) {
  const auto w = what(
      "lattice: {bin_mm: 1}\nclean:\n  keep_box: {min: [0, 0, -1], max: [1, 2.5, 3]}\n"
      "  remove_box: [{min: [0, 0, 0], max: [1, 1, 1]}, {min: [2, 2, 2], max: [3, 3, 3]}]\n"
      "  remove_plane: {fit: true, distance_mm: 0.3, below: true}\n"
      "  outliers: {statistical: {neighbours: 5}, min_component_share: 0.01, component_range_bins: 2}\n");
  ASSERT_TRUE(w.ok()) << w.error().text();
  EXPECT_EQ(w->clean.keep_box->high, (Vec3{1, 2.5, 3}));
  EXPECT_EQ(w->clean.remove_box.size(), 2u);
  EXPECT_TRUE(w->clean.remove_plane->fit && w->clean.remove_plane->below);
  EXPECT_EQ(w->clean.outliers->statistical->neighbours, 5);
  EXPECT_EQ(w->clean.outliers->statistical->deviations, 3);
  EXPECT_EQ(w->clean.outliers->min_component_share, 0.01);
  EXPECT_TRUE(w->clean.problems().empty()) << w->clean.problems()[0];
  const auto one_box = what("lattice: {bin_mm: 1}\nclean: {remove_box: {min: [0, 0, 0], max: [1, 1, 1]}}\n");
  ASSERT_TRUE(one_box.ok()) << one_box.error().text();
  EXPECT_EQ(one_box->clean.remove_box.size(), 1u);
  const auto off = what("lattice: {bin_mm: 1}\nclean: {keep_box: off, remove_box: off, outliers: off}\n");
  ASSERT_TRUE(off.ok()) << off.error().text();
  EXPECT_FALSE(off->clean.any());
}

TEST(WhatFrom, CleanRulesNameEveryMistakeWithItsPlace) {
  const std::string text = error_of(
      "lattice: {target_bins: 100}\nclean:\n  keep_bx: 1\n  keep_box: {min: [0, 0], max: [1, 1, 1]}\n"
      "  remove_box: [{min: [0, 0, 0]}, {min: [2, 0, 0], max: [1, 1, 1]}, 5]\n"
      "  remove_plane: {normal: [0, 0, 0], distanc_mm: 1, min_share: 2}\n"
      "  outliers: {neighbours: 3}\n");
  for (const char* line :
       {"job.yaml:3:3: clean.keep_bx: unknown key; allowed keep_box, remove_box, remove_plane, outliers; nearest "
        "keep_box",
        "job.yaml:4:19: clean.keep_box.min: found a list; allowed three numbers [x, y, z] in mm",
        "clean.remove_box[0]: found no max", "clean.remove_box[1]: found a min that is not below max on each axis",
        "clean.remove_box[2]: found 5; allowed a map of min, max", "clean.remove_plane.normal: found a zero vector",
        "clean.remove_plane.distanc_mm: unknown key", "nearest distance_mm",
        "clean.remove_plane: found no distance_mm; it must be given",
        "clean.remove_plane: found no plane; wanted fit: true", "clean.remove_plane.min_share: found 2; allowed [0, 1]",
        "clean.outliers.neighbours: unknown key", "clean.outliers: found no rule",
        "clean.outliers: found no bin edge; give clean.outliers.bin_mm"})
    EXPECT_NE(text.find(line), std::string::npos) << line << "\nin\n" << text;
  EXPECT_NE(error_of("lattice: {bin_mm: 1}\nclean: {remove_plane: {fit: true, point: [0, 0, 0], distance_mm: 1}}\n")
                .find("exclude each other"),
            std::string::npos);
}

TEST(CheckPart, TakesCleanRulesThatAreNotWhole) {
  document::Problems problems("job.yaml");
  check_part(*document::parse_yaml("clean: {keep_box: {min: [0, 0, 0]}, remove_plane: {distance_mm: 2}, outliers: "
                                   "{bin_mm: 2}}\n",
                                   "job.yaml"),
             problems);
  EXPECT_TRUE(problems.empty()) << problems.error().text();
  check_part(*document::parse_yaml("clean: {remove_plane: {distance_mm: -2}}\n", "job.yaml"), problems);
  EXPECT_FALSE(problems.empty());
}

TEST(OverlayWhat, KeyTakesThePlaceOfThoseItExcludes) {
  const auto base =
      *document::parse_yaml("lattice: {bin_mm: 1, origin: bounds}\ngrow: {max_normal_deg: 20}\nseeds: auto\n", "x");
  const auto over =
      *document::parse_yaml("lattice: {target_points: 500}\ngrow: {min_normal_dot: 0.9}\nseeds: {cover: false}\n", "x");
  const auto w = what_from(overlay_what(base, over), "x");
  ASSERT_TRUE(w.ok()) << w.error().text();
  EXPECT_FALSE(w->lattice.bin_mm.has_value());
  EXPECT_EQ(w->lattice.origin, reduce::Origin::Bounds);
  EXPECT_FALSE(w->grow.max_normal_deg.has_value());
  EXPECT_FALSE(w->seeds.cover);
}

TEST(ToDocument, ReadsBackToTheSameCanonicalText) {
  for (const char* text :
       {"lattice: {bin_mm: 0.36}\n",
        "profile: paper\nlattice: {target_points: 3000}\nseeds: [[1, 2.5, -3]]\nunits: m\n",
        "lattice: {bin_mm: 1}\nclean: {keep_box: {min: [0, 0, 0], max: [1, 1, 1]}, remove_box: {min: [0, 0, 0], max: "
        "[1, "
        "1, 1]}, remove_plane: {point: [0, 0, 0], normal: [0, 0, 1], distance_mm: 0.5}, outliers: {statistical: {}, "
        "min_component_points: 9}}\n",
        "lattice: {bin_mm: 1}\ngrow: {max_normal_deg: 30, engine: front}\nreduce: {min_neighbour_distance: off}\n"}) {
    const auto first = what(text);
    ASSERT_TRUE(first.ok()) << first.error().text();
    const std::string canonical = document::to_canonical_json(to_document(*first));
    const auto again = what_from(*document::parse_json(canonical, "x"), "x");
    ASSERT_TRUE(again.ok()) << again.error().text();
    EXPECT_EQ(document::to_canonical_json(to_document(*again)), canonical);
  }
}

TEST(HashCache, TrustsSettledFilesOnly) {
  const std::string path = testing::TempDir() + "scanmill-hash-" + std::to_string(::getpid());
  std::ofstream(path) << "one";
  HashCache cache;
  const auto fresh = cache.entry_of(path, "file");
  ASSERT_TRUE(fresh.ok()) << fresh.error().text();
  EXPECT_FALSE(fresh->trusted);
  EXPECT_EQ(cache.save(), "{}\n");
  const std::string saved = "{\"" + path + "\": [" + std::to_string(fresh->stamp.size) + ", " +
                            std::to_string(fresh->stamp.mtime_ns) + ", " + std::to_string(fresh->stamp.inode) +
                            ", \"remembered\"]}";
  HashCache loaded;
  loaded.load(saved);
  EXPECT_EQ(loaded.entry_of(path, "file")->sha256, "remembered");
  std::ofstream(path) << "other";
  EXPECT_NE(loaded.entry_of(path, "file")->sha256, "remembered");
  loaded.load("not json");
  ::unlink(path.c_str());
  EXPECT_FALSE(loaded.entry_of(path, "file").ok());
}

}  // namespace
}  // namespace scanmill::pipeline
