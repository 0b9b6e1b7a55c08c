// SPDX-License-Identifier: Apache-2.0
#include "verify/compare.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "base/random.hpp"
#include "verify/quality.hpp"
#include "verify/triangle_index.hpp"

namespace scanmill::verify {
namespace {

constexpr std::size_t kGrain = 4096;
constexpr std::uint64_t kPlacesPerTriangle = 4, kLeastPlaces = 10'000, kMostPlaces = 4'000'000;
constexpr std::uint64_t kSeed = 1, kPurpose = 0x636f6d70617265;  // "compare"

/// Places are in the global frame.
Deviation deviation_of(std::span<const Vec3> places, const TriangleIndex& from, const Context& context) {
  std::vector<double> distance(places.size());
  const Vec3 offset = from.mesh().offset;
  for_each_range(context, places.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<Vec3> local(end - begin);
    std::vector<Hit> hits(end - begin);
    for (std::size_t n = begin; n < end; ++n) local[n - begin] = places[n] - offset;
    TriangleIndex::Search(from).nearest(local, hits);
    for (std::size_t n = begin; n < end; ++n) distance[n] = std::sqrt(hits[n - begin].distance2);
  });
  Deviation deviation;
  deviation.places = places.size();
  if (places.empty() || context.cancel.is_set()) return deviation;
  double sum = 0, sum2 = 0;
  for (std::size_t n = 0; n < distance.size(); ++n) {  // in order of places, so the same for any threads
    sum += distance[n];
    sum2 += distance[n] * distance[n];
    if (n == 0 || distance[n] > deviation.max_mm) {
      deviation.max_mm = distance[n];
      deviation.worst = places[n];
    }
  }
  const auto count = static_cast<double>(places.size());
  deviation.mean_mm = sum / count;
  deviation.rms_mm = std::sqrt(sum2 / count);
  const auto rank = static_cast<std::ptrdiff_t>(0.99 * (count - 1));
  std::nth_element(distance.begin(), distance.begin() + rank, distance.end());
  deviation.p99_mm = distance[static_cast<std::size_t>(rank)];
  return deviation;
}

Vec3 place_of(const Mesh& mesh, std::uint32_t v) { return mesh.positions[v] + mesh.offset; }

std::vector<Vec3> used_vertices(const Mesh& mesh) {
  std::vector<std::uint8_t> used(mesh.positions.size(), 0);
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) used[v] = 1;
  std::vector<Vec3> places;
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v)
    if (used[v]) places.push_back(place_of(mesh, v));
  return places;
}

double area_of(const Mesh& mesh, const Triangle& t) {
  const Vec3 a = mesh.positions[t[0]];
  return norm(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a)) / 2;
}

std::vector<Vec3> places_on(const Mesh& mesh, double area) {
  const std::uint64_t wanted =
      std::clamp<std::uint64_t>(kPlacesPerTriangle * mesh.triangles.size(), kLeastPlaces, kMostPlaces);
  std::vector<Vec3> places;
  places.reserve(wanted);
  double before = 0;
  for (const Triangle& t : mesh.triangles) {
    const double after = before + area_of(mesh, t);
    while (places.size() < wanted &&
           (static_cast<double>(places.size()) + 0.5) / static_cast<double>(wanted) * area < after) {
      Random random(kSeed, places.size(), kPurpose);
      double u = random.uniform(), v = random.uniform();
      if (u + v > 1) {  // the other half of the parallelogram
        u = 1 - u;
        v = 1 - v;
      }
      const Vec3 a = mesh.positions[t[0]];
      places.push_back(a + (mesh.positions[t[1]] - a) * u + (mesh.positions[t[2]] - a) * v + mesh.offset);
    }
    before = after;
  }
  return places;
}

/// Signed tetrahedra over `middle`, which keeps digits that an origin far away would cost.
double volume_about(const Mesh& mesh, Vec3 middle) {
  double sum = 0;
  const Vec3 origin = middle - mesh.offset;
  for (const Triangle& t : mesh.triangles)
    sum += dot(mesh.positions[t[0]] - origin, cross(mesh.positions[t[1]] - origin, mesh.positions[t[2]] - origin));
  return sum / 6;
}

Side side_of(const Mesh& mesh, const TriangleIndex& other, Vec3 middle, const Context& context) {
  Side side;
  side.topology = topology_of(mesh);
  for (const Triangle& t : mesh.triangles) side.area_mm2 += area_of(mesh, t);
  side.volume_mm3 = volume_about(mesh, middle);
  side.vertices = deviation_of(used_vertices(mesh), other, context);
  side.surface = deviation_of(places_on(mesh, side.area_mm2), other, context);
  return side;
}

/// Corners by place: the least first, the cycle kept.
using Places = std::array<Vec3, 3>;
bool places_before(const Places& s, const Places& t) {
  for (std::size_t k = 0; k < 3; ++k)
    if (s[k] != t[k]) return before(s[k], t[k]);
  return false;
}
std::vector<Places> sorted_triangles(const Mesh& mesh) {
  std::vector<Places> list;
  list.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    Places at{place_of(mesh, t[0]), place_of(mesh, t[1]), place_of(mesh, t[2])}, least = at;
    for (int turn = 0; turn < 2; ++turn) {
      std::rotate(at.begin(), at.begin() + 1, at.end());
      if (places_before(at, least)) least = at;
    }
    list.push_back(least);
  }
  std::sort(list.begin(), list.end(), places_before);
  return list;
}

template <class T, class Before>
std::uint64_t in_both(const std::vector<T>& a, const std::vector<T>& b, Before before_other) {
  std::uint64_t count = 0;
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    if (before_other(a[i], b[j])) {
      ++i;
    } else if (before_other(b[j], a[i])) {
      ++j;
    } else {
      ++count;
      ++i;
      ++j;
    }
  }
  return count;
}

void compare_sets(const Mesh& a, const Mesh& b, Comparison& comparison) {
  std::vector<Vec3> u = used_vertices(a), v = used_vertices(b);
  const auto by_place = [](const Vec3& p, const Vec3& q) { return before(p, q); };
  std::sort(u.begin(), u.end(), by_place);
  std::sort(v.begin(), v.end(), by_place);
  comparison.vertices_in_both = in_both(u, v, by_place);
  comparison.same_vertices = comparison.vertices_in_both == u.size() && u.size() == v.size();
  comparison.triangles_in_both = in_both(sorted_triangles(a), sorted_triangles(b), places_before);
  comparison.same_triangles =
      comparison.triangles_in_both == a.triangles.size() && a.triangles.size() == b.triangles.size();
  comparison.identical = a.positions == b.positions && a.triangles == b.triangles && a.offset == b.offset;
}

}  // namespace

Result<Comparison> compare_meshes(const Mesh& a, const Mesh& b, const Context& context) {
  for (const Mesh* mesh : {&a, &b})
    if (auto checked = check_mesh(*mesh); !checked.ok())
      return std::move(checked).error().at(mesh == &a ? "first mesh" : "second mesh");
  const TriangleIndex index_a(a), index_b(b);
  for (const TriangleIndex* index : {&index_a, &index_b})
    if (index->empty())
      return fail(Code::BadInput, "no triangle has an area; distances need a surface",
                  index == &index_a ? "first mesh" : "second mesh");
  Bounds box;
  for (const Mesh* mesh : {&a, &b})
    for (const Vec3 p : used_vertices(*mesh)) box.add(p);
  const Vec3 middle = box.low * 0.5 + box.high * 0.5;
  Comparison comparison;
  comparison.a = side_of(a, index_b, middle, context);
  comparison.b = side_of(b, index_a, middle, context);
  if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
  comparison.area_difference_mm2 = comparison.b.area_mm2 - comparison.a.area_mm2;
  comparison.volume_difference_mm3 = comparison.b.volume_mm3 - comparison.a.volume_mm3;
  compare_sets(a, b, comparison);
  return comparison;
}

}  // namespace scanmill::verify
