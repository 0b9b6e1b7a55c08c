// SPDX-License-Identifier: Apache-2.0
// How many rays per CPU second does the virtual scanner cast into a mesh?
#include <cmath>
#include <cstdio>

#include "bench/measure.hpp"
#include "mesh/limits.hpp"
#include "simulate/rig.hpp"

namespace scanmill::bench {
namespace {

/// A sphere of radius 20 with waves of 0.4 mm, so that neither boxes nor normals come easy.
Mesh wavy_sphere(std::size_t triangles) {
  Mesh mesh;
  std::uint32_t rings = 3;
  while (4u * std::size_t{rings} * (rings - 1) < triangles) ++rings;
  const std::uint32_t around = 2 * rings;
  auto point = [&](double tilt, double turn) {
    const double radius = 20 + 0.4 * cos_of_degrees(8 * tilt) * cos_of_degrees(12 * turn);
    const double s = cos_of_degrees(90 - tilt) * radius;
    return Vec3{s * cos_of_degrees(turn), s * cos_of_degrees(90 - turn), cos_of_degrees(tilt) * radius};
  };
  mesh.positions.push_back(point(0, 0));
  for (std::uint32_t i = 1; i < rings; ++i)
    for (std::uint32_t j = 0; j < around; ++j) mesh.positions.push_back(point(180.0 * i / rings, 360.0 * j / around));
  mesh.positions.push_back(point(180, 0));
  const auto last = static_cast<std::uint32_t>(mesh.positions.size() - 1);
  auto at = [&](std::uint32_t i, std::uint32_t j) { return 1 + (i - 1) * around + j % around; };
  for (std::uint32_t j = 0; j < around; ++j) {
    mesh.triangles.push_back({0, at(1, j), at(1, j + 1)});
    for (std::uint32_t i = 1; i + 1 < rings; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      mesh.triangles.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
    }
    mesh.triangles.push_back({at(rings - 1, j), last, at(rings - 1, j + 1)});
  }
  return mesh;
}

Result<void> measure(const CommandLine& line, std::size_t triangles) {
  Mesh mesh;
  if (line.file.empty()) {
    mesh = wavy_sphere(triangles);
  } else {
    TRY_ASSIGN(mesh, read_mesh(line.file));
  }
  const ChunkLoop loop(line.threads);
  const CancelFlag cancel;
  const Context context{loop, cancel};
  Timing build, cast;
  simulate::RigCounts first;
  double rays = 0;
  for (int round = 0; round < line.repeat; ++round) {
    build.start();
    const simulate::RayTree tree(mesh);
    build.stop();
    simulate::Scene scene;
    scene.add(tree);
    const Bounds box = tree.bounds();
    const Vec3 centre = (box.low + box.high) * 0.5;
    Sensor sensor;  // 700 x 500 pixels, sized to the mesh
    const double size = norm(box.size()) * 0.6;
    sensor.field_x_mm = sensor.field_y_mm = size;
    sensor.stand_off_mm = 3 * size;
    sensor.depth_mm = size;
    cast.start();
    simulate::RigCounts sum;
    rays = 0;
    for (const Vec3 side : {Vec3{0, 0, 1}, Vec3{1, 0.2, 0.1}, Vec3{-0.3, 1, 0.4}, Vec3{-1, -1, -1}}) {
      const Pose pose = pose_looking_at(centre + unit(side) * (3 * size), centre, {0.1, 0, 1});
      TRY_ASSIGN(const simulate::RigView view, simulate::take_view(scene, sensor, {}, pose, 1, context));
      sum.returns += view.counts.returns;
      rays += static_cast<double>(sensor.pixels_x * sensor.pixels_y);
    }
    cast.stop();
    if (round == 0) first = sum;
    if (sum.returns != first.returns || sum.returns == 0)
      return fail(Code::Internal, "two rounds saw different points, or none");
  }
  if (line.json) {
    std::printf(
        "{\"triangles\": %zu, \"rays\": %.0f, \"returns\": %llu, \"build_cpu_s\": %.4f, \"cast_cpu_s\": %.4f, "
        "\"rays_per_cpu_s\": %.0f, \"peak_mib\": %.1f}\n",
        mesh.triangles.size(), rays, static_cast<unsigned long long>(first.returns), build.cpu(), cast.cpu(),
        rays / cast.cpu(), peak_mib());
    return {};
  }
  std::printf("triangles %zu, threads %d, median of %d\n", mesh.triangles.size(), line.threads, line.repeat);
  std::printf("build     %.3f s CPU (%.2f us per triangle)\n", build.cpu(),
              1e6 * build.cpu() / static_cast<double>(mesh.triangles.size()));
  std::printf("cast      %.3f s CPU, %.3f s wall: %.0f rays, %.1f %% with return, %.2f M rays per CPU s\n", cast.cpu(),
              cast.wall(), rays, 100 * static_cast<double>(first.returns) / rays, 1e-6 * rays / cast.cpu());
  std::printf("memory    %.1f MiB peak\n", peak_mib());
  return {};
}

}  // namespace
}  // namespace scanmill::bench

int main(int argc, char** argv) {
  using namespace scanmill::bench;
  CommandLine line;
  std::size_t triangles = 100000;
  if (!line.parse(argc, argv, {{"--triangles", number_into(triangles)}})) {
    std::fprintf(stderr, "usage: bench_rays [FILE.stl] [--triangles N] [--threads N] [--repeat R] [--json]\n");
    return 2;
  }
  return exit_code("bench_rays", measure(line, triangles));
}
