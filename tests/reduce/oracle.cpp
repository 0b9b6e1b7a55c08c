// SPDX-License-Identifier: Apache-2.0
#include "oracle.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <functional>
#include <tuple>

namespace scanmill::reduce {
namespace {

/// Where in its bin a point lies, bin edges about the centre; the arithmetic in which distances are compared.
Vec3 inside_of(Vec3 p, const Lattice& lattice) {
  auto part = [&](double x, double o) {
    const double u = (x - o) / lattice.edge_mm;
    return u - std::floor(u) - 0.5;
  };
  return {part(p.x, lattice.origin.x), part(p.y, lattice.origin.y), part(p.z, lattice.origin.z)};
}

Sample least(const std::vector<Sample>& samples, const std::function<double(Vec3)>& score) {
  auto rank = [&](const Sample& s) {
    return std::make_tuple(score(s.position), s.position.x, s.position.y, s.position.z, s.source);
  };
  return *std::min_element(samples.begin(), samples.end(),
                           [&](const Sample& a, const Sample& b) { return rank(a) < rank(b); });
}

std::int64_t rounded(double x) { return static_cast<std::int64_t>(std::floor(x + 0.5)); }

}  // namespace

OracleBins oracle_bins(const TestCloud& cloud, const Lattice& lattice) {
  OracleBins bins;
  for (const Sample& s : cloud.samples) {
    if (!is_finite(s.position)) continue;
    OracleBin& bin = bins[bin_of(lattice, s.position)];
    bin.samples.push_back(s);
    const Vec3 v = inside_of(s.position, lattice);
    const std::int64_t c[3] = {rounded(v.x * 1024), rounded(v.y * 1024), rounded(v.z * 1024)};
    Moments& m = bin.moments;
    ++m.count;
    int z = 0;
    for (int a = 0; a < 3; ++a) {
      m.sum[a] += c[a];
      for (int b = a; b < 3; ++b) m.product[z++] += c[a] * c[b];
    }
    if (const auto& eye = cloud.views[index_of(s.source.view)].eye) {
      const Vec3 d = unit(*eye - s.position);
      m.view_direction[0] += rounded(d.x * 1048576);
      m.view_direction[1] += rounded(d.y * 1048576);
      m.view_direction[2] += rounded(d.z * 1048576);
    }
  }
  std::size_t row = 0;
  for (auto& [key, bin] : bins) bin.row = row++;
  return bins;
}

Sample nearest_to_centre(const OracleBin& bin, const Lattice& lattice) {
  return least(bin.samples, [&](Vec3 p) { return norm2(inside_of(p, lattice)); });
}

Sample nearest_to_foot(const OracleBin& bin, Vec3 foot, Vec3 normal, bool crease) {
  return least(bin.samples, [&](Vec3 p) {
    const double off = dot(p - foot, normal);
    return crease ? -std::abs(off) : norm2(p - foot) + 3 * off * off;
  });
}

std::vector<Drop> oracle_drops(const ReducedCloud& cloud, const OracleBins& bins, const Params& params) {
  const double h = cloud.lattice.edge_mm;
  std::vector<Drop> drop(cloud.size(), Drop::Kept);
  std::vector<std::tuple<double, std::size_t, BinKey>> walk;
  for (const auto& [key, bin] : bins) {
    const std::size_t row = bin.row;
    const double d2 = norm2(cloud.measured[row] - centre_of(cloud.lattice, key));
    if (std::ssize(bin.samples) < params.min_points_per_bin)
      drop[row] = Drop::TooFewPoints;
    else if (!cloud.frame_valid[row])
      drop[row] = Drop::Isolated;
    else if (params.max_centre_distance && d2 > *params.max_centre_distance * h * (*params.max_centre_distance * h))
      drop[row] = Drop::CentreDistance;
    else
      walk.emplace_back(params.representative == Representative::Centre ? d2 : cloud.plane_distance[row], row, key);
  }
  if (!params.min_neighbour_distance || *params.min_neighbour_distance == 0) return drop;
  std::sort(walk.begin(), walk.end(), [](const auto& a, const auto& b) {
    return std::get<0>(a) != std::get<0>(b) ? std::get<0>(a) < std::get<0>(b) : std::get<1>(a) < std::get<1>(b);
  });
  const double limit = *params.min_neighbour_distance * h;
  const auto& place = params.neighbour_positions == NeighbourPositions::Projected ? cloud.projected : cloud.measured;
  const auto two_sides = [&](std::size_t a, std::size_t b) {
    return cloud.sign_known[a] && cloud.sign_known[b] && dot(cloud.normal[a], cloud.normal[b]) < 0;
  };
  // Rows of the (2 r + 1)^3 bins around one that are in the walk.
  std::vector<std::uint8_t> walks(cloud.size(), 0);
  for (const auto& [distance, row, key] : walk) walks[row] = 1;
  const auto around = [&](const BinKey& key, int r) {
    std::vector<std::size_t> rows;
    for (int i = -r; i <= r; ++i)
      for (int j = -r; j <= r; ++j)
        for (int k = -r; k <= r; ++k)
          if (const auto near = bins.find({key.i + i, key.j + j, key.k + k}); near != bins.end())
            if (walks[near->second.row]) rows.push_back(near->second.row);
    return rows;
  };
  std::vector<std::uint8_t> taken(cloud.size(), 0);
  for (const auto& [distance, row, key] : walk) {
    for (const std::size_t other : around(key, 2))
      if (taken[other] && !two_sides(row, other) && norm2(place[other] - place[row]) < limit * limit)
        drop[row] = Drop::NeighbourDistance;
    taken[row] = drop[row] == Drop::Kept;
  }
  if (params.neighbour_positions != NeighbourPositions::Projected) return drop;
  // What the walk dropped beside a void comes back: a ball of 1 h between the point and another measured one at most
  // 2.2 h away (in the middle of two dropped ones, touching a kept one) that holds no kept point; both on one flat
  // face.
  const std::vector<Drop> first = drop;
  const auto one_face = [&](std::size_t a, std::size_t b) {
    double cosine = dot(cloud.normal[a], cloud.normal[b]);
    if (!cloud.sign_known[a] || !cloud.sign_known[b]) cosine = std::abs(cosine);
    return cosine >= 0.7 && cloud.residual[a] <= 0.2 && cloud.residual[b] <= 0.2;
  };
  std::vector<std::uint8_t> back(cloud.size(), 0);
  for (const auto& [distance, row, key] : walk) {
    if (first[row] == Drop::Kept) continue;
    bool crowded = false, beside_void = false;
    for (const std::size_t other : around(key, 2))
      crowded |= first[other] == Drop::Kept && norm2(place[other] - place[row]) < 0.25 * limit * limit;
    for (const std::size_t other : around(key, 2)) {
      const double d = norm(place[other] - place[row]);
      if (other == row || !one_face(row, other) || d > 2.2 * h || (first[other] == Drop::Kept && d <= h)) continue;
      const Vec3 centre = first[other] == Drop::Kept ? place[other] + (place[row] - place[other]) * (h / d)
                                                     : (place[row] + place[other]) * 0.5;
      bool empty = true;
      for (const std::size_t kept : around(key, 3))
        if (first[kept] == Drop::Kept && kept != other && norm2(place[kept] - centre) < h * h) empty = false;
      beside_void |= empty;
    }
    if (crowded || !beside_void) continue;
    bool beaten = false;
    for (const std::size_t other : around(key, 2))
      beaten |= back[other] && !two_sides(row, other) && norm2(place[other] - place[row]) < limit * limit;
    if (beaten) continue;
    back[row] = 1;
    drop[row] = Drop::Kept;
  }
  return drop;
}

OraclePlane oracle_plane(const OracleBins& bins, const Lattice& lattice, const BinKey& key, int radius) {
  // The integer moments of a bin stand for points; about this bin's centre, weighted exp(-d^2/2) by steps per
  // axis (3x3x3) or exp(-d^2/4.5) (5x5x5).
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  double weight = 0;
  OraclePlane plane;
  const int side = 2 * radius + 1;
  for (int n = 0; n < side * side * side; ++n) {
    const int di = n / (side * side) - radius, dj = n / side % side - radius, dk = n % side - radius;
    const Eigen::Vector3d step(di, dj, dk);
    const auto near = bins.find({key.i + di, key.j + dj, key.k + dk});
    if (near == bins.end()) continue;
    ++plane.bins;
    const double w = std::exp(-step.squaredNorm() / (radius == 1 ? 2 : 4.5));
    for (const Sample& s : near->second.samples) {
      const Vec3 v = inside_of(s.position, lattice);
      Eigen::Vector3d p(std::floor(v.x * 1024 + 0.5), std::floor(v.y * 1024 + 0.5), std::floor(v.z * 1024 + 0.5));
      p = p / 1024 + step;
      weight += w;
      first += w * p;
      second += w * p * p.transpose();
    }
  }
  const Eigen::Vector3d mean = first / weight;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(second / weight - mean * mean.transpose());
  const Eigen::Vector3d n = solver.eigenvectors().col(0);
  plane.normal = {n[0], n[1], n[2]};
  plane.centroid = centre_of(lattice, key) + Vec3{mean[0], mean[1], mean[2]} * lattice.edge_mm;
  plane.least = std::max(0.0, solver.eigenvalues()[0]);
  plane.trace = solver.eigenvalues().sum();
  plane.gap = solver.eigenvalues()[1] - solver.eigenvalues()[0];
  return plane;
}

}  // namespace scanmill::reduce
