// SPDX-License-Identifier: Apache-2.0
// The first job runs as it stands, for every scan of the archive.
#include <gtest/gtest.h>

#include "base/text.hpp"
#include "pipeline/init_depth.hpp"
#include "pipeline/init_job.hpp"
#include "pipeline/run_scan.hpp"
#include "store/files.hpp"
#include "support/meshing.hpp"
#include "support/shapes.hpp"
#include "support/temp_folder.hpp"

namespace scanmill::pipeline {
namespace {

std::string text_of(const std::vector<Vec3>& points, double scale) {
  std::string text;
  for (const Vec3& p : points)
    text += number_text(p.x * scale) + " " + number_text(p.y * scale) + " " + number_text(p.z * scale) + "\n";
  return text;
}

/// The keys of one scan as the job and its overrides say them; init writes no wildcards.
Result<What> what_of_scan(const document::Node& job, const std::string& name) {
  document::Node what = document::Node::map();
  const auto take = [&](const document::Node& from) {
    for (const char* key : {"units", "lattice"})
      if (const document::Node* value = from.find(key)) what.set(key, *value);
  };
  take(job);
  if (const document::Node* overrides = job.find("overrides"))
    for (const document::Node& row : overrides->items())
      if (row.find("scans")->as_string() == name) take(row);
  return what_from(what, "job.yaml");
}

TEST(FirstJob, RunsForEveryScanAndMeshesIt) {
  const support::TempFolder folder;
  folder.write("archive/cube.xyz", text_of(support::box_points({0, 0, 0}, {60, 60, 60}, 12000, 3), 1));
  folder.write("archive/large.xyz", text_of(support::sphere_points({0, 0, 0}, 40, 4000, 5), 1));
  folder.write("archive/few.xyz", text_of(support::sphere_points({0, 0, 0}, 1000, 642, 7), 1));
  folder.write("archive/curved.xyz", text_of(support::sphere_points({0, 0, 0}, 0.5, 1400, 9), 1));
  const support::Workers workers(2);
  NoProgress progress;
  const auto job = first_job(folder.file("archive"), "archive", workers.context(), progress);
  ASSERT_TRUE(job.ok()) << job.error().text();
  EXPECT_NE(job->text.find("a building in metres"), std::string::npos);
  const auto tree = document::parse_yaml(job->text, "job.yaml");
  ASSERT_TRUE(tree.ok()) << tree.error().text();
  const auto found = discover(folder.file("archive"), false);
  ASSERT_TRUE(found.ok());
  ASSERT_EQ(found->scans.size(), 4u);
  for (const ScanSpec& scan : found->scans) {
    const auto what = what_of_scan(*tree, scan.name);
    ASSERT_TRUE(what.ok()) << what.error().text();
    std::filesystem::create_directories(folder.file(scan.name));
    const auto run =
        run_scan(folder.file("archive"), scan, *what, folder.file(scan.name), {}, workers.context(), progress);
    ASSERT_TRUE(run.ok()) << scan.name << ": " << run.error().text() << "\n" << job->text;
    EXPECT_GE(run->points_meshed * 10, run->points_used * 9) << scan.name << "\n" << job->text;
    EXPECT_GE(run->triangles, 100u) << scan.name;
  }
}

std::string matrices(int count) {
  std::string text;
  for (int k = 0; k < count; ++k) text += "1 0 0 " + std::to_string(k) + "\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  return text;
}

TEST(GuessDepthViews, TakesFoldersWithThePosesThatFit) {
  const support::TempFolder folder;
  folder.write("film/poses/few.txt", matrices(2));
  folder.write("film/t.txt", matrices(2));
  folder.write("film/u.txt", matrices(3));
  const std::vector<std::string> maps{"alone/1.png", "film/d/f01.png", "film/d/f02.png", "film/d/f03.png"};
  std::vector<std::string> all = maps;
  all.insert(all.end(), {"film/d/photo.png", "film/poses/few.txt", "film/t.txt", "film/u.txt"});
  const auto list = guess_depth_views(folder.file(""), maps, all);
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0].spec.name, "alone");
  EXPECT_EQ(list[0].spec.files, "alone/*.png");
  EXPECT_EQ(list[0].spec.poses, "");
  EXPECT_EQ(list[1].spec.name, "film/d");
  EXPECT_EQ(list[1].spec.files, "film/d/f0*.png");  // a photo lies there too
  EXPECT_EQ(list[1].spec.poses, "film/u.txt");
  EXPECT_EQ(list[1].spec.every, 1);
  const std::string text = "scanmill: 1\nlattice: {bin_mm: 1}\n" + views_text(list);
  const auto tree = document::parse_yaml(text, "job.yaml");
  ASSERT_TRUE(tree.ok()) << tree.error().text() << text;
}

TEST(GuessDepthViews, ThinsAFilmAndKnowsTheUsualCamera) {
  const std::string data = support::data_folder();
  if (data.empty()) GTEST_SKIP() << "no SCANMILL_DATA";
  const std::string archive = data + "/range-views/livingroom-depth";
  const auto found = discover(archive, false);
  ASSERT_TRUE(found.ok());
  const auto files = store::list_files(archive);
  ASSERT_TRUE(files.ok());
  const auto list = guess_depth_views(archive, found->depth_maps, *files);
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].spec.name, "livingroom-depth");
  EXPECT_EQ(list[0].spec.poses, "trajectory.log");
  EXPECT_EQ(list[0].spec.every, 5);
  EXPECT_EQ(list[0].spec.camera, (formats::DepthCamera{525, 525, 319.5, 239.5, 1000}));
  DiscoveryKeys keys;
  keys.views = {list[0].spec};
  const auto scans = discover(archive, keys);
  ASSERT_TRUE(scans.ok());
  ASSERT_EQ(scans->scans.size(), 1u);
  EXPECT_EQ(scans->scans[0].views.size(), 43u);
  EXPECT_EQ(scans->scans[0].broken, "");
}

}  // namespace
}  // namespace scanmill::pipeline
