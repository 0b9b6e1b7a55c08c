// SPDX-License-Identifier: Apache-2.0
#include "sample.hpp"

#include <iterator>

namespace scanmill::report {
namespace {

// A PNG of one white pixel; the pipeline puts the bytes of render::write_png here.
std::string one_pixel() {
  static constexpr unsigned char kBytes[] = {
      0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00, 0x00,
      0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x02, 0x00, 0x00, 0x00, 0x90, 0x77, 0x53, 0xde, 0x00, 0x00, 0x00,
      0x0c, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0xf8, 0xff, 0xff, 0x3f, 0x00, 0x05, 0xfe, 0x02, 0xfe, 0x0d,
      0xef, 0x46, 0xb8, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  return {std::begin(kBytes), std::end(kBytes)};
}

Distances distances(std::uint64_t count, double max_mm, double rms_mm, double signed_mean_mm) {
  Distances d;
  d.count = count;
  d.max_mm = max_mm;
  d.rms_mm = rms_mm;
  d.mean_mm = rms_mm * 0.8;
  d.signed_mean_mm = signed_mean_mm;
  d.above_mm = max_mm;
  d.below_mm = max_mm * 0.75;
  return d;
}

Fit sample_fit() {
  Fit fit;
  fit.all = distances(359813, 0.91347, 0.052113, -0.00123);
  fit.all.p50_mm = 0.023457;
  fit.all.p90_mm = 0.081239;
  fit.all.p95_mm = 0.10542;
  fit.all.p99_mm = 0.171236;
  fit.all.p999_mm = 0.52224;
  fit.interior = distances(358001, 0.48761, 0.051012, -0.00119);
  fit.interior.p50_mm = 0.0234;
  fit.interior.p90_mm = 0.0811;
  fit.interior.p95_mm = 0.1053;
  fit.interior.p99_mm = 0.1698;
  fit.interior.p999_mm = 0.4211;
  fit.open_border = distances(1812, 0.91347, 0.2713, 0.0042);
  fit.patch_borders = distances(20417, 0.4339, 0.0533, 0);
  // h/32 steps over -2 h .. 2 h; roughly normal, a little to the inside.
  fit.histogram.low_mm = -2;
  fit.histogram.step_mm = 1.0 / 32;
  fit.histogram.counts.assign(128, 0);
  for (int n = 0; n < 128; ++n) {
    const double t = (n - 63.4) / 2.6;
    fit.histogram.counts[static_cast<std::size_t>(n)] =
        static_cast<std::uint64_t>(62000 / (1 + t * t * (1 + t * t * 0.4)));
  }
  fit.histogram.below = 3;
  fit.histogram.above = 17;
  for (int i = 0; i < 10; ++i) {
    WorstPoint p;
    p.place = {12.25 + i, -104.5 + 3 * i, 7.0625};
    p.signed_mm = (i % 3 == 1 ? -1 : 1) * (0.91347 - 0.041 * i);
    p.file = i % 2 == 0 ? "views/bun000.ply" : "views/top <b>&amp; side.ply";
    p.row = 40256 + 977 * static_cast<std::uint64_t>(i);
    p.row_meaning = "vertex";
    p.patch = static_cast<std::uint64_t>(i % 4);
    p.open_border = i < 6;
    fit.worst.push_back(p);
    p.open_border = false;
    p.signed_mm *= 0.5338;
    fit.worst_interior.push_back(p);
  }
  fit.fit_error_mm = fit.all.max_mm;
  fit.sensor_accuracy_mm = 0.0508;
  fit.coverage = 0.9987;
  return fit;
}

Mesh sample_mesh() {
  Mesh mesh;
  mesh.vertices = 59562;
  mesh.triangles = 118924;
  mesh.patches = 5;
  mesh.components = 1;
  mesh.boundary_edges = 5412;
  mesh.euler = -6;
  mesh.crossings = 0;
  for (std::uint64_t i = 0; i < 57; ++i)
    mesh.loops.push_back(
        {3.3 + 2.5 * static_cast<double>(i * 7 % 57), 4 + i * 7 % 57, {10.0 + static_cast<double>(i), -20, 33.125}});
  mesh.dropped = {{2, 4, {81.25, 3, -44.5}, {1.5, 0.75, 0.25}}, {1, 3, {80, 2, -44}, {1, 1, 0}}};
  mesh.smallest_angle_deg = 5.0123;
  mesh.smallest_angle_p5_deg = 27.316;
  mesh.g2_deg = 5;
  mesh.mean_edge_mm = 1.04713;
  mesh.longest_edge_mm = 2.49981;
  mesh.g1_mm = 2.5;
  mesh.area_mm2 = 57113.44;
  return mesh;
}

}  // namespace

SurfaceView sample_view(std::uint32_t wide, std::uint32_t high) {
  SurfaceView view;
  for (std::uint32_t y = 0; y <= high; ++y)
    for (std::uint32_t x = 0; x <= wide; ++x) {
      view.positions.push_back({x * 0.9, y * 1.1, (x * 7919 + y * 104729) % 997 * 0.01});
      view.errors.push_back((x * 31 + y * 17) % 201 * 0.01 - 1);
    }
  for (std::uint32_t y = 0; y < high; ++y)
    for (std::uint32_t x = 0; x < wide; ++x) {
      const std::uint32_t a = y * (wide + 1) + x, c = a + wide + 1;
      view.triangles.push_back({a, a + 1, c + 1});
      view.triangles.push_back({a, c + 1, c});
      view.patch.insert(view.patch.end(), 2, x % 40);
    }
  for (std::uint32_t x = 0; x < wide; ++x) view.open_edges.emplace_back(x, x + 1);
  for (std::uint32_t n = 0; n < 30; ++n) view.patch_colours.push_back({static_cast<std::uint8_t>(n * 8), 99, 200});
  for (std::size_t n = 0; n < kErrorColours; ++n) view.error_colours.push_back({static_cast<std::uint8_t>(n), 1, 2});
  view.error_range_mm = 0.5;
  view.front = {186, 200, 216};
  view.full_triangles = view.triangles.size();
  return view;
}

ScanReport sample_report() {
  ScanReport r;
  r.scan = "stanford/bunny";
  r.job = "jobs/nightly.yaml";
  r.tool = "scanmill 0.1.0";
  r.record = "5d41402abc4b2a76b9719d911017c592ae2b1b5a0c7ad7a6f2d3b8c9e0f1a2b3";
  r.gates = {{"verify.max_error_mm", 1.2, 0.91347, "mm", true}, {"verify.rms_mm", 0.06, 0.052113, "mm", true}};
  r.notes = {{false, "1 stray component was dropped (3 points); it is listed below"},
             {true, "walls thinner than two bins near (12, 40, 7): a bin of 0.6 mm would separate them"}};
  r.pictures = {{one_pixel(), "shaded, isometric; inside orange, open edges red", 1, 1, true},
                {one_pixel(), "fit error, isometric", 1, 1},
                {one_pixel(), "patches, isometric", 1, 1},
                {one_pixel(), "points, seen from +z; removed points red", 1, 1}};
  r.points = {362272, 359813, {{"not finite", 0}, {"no measurement in the cell", 812}, {"remove_plane", 1647}}};
  r.reduction =
      Reduction{1.0, 78766, 59994, {{"c1: far from the bin's centre", 0}, {"c2: too near to another", 18772}}};
  r.mesh = sample_mesh();
  r.view = sample_view(20, 30);
  r.fit = sample_fit();
  const char* const origins[] = {"given", "automatic", "automatic", "component", "automatic"};
  for (std::uint64_t i = 0; i < 5; ++i)
    r.patches.push_back({i,
                         i == 0 ? "ear" : "",
                         origins[i],
                         {4.5 + static_cast<double>(i), 100, -3},
                         23785 - i * 311,
                         11422.7 - 100 * static_cast<double>(i),
                         distances(71000 - i, 0.4, 0.05, -0.001)});
  r.swaps = {{"smooth", 14, 20117, 22.41, 29.87}, {"feature", 9, 3121, 29.87, 27.316}};
  r.creases_before = Creases{921334.5, 0.21734, 1422.75, 1371};
  r.creases_after = Creases{913007.25, 0.20911, 1398.5, 1340};
  r.parameters = {{"lattice.bin_mm", "h", "1", "mm", "must be given", true},
                  {"reduce.representative", "", "surface", "", "surface", false},
                  {"reduce.min_neighbour_distance", "c2", "0.6", "bins", "0.6", false},
                  {"grow.range_bins", "g1", "2.5", "bins", "2.5", false},
                  {"grow.min_angle_deg", "g2", "5", "degrees", "5", false},
                  {"verify.max_error_mm", "", "1.2", "mm", "none", true},
                  {"verify.rms_mm", "", "0.06", "mm", "none", true}};
  r.inputs = {{"views/bun000.ply", "PLY binary_little_endian 1.0", 3145880, 362272, 359813,
               "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08", false},
              {"views/top <b>&amp; side.ply", "PLY ascii 1.0", 0, 0, 0, "", true}};
  r.outputs = {{"mesh.stl", 5946284, "2c26b46b68ffc68ff99b453c1d30413413422d706483bfa0f98a5e886266e7ae"},
               {"preview-shaded.png", 0, "fcde2b2edba56bf408601fb721fe9b5c338d10ee429ea04fae5511b68fbf8fb9"}};
  r.stage_versions = {{"read", "1"}, {"reduce", "2"}, {"stars", "3"}};
  r.date = "2025-03-01 05:58 UTC";
  r.stage_seconds = {{"read", 0.2134}, {"reduce", 0.4411}, {"stars", 0.7}, {"verify", 0.19}};
  return r;
}

ScanReport bare_report() {
  ScanReport r;
  r.scan = "part";
  r.points = {1000, 1000, {}};
  r.mesh.vertices = 4;
  r.mesh.triangles = 4;
  r.mesh.euler = 2;
  r.mesh.components = 1;
  return r;
}

}  // namespace scanmill::report
