// SPDX-License-Identifier: Apache-2.0
// Cuts through shapes whose sections are known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "verify/meshes.hpp"
#include "verify/sections.hpp"

namespace scanmill::verify {
namespace {

/// A box of the given half size, outward; `open`: without its lid (+z).
Mesh box(Vec3 h, bool open = false) {
  Mesh mesh;
  for (int n = 0; n < 8; ++n) mesh.positions.push_back({n & 1 ? h.x : -h.x, n & 2 ? h.y : -h.y, n & 4 ? h.z : -h.z});
  const std::uint32_t quads[6][4] = {{0, 2, 3, 1}, {0, 1, 5, 4}, {1, 3, 7, 5},
                                     {3, 2, 6, 7}, {2, 0, 4, 6}, {4, 5, 7, 6}};
  for (int q = 0; q < (open ? 5 : 6); ++q) {
    mesh.triangles.push_back({quads[q][0], quads[q][1], quads[q][2]});
    mesh.triangles.push_back({quads[q][0], quads[q][2], quads[q][3]});
  }
  return mesh;
}

std::vector<SectionFrame> frames_of(const Mesh& mesh, const std::vector<SectionRule>& rules, double slab = 1) {
  std::vector<double> magnify;
  auto frames = section_frames(mesh, rules, slab, {}, magnify);
  EXPECT_TRUE(frames.ok());
  return frames.ok() ? *frames : std::vector<SectionFrame>{};
}

SectionRule at(Vec3 axis, double place) {
  SectionRule rule;
  rule.axis = axis;
  rule.where = SectionRule::Where::At;
  rule.at_mm = place;
  return rule;
}

double signed_area(const SectionLine& line) {
  double area = 0;
  for (std::size_t n = 0; n < line.points.size(); ++n) {
    const Uv a = line.points[n], b = line.points[(n + 1) % line.points.size()];
    area += (a.u * b.v - a.v * b.u) / 2;
  }
  return area;
}

TEST(Cut, GivesTheOutlineWithTheMaterialOnTheLeft) {
  const Mesh mesh = box({3, 2, 1});
  const struct {
    Vec3 axis;
    double area;
  } cases[] = {{{1, 0, 0}, 8}, {{0, 1, 0}, 12}, {{0, 0, 1}, 24}, {{0, 0, -5}, 24}};
  for (const auto& [axis, area] : cases) {
    const auto lines = cut(mesh, frames_of(mesh, {at(axis, 0.25)})[0]);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_TRUE(lines[0].closed);
    EXPECT_NEAR(signed_area(lines[0]), area, 1e-12);
  }
}

TEST(Cut, FramesAreRightHandedAndPlacesComeBack) {
  const Mesh mesh = box({3, 2, 1});
  for (const Vec3 axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{1, 2, -3}}) {
    const SectionFrame frame = frames_of(mesh, {at(axis, 0.5)})[0];
    EXPECT_NEAR(norm(cross(frame.right, frame.up) - frame.normal), 0, 1e-12);
    EXPECT_NEAR(dot(frame.origin, frame.normal), 0.5, 1e-12);
    const Vec3 p = frame.place({1.5, -2});
    EXPECT_NEAR(dot(p, frame.normal), 0.5, 1e-12);
    EXPECT_NEAR(frame.at(p).u, 1.5, 1e-12);
    EXPECT_NEAR(frame.at(p).v, -2, 1e-12);
  }
  EXPECT_EQ(frames_of(mesh, {at({0, 1, 0}, -2.5)})[0].name, "y = -2.5 mm");
}

TEST(Cut, OfAnOpenMeshIsOpenAndAMissIsEmpty) {
  const Mesh mesh = box({3, 2, 1}, true);
  const auto lines = cut(mesh, frames_of(mesh, {at({1, 0, 0}, 0.3)})[0]);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_FALSE(lines[0].closed);
  double length = 0;
  for (std::size_t n = 0; n + 1 < lines[0].points.size(); ++n)
    length +=
        std::hypot(lines[0].points[n + 1].u - lines[0].points[n].u, lines[0].points[n + 1].v - lines[0].points[n].v);
  EXPECT_NEAR(length, 2 + 4 + 2, 1e-12);
  EXPECT_TRUE(cut(mesh, frames_of(mesh, {at({1, 0, 0}, 3.5)})[0]).empty());
}

TEST(Cut, ThroughVerticesAndFacesIsStillClosed) {
  const Mesh mesh = box({2, 2, 2});
  for (const Vec3 axis : {Vec3{1, 1, 0}, Vec3{1, 1, 1}, Vec3{0, 0, 1}})
    for (const double place : {0.0, -2.0, 2.0, 1.0})
      for (const SectionLine& line : cut(mesh, frames_of(mesh, {at(axis, place)})[0]))
        EXPECT_TRUE(line.closed) << axis.x << axis.y << axis.z << " at " << place;
}

TEST(Sections, AddsTheOffsetOfTheMesh) {
  Mesh mesh = box({3, 2, 1});
  mesh.offset = {1000, 0, 0};
  const SectionFrame frame = frames_of(mesh, {at({1, 0, 0}, 1001)})[0];
  const auto lines = cut(mesh, frame);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(frame.place(lines[0].points[0]).x, 1001);
}

TEST(Sections, SpreadEvenlyThroughTheMesh) {
  const Mesh mesh = box({3, 2, 1});
  SectionRule rule;
  rule.axis = {2, 0, 0};
  rule.where = SectionRule::Where::Count;
  rule.count = 2;
  const auto frames = frames_of(mesh, {rule});
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].name, "x = -1 mm");
  EXPECT_EQ(frames[1].name, "x = 1 mm");
  rule.count = 101;
  std::vector<double> magnify;
  EXPECT_EQ(section_frames(mesh, std::vector{rule}, 1, {}, magnify).error().code, Code::BadParameter);
  rule.where = SectionRule::Where::Loop;
  EXPECT_TRUE(section_frames(mesh, std::vector{rule}, 1, {}, magnify)->empty());
}

/// Points on the walls x = +-3 at y = 0, pushed out or in.
Section judged(const std::vector<Vec3>& points, const Mesh& mesh, double slab = 1, int threads = 1) {
  const ChunkLoop loop(threads);
  const CancelFlag cancel;
  const auto frames = frames_of(mesh, {at({0, 0, 1}, 0)}, slab);
  const double magnify[] = {0};
  const auto sections = sections_of(mesh, MemoryPoints(points, {}, 7), frames, magnify, 1, {loop, cancel});
  EXPECT_TRUE(sections.ok()) << sections.error().text();
  return sections->at(0);
}

TEST(Sections, MeasureThePointsOfTheSlabAndMarkTheWorst) {
  const Mesh mesh = box({3, 2, 1});
  const Section section = judged({{3.1, 0, 0}, {2.8, 0, 0.4}, {-3.05, 0.5, -0.5}, {9, 9, 0.51}, {9, 9, -0.6}}, mesh);
  EXPECT_EQ(section.points_in_slab, 3u);
  ASSERT_TRUE(section.worst);
  EXPECT_EQ(section.worst->source.row, 1u);
  EXPECT_NEAR(section.worst->signed_mm, -0.2, 1e-12);
  EXPECT_NEAR(section.max_mm, 0.2, 1e-12);
  EXPECT_NEAR(section.rms_mm, std::sqrt((0.01 + 0.04 + 0.0025) / 3), 1e-6);
  ASSERT_EQ(section.points.size(), 3u);
  const SectionPoint& first = section.points[0];
  EXPECT_TRUE(first.has_foot);
  EXPECT_NEAR(first.foot.u, 3, 1e-12);
  EXPECT_NEAR(first.outward.u, 1, 1e-12);
  EXPECT_NEAR(section.points[2].outward.u, -1, 1e-12);
  EXPECT_EQ(section.magnify, 2) << "0.2 mm of 6 mm is drawn as at most 15 %";
}

TEST(Sections, KeepPointsBeyondOpenEdgesApart) {
  const Mesh mesh = box({3, 2, 1}, true);
  const ChunkLoop loop(1);
  const CancelFlag cancel;
  const auto frames = frames_of(mesh, {at({0, 1, 0}, 0)});
  const double magnify[] = {3};
  const auto sections = sections_of(mesh, MemoryPoints({{3, 0, 1.7}, {3.1, 0, 0}}), frames, magnify, 1, {loop, cancel});
  ASSERT_TRUE(sections.ok());
  const Section& section = sections->at(0);
  EXPECT_EQ(section.points_in_slab, 2u);
  EXPECT_EQ(section.points_at_open_border, 1u);
  EXPECT_NEAR(section.max_mm, 0.1, 1e-12);
  EXPECT_FALSE(section.points[0].has_foot);
  EXPECT_EQ(section.magnify, 3);
}

TEST(Sections, SampleTheSamePointsForAnyThreads) {
  const Mesh mesh = box({3, 2, 1});
  std::vector<Vec3> points;
  for (int n = 0; n < 20000; ++n) {
    const double turn = n * 0.001;
    points.push_back({3 + 0.1 * std::sin(37 * turn), -2 + std::fmod(turn, 4.0), 0.4 * std::cos(11 * turn)});
  }
  const Section one = judged(points, mesh, 1, 1);
  EXPECT_EQ(one.points_in_slab, 20000u);
  EXPECT_EQ(one.points.size(), kSectionPoints);
  for (const int threads : {2, 7}) {
    const Section other = judged(points, mesh, 1, threads);
    ASSERT_EQ(other.points.size(), one.points.size());
    for (std::size_t n = 0; n < one.points.size(); ++n) ASSERT_EQ(other.points[n].source, one.points[n].source);
    EXPECT_EQ(other.rms_mm, one.rms_mm);
    EXPECT_EQ(other.worst->source, one.worst->source);
  }
  std::size_t low = 0;
  for (const SectionPoint& point : one.points) low += point.source.row < 10000;
  EXPECT_NEAR(static_cast<double>(low), 2000, 150) << "a fair sample";
}

}  // namespace
}  // namespace scanmill::verify
