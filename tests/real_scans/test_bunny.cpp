// SPDX-License-Identifier: Apache-2.0
// Ten raw views of the Stanford bunny: from archive to mesh.
#include <gtest/gtest.h>

#include <cstdlib>

#include "pipeline/discovery.hpp"
#include "pipeline/scan_points.hpp"
#include "pipeline/surface.hpp"
#include "store/files.hpp"

namespace scanmill {
namespace {

std::string data_folder() {
  const char* given = std::getenv("SCANMILL_DATA");
  return given != nullptr && *given != '\0' ? given : std::string(SCANMILL_ROOT) + "/../shared/data";
}

class Bunny : public testing::TestWithParam<double> {};

TEST_P(Bunny, BecomesOneSoundMesh) {
  const std::string archive = data_folder() + "/range-views/bunny";
  if (!store::is_folder(archive)) GTEST_SKIP() << "no " << archive;
  const double h = GetParam();
  const ChunkLoop loop(2);
  const CancelFlag cancel;
  const Context context{loop, cancel};
  const auto found = pipeline::discover(archive, false);
  ASSERT_TRUE(found.ok()) << found.error().text();
  ASSERT_EQ(found->scans.size(), 1u);
  const auto points = pipeline::ScanPoints::open(archive, found->scans.front(), 1000);
  ASSERT_TRUE(points.ok()) << points.error().text();
  document::Node tree = document::Node::map();
  tree.set("lattice", document::Node::map()).set("bin_mm", h);
  const auto what = pipeline::what_from(tree, "test");
  ASSERT_TRUE(what.ok());
  const auto reduced = reduce::reduce_cloud(**points, what->lattice, what->reduce, context);
  ASSERT_TRUE(reduced.ok()) << reduced.error().text();
  NoProgress progress;
  const auto surface = pipeline::mesh_surface(reduced->cloud, reduced->report.bounds, *what, context, progress);
  ASSERT_TRUE(surface.ok()) << surface.error().text();
  const TopologyCounts counts = topology_of(surface->mesh);
  EXPECT_EQ(counts.nonmanifold_edges, 0u);
  EXPECT_EQ(counts.nonmanifold_vertices, 0u);
  EXPECT_EQ(counts.misoriented_edges, 0u);
  EXPECT_EQ(counts.components, 1u);
  EXPECT_GT(signed_volume(surface->mesh), 0);
  for (const Triangle& t : surface->mesh.triangles)
    EXPECT_TRUE(within_range(surface->mesh.positions[t[0]], surface->mesh.positions[t[1]],
                             surface->mesh.positions[t[2]], 2.5 * h));
  const double used =
      static_cast<double>(surface->kept_used + surface->kept_in_strays) / static_cast<double>(reduced->report.kept);
  std::cout << "bunny " << h << " mm: " << counts.triangles << " triangles, " << counts.boundary_loops << " loops, "
            << counts.boundary_edges << " open edges, " << used * 100 << " % of kept points used\n";
  EXPECT_GE(used, 0.99);
  if (h < 1) return;
  EXPECT_LE(counts.boundary_loops, 20u);
  EXPECT_LE(counts.boundary_edges, 400u);
  EXPECT_GE(used, 0.995);
}

INSTANTIATE_TEST_SUITE_P(Bins, Bunny, testing::Values(2.0, 1.0, 0.5));

}  // namespace
}  // namespace scanmill
