// SPDX-License-Identifier: Apache-2.0
#include "provenance/sample/sample_record.hpp"

#include <cstdio>
#include <cstring>
#include <fstream>

#include "base/digest.hpp"
#include "base/text.hpp"

namespace scanmill::provenance::sample {
namespace {

constexpr std::uint32_t kRings = 7, kAround = 8;
constexpr double kRadius = 20;

struct View {
  const char* path;
  const char* format;
  const char* row_meaning;
  std::uint64_t first_row;
  double units_mm;
  Vec3 shift;
};
// A quarter turn about z and a shift; the text file has one header line, so its points begin on line 2.
const View kViews[] = {
    {"a.ply", "ply binary_little_endian", "vertex from 0", 0, 1000, {1, 2, 3}},
    {"sub/b.xyz", "xyz", "line from 1", 2, 1, {-0.5, 0, 7}},
    {"c.ply", "ply ascii", "vertex from 0", 0, 25.4, {0, 0, 0}},
};

/// Point n of the ball: no trigonometry, eight corners of a squashed octagon per ring.
Vec3 ball_point(std::uint32_t n) {
  const double x[kAround] = {1, 0.7, 0, -0.7, -1, -0.7, 0, 0.7}, y[kAround] = {0, 0.7, 1, 0.7, 0, -0.7, -1, -0.7};
  const double height = -0.9 + 0.3 * (n / kAround);
  const double wide = std::sqrt(1 - height * height);
  return Vec3{x[n % kAround] * wide, y[n % kAround] * wide, height} * kRadius + Vec3{0.1234567, 100, 0};
}

Vec3 seen_from(const View& view, Vec3 global) {
  const Vec3 p = global - view.shift;
  return Vec3{p.y, -p.x, p.z} * (1 / view.units_mm);  // the inverse of the quarter turn
}

Vec3 back_to_global(const View& view, Vec3 p) { return Vec3{-p.y, p.x, p.z} * view.units_mm + view.shift; }

void append(std::string& bytes, const void* data, std::size_t n) { bytes.append(static_cast<const char*>(data), n); }

std::string line(Vec3 p, const char* separator) {
  return number_text(p.x) + separator + number_text(p.y) + separator + number_text(p.z) + "\n";
}

/// What the view's file holds, and in `global` what a reader makes of it.
std::string file_text(std::size_t v, std::vector<Vec3>& global) {
  const View& view = kViews[v];
  std::string body;
  for (std::uint32_t n = static_cast<std::uint32_t>(v); n < kRings * kAround; n += 3) {
    const Vec3 p = seen_from(view, ball_point(n));
    const float f[3] = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
    if (v == 0) {
      global.push_back(back_to_global(view, {f[0], f[1], f[2]}));
      append(body, f, 4);
      body += '\7';  // a property between the coordinates
      append(body, f + 1, 8);
    } else {
      global.push_back(back_to_global(view, p));
      body += v == 1 ? line(p, ", ") : "0.5 " + line(p, " ");
    }
  }
  const std::string count = std::to_string(global.size());
  if (v == 1) return "x, y, z\n" + body;
  if (v == 0) {
    return "ply\nformat binary_little_endian 1.0\ncomment a view\nelement camera 1\nproperty list uchar short "
           "grid\nproperty int id\n"
           "element vertex " +
           count + "\nproperty float x\nproperty uchar quality\nproperty float y\nproperty float z\nend_header\n" +
           std::string("\2\1\0\2\0\4\0\0\0", 9) + body;
  }
  return "ply\nformat ascii 1.0\nelement vertex " + count +
         "\nproperty float weight\nproperty double x\nproperty double y\nproperty double z\nend_header\n" + body;
}

Mesh ball_mesh(const std::vector<Vec3>& points, Vec3 offset) {
  Mesh mesh;
  mesh.offset = offset;
  for (const Vec3 p : points) {
    const Vec3 q = p - offset;
    mesh.positions.push_back({static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)});
  }
  for (std::uint32_t ring = 0; ring + 1 < kRings; ++ring)
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const std::uint32_t a = ring * kAround + i, b = ring * kAround + (i + 1) % kAround, c = a + kAround,
                          d = b + kAround;
      mesh.triangles.push_back(a < b ? Triangle{a, b, d} : Triangle{b, d, a});
      mesh.triangles.push_back({a, d, c});
      mesh.patch.insert(mesh.patch.end(), 2, ring < 3 ? 0 : 1);
    }
  return mesh;
}

}  // namespace

SampleScan make_scan(const std::string& archive) {
  SampleScan scan;
  Record& r = scan.record;
  r.scan = "ball";
  r.what_json = R"({"lattice":{"bin_mm":2}})";
  r.description_path = "ball.yaml";
  r.description_text = "scanmill: 1\nname: Kugel \xc3\xa4\n";
  r.description_sha256 = sha256_hex(r.description_text);
  std::vector<std::vector<Vec3>> global(3);
  for (std::size_t v = 0; v < 3; ++v) {
    const std::string text = file_text(v, global[v]);
    if (!archive.empty()) std::ofstream(archive + "/" + kViews[v].path, std::ios::binary) << text;
    InputEntry entry{kViews[v].path, sha256_hex(text), text.size(), kViews[v].format, kViews[v].row_meaning};
    const Vec3 t = kViews[v].shift;
    entry.pose = {0, -1, 0, t.x, 1, 0, 0, t.y, 0, 0, 1, t.z, 0, 0, 0, 1};
    entry.units_mm = kViews[v].units_mm;
    entry.points_read = entry.points_used = global[v].size();
    r.inputs.push_back(entry);
  }
  r.inputs.push_back({"lost.ply", "", 0, "", "vertex from 0"});
  r.inputs.back().missing = true;
  for (std::uint32_t n = 0; n < kRings * kAround; ++n) {
    r.points.push_back(global[n % 3][n / 3]);
    r.source.push_back({ViewId{n % 3}, n / 3 + kViews[n % 3].first_row});
    r.bins.push_back({n, -static_cast<std::int64_t>(n), 1ll << 40});
    r.drop.push_back(0);
    r.vertex_row.push_back(n);
  }
  r.points.push_back({1, 1, 1});
  r.source.push_back({ViewId{0}, 0});
  r.bins.push_back({0, 0, 0});
  r.drop.push_back(2);
  r.drop_names = {"Kept", "TooFewPoints", "Isolated"};
  r.bin_mm = 2;
  scan.mesh = ball_mesh({r.points.begin(), r.points.end() - 1}, {0, 100, 0});
  for (std::uint32_t t = 0; t < scan.mesh.triangles.size(); ++t) r.growth_rank.push_back(t);
  r.patches = {{{1, 2, 3}, "given", 48, 100, 60}, {{4, 5, 6}, "automatic", 48, 100, 60}};
  r.patch_borders = {{24, 25, 26}, {26, 27}};
  r.loops = border_loops(scan.mesh);
  r.strays = {{3, 5, {1, 1, 1}, {2, 2, 2}}};
  r.counters = {
      {"reduce", "points", 1e6, true}, {"reduce", "median_residual", 0.25, false}, {"grow", "refused_angle", 7, true}};
  r.stage_versions = {{"reduce", "1"}, {"grow", "2"}};
  r.notes = {"lost.ply is missing", ""};
  r.outputs = {{"mesh.stl", sha256_hex(stl_bytes(scan.mesh))}};
  return scan;
}

std::string stl_bytes(const Mesh& mesh) {
  std::string bytes = "scanmill binary STL UNITS=mm";
  bytes.resize(80, ' ');
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  append(bytes, &count, 4);
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
    const Vec3 n = cross(b - a, c - a);
    const double length = norm(n);
    const Vec3 rows[4] = {length > 0 ? Vec3{n.x / length, n.y / length, n.z / length} : Vec3{}, a, b, c};
    for (const Vec3 row : rows) {
      const float f[3] = {static_cast<float>(row.x) + 0.0f, static_cast<float>(row.y) + 0.0f,
                          static_cast<float>(row.z) + 0.0f};
      append(bytes, f, 12);
    }
    bytes.append(2, '\0');
  }
  return bytes;
}

}  // namespace scanmill::provenance::sample
