// SPDX-License-Identifier: Apache-2.0
// Distance of a mesh's surface from a built-in solid, as JSON: as it lies, and after the rigid motion that brings it
// nearest (what no measurement inside the cloud can tell). usage: solid_error OBJECT MESH [SAMPLES]
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "base/random.hpp"
#include "formats/mesh_reader.hpp"
#include "simulate/object.hpp"
#include "store/files.hpp"

namespace {

using namespace scanmill;

/// Uniform by area, the same for the same mesh.
std::vector<Vec3> samples_of(const Mesh& mesh, std::size_t count) {
  auto at = [&](std::uint32_t v) { return mesh.positions[v] + mesh.offset; };
  std::vector<double> sums{0};
  for (const auto& [a, b, c] : mesh.triangles)
    sums.push_back(sums.back() + 0.5 * norm(cross(at(b) - at(a), at(c) - at(a))));
  std::vector<Vec3> samples;
  for (std::size_t i = 0; i < count; ++i) {
    Random random(1, i, 0);
    const double area = (static_cast<double>(i) + random.uniform()) / static_cast<double>(count) * sums.back();
    const auto t =
        static_cast<std::size_t>(std::upper_bound(sums.begin() + 1, sums.end() - 1, area) - sums.begin()) - 1;
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const auto& [a, b, c] = mesh.triangles[t];
    samples.push_back(at(a) + (at(b) - at(a)) * u + (at(c) - at(a)) * v);
  }
  return samples;
}

struct Errors {
  double rms = 0, mean = 0, worst = 0;
};
Errors errors_of(const simulate::Object& object, const std::vector<Vec3>& points) {
  Errors errors;
  for (const Vec3& p : points) {
    const double d = object.surface_distance(p);
    errors.rms += d * d;
    errors.mean += d;
    errors.worst = std::max(errors.worst, std::abs(d));
  }
  errors.rms = std::sqrt(errors.rms / static_cast<double>(points.size()));
  errors.mean /= static_cast<double>(points.size());
  return errors;
}

/// One Gauss-Newton step of the rigid motion; the points move.
void bring_nearer(const simulate::Object& object, std::vector<Vec3>& points) {
  std::array<std::array<double, 7>, 6> m{};
  for (const Vec3& p : points) {
    const double d = object.surface_distance(p);
    const Vec3 n = simulate::normal_at(object, p), r = cross(p, n);
    const double row[6] = {r.x, r.y, r.z, n.x, n.y, n.z};
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t j = 0; j < 6; ++j) m[i][j] += row[i] * row[j];
      m[i][6] -= row[i] * d;
    }
  }
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t k = 0; k < 6; ++k) {
      if (k == i) continue;
      const double f = m[k][i] / m[i][i];
      for (std::size_t j = i; j < 7; ++j) m[k][j] -= f * m[i][j];
    }
  const Vec3 turn{m[0][6] / m[0][0], m[1][6] / m[1][1], m[2][6] / m[2][2]};
  const Vec3 shift{m[3][6] / m[3][3], m[4][6] / m[4][4], m[5][6] / m[5][5]};
  for (Vec3& p : points) p = p + cross(turn, p) + shift;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  const auto object = simulate::make_object(argv[1]);
  const auto source = store::open_file(argv[2], argv[2]);
  if (!object.ok() || !source.ok()) return 2;
  const auto file = formats::read_mesh(*source);
  if (!file.ok()) return 2;
  Mesh mesh = formats::mesh_of(*file);
  if (file->offset) mesh.offset = *file->offset;
  std::vector<Vec3> points = samples_of(mesh, argc > 3 ? static_cast<std::size_t>(std::atoll(argv[3])) : 50000);
  const Errors as_it_lies = errors_of(**object, points);
  for (int step = 0; step < 4; ++step) bring_nearer(**object, points);
  const Errors moved = errors_of(**object, points);
  std::printf(
      "{\"rms_mm\": %.6f, \"mean_mm\": %.6f, \"max_mm\": %.6f, \"moved_rms_mm\": %.6f, \"moved_mean_mm\": %.6f}\n",
      as_it_lies.rms, as_it_lies.mean, as_it_lies.worst, moved.rms, moved.mean);
  return 0;
}
