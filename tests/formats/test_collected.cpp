// SPDX-License-Identifier: Apache-2.0
// Every collected file of these formats against counts and boxes that another program read from it (facts.tsv).
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>

#include "formats/png.hpp"
#include "formats/poses.hpp"
#include "formats/probe.hpp"
#include "read_whole.hpp"
#include "store/files.hpp"
#include "support/temp_folder.hpp"

namespace scanmill::formats {
namespace {

struct Fact {
  std::string path, text;
};

std::vector<Fact> facts(const std::string& data) {
  std::vector<Fact> all;
  std::ifstream file(data + "/facts.tsv");
  for (std::string line; std::getline(file, line);) {
    const auto last = line.rfind('\t');
    if (last != std::string::npos) all.push_back({line.substr(0, line.find('\t')), line.substr(last + 1)});
  }
  return all;
}

/// The first `count` numbers behind a phrase; none where the phrase is not there.
std::vector<double> numbers(const std::string& text, const std::string& phrase, std::size_t count) {
  std::vector<double> found;
  const auto at = text.find(phrase);
  if (at == std::string::npos) return found;
  for (const char* p = text.c_str() + at + phrase.size(); *p != 0 && found.size() < count;) {
    char* end = nullptr;
    const double value = std::strtod(p, &end);
    if (end != p) found.push_back(value);
    p = end != p ? end : p + 1;
    if (p[0] == '.' && p[1] == '.') p += 2;  // "(low)..(high)"
  }
  return found;
}

Bounds bounds_of(const std::vector<Whole>& scans) {
  Bounds bounds;
  for (const Whole& scan : scans)
    for (const Vec3 p : scan.positions) bounds.add(p);
  return bounds;
}

TEST(CollectedFiles, HoldWhatAnotherProgramCounted) {
  const std::string data = support::data_folder();
  if (data.empty()) GTEST_SKIP() << "no development data";
  std::size_t files = 0, boxes = 0;
  for (const auto& [path, text] : facts(data)) {
    const std::string suffix = suffix_of(path);
    if (path.starts_with("broken") || (suffix != "pcd" && suffix != "las" && suffix != "pts")) continue;
    const auto scans = read_scans(*store::open_file(data + "/" + path, path));
    ASSERT_TRUE(scans.ok()) << scans.error().text();
    ASSERT_EQ(scans->size(), 1u);
    const Whole& whole = scans->front();
    const auto count = numbers(text, suffix == "pcd" ? "POINTS " : suffix == "las" ? "points " : "count line ", 1);
    ASSERT_EQ(count.size(), 1u) << text;
    EXPECT_EQ(static_cast<double>(whole.points_read), count[0]) << path;
    if (const auto at = text.find(" non-finite"); at != std::string::npos) {
      const auto blank = text.rfind(' ', at - 1);
      EXPECT_EQ(std::to_string(whole.not_finite), text.substr(blank + 1, at - blank - 1)) << path;
    } else {
      EXPECT_EQ(whole.not_finite, 0u) << path;
    }
    ++files;
    const auto box = numbers(text, "box (", 6);
    if (box.empty() || whole.sensor_invalid > 0) continue;
    ++boxes;
    const Bounds bounds = bounds_of(*scans);
    const double found[] = {bounds.low.x, bounds.low.y, bounds.low.z, bounds.high.x, bounds.high.y, bounds.high.z};
    for (std::size_t i = 0; i < 6; ++i)
      EXPECT_NEAR(found[i], box[i], 1e-9 * (1 + std::abs(box[i]))) << path << " " << i;
  }
  EXPECT_GE(files, 55u);
  EXPECT_GE(boxes, 40u);
}

TEST(CollectedFiles, OfOneCloudAgreeInEveryFormat) {
  const std::string data = support::data_folder();
  if (data.empty()) GTEST_SKIP() << "no development data";
  const std::string folder = data + "/formats/same-cloud-A/";
  const auto ptx = read_scans(*store::open_file(folder + "1.2-with-color.ptx", "a.ptx"));
  ASSERT_TRUE(ptx.ok()) << ptx.error().text();
  EXPECT_EQ(ptx->front().positions.size(), 1065u);
  for (const char* name : {"1.2-with-color.las", "simple.las"}) {
    const auto las = read_whole(*store::open_file(folder + name, name));
    ASSERT_TRUE(las.ok()) << las.error().text();
    ASSERT_EQ(las->positions.size(), 1065u);
    for (std::size_t i = 0; i < 1065; ++i) {
      EXPECT_LT(norm(las->positions[i] - ptx->front().positions[i]), 1e-8) << name << " " << i;
      EXPECT_EQ(ptx->front().rows[i], las->rows[i] + 11);  // ten lines of header
    }
  }
}

TEST(CollectedFiles, OfSeveralScansArePosed) {
  const std::string data = support::data_folder();
  if (data.empty()) GTEST_SKIP() << "no development data";
  const std::string name = "multiple-and-transform.ptx";
  const auto scans = read_scans(*store::open_file(data + "/formats/ptx/" + name, name));
  ASSERT_TRUE(scans.ok()) << scans.error().text();
  ASSERT_EQ(scans->size(), 2u);
  // Both hold the same four points of the sample cloud, the first in a frame that is scaled and shifted.
  ASSERT_EQ((*scans)[0].positions.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT(norm((*scans)[0].positions[i] - (*scans)[1].positions[i]), 0.02) << i;
  const std::string cells = "complex-transform.ptx";
  const auto one = read_scans(*store::open_file(data + "/formats/ptx/" + cells, cells));
  ASSERT_TRUE(one.ok()) << one.error().text();
  EXPECT_EQ(one->front().positions.size(), 4u);
  EXPECT_EQ(one->front().sensor_invalid, 8u);
  EXPECT_NEAR(one->front().header.pose.translation.x, -3.028748, 1e-12);
}

TEST(CollectedFiles, OfDepthCoverTheSameRoom) {
  const std::string data = support::data_folder();
  if (data.empty()) GTEST_SKIP() << "no development data";
  const std::string folder = data + "/range-views/livingroom-depth/";
  const auto poses = read_poses(**store::open_file(folder + "trajectory.log", "trajectory.log"));
  ASSERT_TRUE(poses.ok()) << poses.error().text();
  ASSERT_EQ(poses->size(), 211u);
  const OpenOptions camera{Format::Auto, DepthCamera{525, 525, 319.5, 239.5, 1000}};
  using Voxel = std::array<long, 3>;
  auto voxels = [&](const std::string& name, const Pose& pose) {
    const auto whole = read_whole(*store::open_file(folder + name, name), camera);
    EXPECT_TRUE(whole.ok()) << whole.error().text();
    EXPECT_EQ(whole->points_read, 640u * 480u);
    std::vector<Voxel> all;
    for (const Vec3 p : whole->positions) {
      const Vec3 q = pose.apply(p) * 50;  // 2 cm
      all.push_back({std::lround(std::floor(q.x)), std::lround(std::floor(q.y)), std::lround(std::floor(q.z))});
    }
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  };
  auto shared = [](const std::vector<Voxel>& a, const std::vector<Voxel>& b) {
    std::vector<Voxel> both;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
    return static_cast<double>(both.size()) / static_cast<double>(std::min(a.size(), b.size()));
  };
  const auto a = voxels("00000.png", (*poses)[0].pose), b = voxels("00060.png", (*poses)[60].pose);
  EXPECT_GT(shared(a, b), 0.4);
  EXPECT_LT(shared(a, voxels("00060.png", Pose{})), 0.1);
}

}  // namespace
}  // namespace scanmill::formats
