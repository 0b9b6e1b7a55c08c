// SPDX-License-Identifier: Apache-2.0
#include "verify/on_triangles.hpp"

#include <algorithm>
#include <memory>

#include "cloud/over_blocks.hpp"
#include "verify/sides.hpp"
#include "verify/triangle_index.hpp"

namespace scanmill::verify {
namespace {

struct Worker {
  explicit Worker(const TriangleIndex& index) : search(index) {}
  TriangleIndex::Search search;
  PointBlock block;
  std::vector<Hit> hits;
};

}  // namespace

Result<PointsOnTriangles> points_on_triangles(const Mesh& mesh, const PointSource& points, double reach_mm,
                                              std::uint64_t most, const Context& context) {
  const TriangleIndex index(mesh);
  if (index.empty()) return fail(Code::BadInput, "no triangle of the mesh has an area; no point can be nearest to one");
  const Sides sides(mesh);
  const std::uint64_t step = (points.expected_points() + most - 1) / std::max<std::uint64_t>(most, 1);
  PointsOnTriangles all;
  all.step = std::max<std::uint64_t>(step, 1);
  std::vector<PointsOnTriangles> pieces(points.block_count());
  std::vector<std::unique_ptr<Worker>> workers(static_cast<std::size_t>(context.loop.threads()));
  FirstBlockError first;
  context.loop.run(pieces.size(), [&](std::size_t number, int worker) {
    if (context.cancel.is_set() || first.is_before(number)) return;
    auto& mine = workers[static_cast<std::size_t>(worker)];
    if (!mine) mine = std::make_unique<Worker>(index);
    if (auto read = points.read_block(number, mine->block); !read.ok())
      return first.report(number, std::move(read).error());
    PointsOnTriangles& piece = pieces[number];
    for (std::size_t n = 0; n < mine->block.positions.size(); ++n)
      if (mine->block.rows[n] % all.step == 0) piece.places.push_back(mine->block.positions[n] - mesh.offset);
    mine->hits.resize(piece.places.size());
    mine->search.nearest(piece.places, mine->hits);
    std::size_t kept = 0;
    for (std::size_t n = 0; n < piece.places.size(); ++n) {
      if (mine->hits[n].distance2 > reach_mm * reach_mm || sides.at_open_border(mine->hits[n])) {
        ++piece.left_out;
        continue;
      }
      piece.places[kept++] = piece.places[n];
      piece.triangle.push_back(mine->hits[n].triangle);
    }
    piece.places.resize(kept);
  });
  TRY(first.take(context));
  for (PointsOnTriangles& piece : pieces) {
    all.places.insert(all.places.end(), piece.places.begin(), piece.places.end());
    all.triangle.insert(all.triangle.end(), piece.triangle.begin(), piece.triangle.end());
    all.left_out += piece.left_out;
    piece = {};
  }
  return all;
}

}  // namespace scanmill::verify
