// SPDX-License-Identifier: Apache-2.0
#include "support/meshing.hpp"

namespace scanmill::support {

pipeline::What what_of(double bin_mm, pipeline::Profile profile) {
  pipeline::What what;
  what.profile = profile;
  what.lattice.bin_mm = bin_mm;
  if (profile == pipeline::Profile::Paper) {
    what.reduce = reduce::Params::paper();
    what.grow.range_bins = 2;
    what.lattice.origin = reduce::Origin::Bounds;
  }
  return what;
}

Result<Meshed> mesh_cloud(const PointSource& points, const pipeline::What& what, int threads) {
  const Workers workers(threads);
  NoProgress quiet;
  Meshed meshed;
  TRY_ASSIGN(meshed.reduction, reduce::reduce_cloud(points, what.lattice, what.reduce, workers.context()));
  TRY_ASSIGN(meshed.surface, pipeline::mesh_surface(meshed.reduction.cloud, meshed.reduction.report.bounds, what,
                                                    workers.context(), quiet));
  return meshed;
}

Result<Meshed> mesh_points(std::vector<Vec3> points, const pipeline::What& what, int threads) {
  return mesh_cloud(MemoryPoints(std::move(points)), what, threads);
}

MeshFindings judge(const Meshed& meshed, const pipeline::What& what) {
  const Mesh& mesh = meshed.surface.mesh;
  return check_mesh(mesh.positions, mesh.triangles, what.grow.range_bins * meshed.reduction.cloud.lattice.edge_mm,
                    what.grow.min_angle_deg);
}

}  // namespace scanmill::support
