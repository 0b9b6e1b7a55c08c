// SPDX-License-Identifier: Apache-2.0
// IGES writing on a lat-long sphere, and with SCANMILL_HEAVY_ORACLES the CAD kernel's own writer on the same mesh in
// the same run. CPU seconds. usage: bench_iges [TRIANGLES=20000] [REPEAT=5]
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "export/iges.hpp"
#include "store/files.hpp"
#ifdef SCANMILL_OCCT
#include "support/occt_shapes.hpp"
#endif

namespace {

using namespace scanmill;

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

Mesh sphere(std::size_t triangles) {
  Mesh mesh;
  const auto rings =
      std::max(3, static_cast<int>(std::lround(std::sqrt(static_cast<double>(triangles) / 4 + 0.25) + 0.5)));
  const int around = 2 * rings;
  auto add = [&](double z, double turn, double r) {
    mesh.positions.push_back(
        {static_cast<float>(r * std::cos(turn)), static_cast<float>(r * std::sin(turn)), static_cast<float>(z)});
  };
  add(-50, 0, 0);
  for (int i = 1; i < rings; ++i)
    for (int k = 0; k < around; ++k)
      add(-50 * std::cos(M_PI * i / rings), 2 * M_PI * k / around, 50 * std::sin(M_PI * i / rings));
  add(50, 0, 0);
  auto at = [&](int i, int k) { return static_cast<std::uint32_t>(1 + (i - 1) * around + k % around); };
  for (int k = 0; k < around; ++k) {
    mesh.triangles.push_back({0, at(1, k + 1), at(1, k)});
    for (int i = 1; i + 1 < rings; ++i) {
      mesh.triangles.push_back({at(i, k), at(i, k + 1), at(i + 1, k)});
      mesh.triangles.push_back({at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)});
    }
    mesh.triangles.push_back(
        {at(rings - 1, k), at(rings - 1, k + 1), static_cast<std::uint32_t>(mesh.positions.size() - 1)});
  }
  return mesh;
}

}  // namespace

int main(int argc, char** argv) {
  const auto triangles = static_cast<std::size_t>(argc > 1 ? std::atol(argv[1]) : 20000);
  const int repeat = argc > 2 ? std::atoi(argv[2]) : 5;
  const Mesh mesh = sphere(triangles);
  const std::string path = "/dev/shm/bench_iges." + std::to_string(::getpid()) + ".igs";
  double brep = 0;
  for (const auto style : {exporting::IgesStyle::Brep, exporting::IgesStyle::Trimmed, exporting::IgesStyle::Patches,
                           exporting::IgesStyle::Wire}) {
    std::vector<double> seconds;
    std::uint64_t bytes = 0;
    for (int i = 0; i < repeat; ++i) {
      const double before = cpu_seconds();
      auto sink = store::create_file(path);
      if (!sink.ok()) return 1;
      const auto counts = exporting::write_iges(mesh, {style, {}, false}, **sink);
      if (!counts.ok() || !(*sink)->commit().ok()) return 1;
      seconds.push_back(cpu_seconds() - before);
      bytes = counts->bytes;
    }
    std::sort(seconds.begin(), seconds.end());
    const double median = seconds[seconds.size() / 2];
    if (style == exporting::IgesStyle::Brep) brep = median;
    std::printf("%-8s %zu triangles: %.4f s CPU, %.0f triangles/s, %.0f bytes/triangle\n",
                std::string(exporting::iges_style_words()[static_cast<std::size_t>(style)]).c_str(),
                mesh.triangles.size(), median, static_cast<double>(mesh.triangles.size()) / median,
                static_cast<double>(bytes) / static_cast<double>(mesh.triangles.size()));
  }
#ifdef SCANMILL_OCCT
  const double rival = support::write_with_occt(mesh, path);
  std::printf("OCCT     %zu triangles: %.4f s CPU (transfer and write); brep above is %.1f times as fast\n",
              mesh.triangles.size(), rival, rival / brep);
#else
  std::printf("OCCT is not part of this build (SCANMILL_HEAVY_ORACLES); brep %.4f s\n", brep);
#endif
  std::remove(path.c_str());
  return 0;
}
