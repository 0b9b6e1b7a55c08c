// SPDX-License-Identifier: Apache-2.0
#include "merge/merge.hpp"

#include <algorithm>
#include <numeric>

#include "mesh/groups.hpp"

namespace scanmill::merge {
namespace {

/// A sheet is at most this deep against its shorter side, and its normals sum to this share of its box or more (a
/// closed plate's sum to nothing).
constexpr double kSheetDepth = 0.2, kSheetShare = 0.4;

struct Component {
  std::uint64_t triangles = 0, vertices = 0;
  bool side_known = false;
  Bounds bounds;
  double volume = 0;
  Vec3 area;  // the sum of the triangles' normals times twice their areas
};

/// Component number per row (rows in ascending order number the components), kNoTriangle where no triangle is.
std::vector<std::uint32_t> label_rows(const Input& in, std::uint32_t& count) {
  Groups groups(in.positions.size());
  for (const Triangle& t : in.triangles) {
    groups.join(t[0], t[1]);
    groups.join(t[0], t[2]);
  }
  std::vector<std::uint32_t> label(in.positions.size(), kNoTriangle);
  for (const Triangle& t : in.triangles)
    for (const std::uint32_t v : t) label[v] = 0;
  count = 0;
  std::vector<std::uint32_t> number(in.positions.size(), kNoTriangle);
  for (std::uint32_t v = 0; v < label.size(); ++v) {
    if (label[v] == kNoTriangle) continue;
    const std::uint32_t r = groups.root(v);
    if (number[r] == kNoTriangle) number[r] = count++;
    label[v] = number[r];
  }
  return label;
}

struct Face {
  Triangle corners;
  std::uint32_t patch;
};

/// Ascending; by first corner into place, a handful each, and nearly always in order already.
void sort_faces(std::vector<Face>& faces, std::size_t vertices) {
  std::vector<std::uint32_t> next(vertices + 1, 0);
  for (const Face& face : faces) ++next[face.corners[0] + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<Face> sorted(faces.size());
  for (const Face& face : faces) {
    const std::uint32_t v = face.corners[0];
    std::uint32_t at = next[v]++;
    for (; at > 0 && sorted[at - 1].corners[0] == v && face.corners < sorted[at - 1].corners; --at)
      sorted[at] = sorted[at - 1];
    sorted[at] = face;
  }
  faces.swap(sorted);
}

/// Of a sheet across an axis, such as a stretch of ground from the air: 1 when it shows the positive side of the axis,
/// -1 for the other; 0 for what is no sheet.
int side_of_sheet(const Component& part) {
  const Vec3 size = part.bounds.size();
  const double sizes[3] = {size.x, size.y, size.z}, area[3] = {part.area.x, part.area.y, part.area.z};
  for (int k = 2; k >= 0; --k) {
    const double wide = sizes[(k + 1) % 3], long_ = sizes[(k + 2) % 3];
    const bool flat = sizes[k] <= kSheetDepth * std::min(wide, long_);
    if (flat && std::abs(area[k]) >= 2 * kSheetShare * wide * long_) return area[k] > 0 ? 1 : -1;
  }
  return 0;
}

/// A bulge tells the outside of a part, open or closed; a sheet has none worth the name and lies with its upper side
/// up.
bool is_inside_out(const Component& part) {
  const int sheet = side_of_sheet(part);
  return sheet != 0 ? sheet < 0 : part.volume < 0;
}

}  // namespace

Merged merge_components(const Input& in, const Params& params) {
  Merged out;
  std::uint32_t count = 0;
  const std::vector<std::uint32_t> label = label_rows(in, count);
  std::vector<Component> parts(count);
  for (std::size_t v = 0; v < label.size(); ++v) {
    if (label[v] == kNoTriangle) continue;
    Component& part = parts[label[v]];
    ++part.vertices;
    part.bounds.add(in.positions[v]);
    part.side_known |= in.side_known[v] != 0;
  }
  std::uint64_t largest = 0;
  for (const Triangle& t : in.triangles) {
    Component& part = parts[label[t[0]]];
    // About the middle of its box, so that an open piece is judged by where it bulges.
    const Vec3 middle = (part.bounds.low + part.bounds.high) * 0.5;
    part.volume += dot(in.positions[t[0]] - middle, cross(in.positions[t[1]] - middle, in.positions[t[2]] - middle));
    part.area = part.area + cross(in.positions[t[1]] - in.positions[t[0]], in.positions[t[2]] - in.positions[t[0]]);
    largest = std::max(largest, ++part.triangles);
  }
  const double least = params.min_component_share * static_cast<double>(in.triangles.size());
  std::vector<std::uint8_t> dropped(count, 0), turned(count, 0);
  for (std::uint32_t c = 0; c < count; ++c) {
    const Component& part = parts[c];
    dropped[c] = part.triangles < largest && static_cast<double>(part.triangles) < least;
    if (dropped[c]) {
      out.strays.push_back(
          {part.triangles, part.vertices, {part.bounds.low + in.offset, part.bounds.high + in.offset}});
      continue;
    }
    ++out.components;
    turned[c] = !part.side_known && is_inside_out(part);
    out.turned_by_volume += !part.side_known;
    out.turned_components += turned[c];
  }
  std::stable_sort(out.strays.begin(), out.strays.end(),
                   [](const Stray& a, const Stray& b) { return a.triangles > b.triangles; });
  std::vector<std::uint32_t> vertex(label.size(), kNoTriangle);
  out.mesh.offset = in.offset;
  for (std::uint32_t row = 0; row < label.size(); ++row) {
    if (label[row] == kNoTriangle) continue;
    if (dropped[label[row]]) {
      out.stray_rows.push_back(row);
      continue;
    }
    vertex[row] = static_cast<std::uint32_t>(out.vertex_row.size());
    out.vertex_row.push_back(row);
    out.mesh.positions.push_back(in.positions[row]);
  }
  std::vector<Face> faces;
  faces.reserve(in.triangles.size());
  for (std::size_t f = 0; f < in.triangles.size(); ++f) {
    const Triangle& t = in.triangles[f];
    const std::uint32_t c = label[t[0]];
    if (dropped[c]) continue;
    Triangle own{vertex[t[0]], vertex[t[1]], vertex[t[2]]};
    if (turned[c]) std::swap(own[1], own[2]);
    std::rotate(own.begin(), std::min_element(own.begin(), own.end()), own.end());
    faces.push_back({own, in.patch.empty() ? kNoTriangle : in.patch[f]});
  }
  sort_faces(faces, out.mesh.positions.size());
  out.mesh.triangles.reserve(faces.size());
  for (const Face& face : faces) {
    out.mesh.triangles.push_back(face.corners);
    if (!in.patch.empty()) out.mesh.patch.push_back(face.patch);
  }
  return out;
}

}  // namespace scanmill::merge
