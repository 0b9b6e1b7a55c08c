// SPDX-License-Identifier: Apache-2.0
#include "pipeline/convert_notes.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "formats/probe.hpp"
#include "pipeline/outputs_key.hpp"

namespace scanmill::pipeline {
namespace {

bool is_stl(ConvertTarget to) { return to == ConvertTarget::StlBinary || to == ConvertTarget::StlAscii; }
bool is_ply_mesh(ConvertTarget to) { return to == ConvertTarget::PlyMesh || to == ConvertTarget::PlyMeshDouble; }

double rounded(double value) { return static_cast<double>(static_cast<float>(value)); }
Vec3 rounded(Vec3 p) { return {rounded(p.x), rounded(p.y), rounded(p.z)}; }

void add_rounding(const formats::MeshFile& mesh, double unit_mm, std::vector<std::string>& losses) {
  double largest = 0;
  for (const Vec3& p : mesh.positions) {
    const Vec3 d = p - rounded(p);
    largest = std::max({largest, std::abs(d.x), std::abs(d.y), std::abs(d.z)});
  }
  if (!(largest > 0)) return;
  losses.push_back("coordinates are rounded to float32; the largest change is " + number_text(largest * unit_mm) +
                   " mm on an axis");
  std::uint64_t collapsed = 0;
  for (const Triangle& t : mesh.triangles) {
    auto meet = [&](std::size_t i, std::size_t k) {
      const Vec3 &a = mesh.positions[t[i]], &b = mesh.positions[t[k]];
      return !(a == b) && rounded(a) == rounded(b);
    };
    collapsed += meet(0, 1) || meet(1, 2) || meet(2, 0);
  }
  if (collapsed > 0)
    losses.push_back(grouped(collapsed) + " triangles lose their area by that rounding; move the mesh to the origin, " +
                     "or write a PLY with doubles");
}

std::uint64_t unused_vertices(const formats::MeshFile& mesh) {
  std::vector<std::uint8_t> used(mesh.positions.size(), 0);
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t corner : t) used[corner] = 1;
  return static_cast<std::uint64_t>(std::count(used.begin(), used.end(), 0));
}

}  // namespace

bool is_float32(ConvertTarget to) { return is_stl(to) || to == ConvertTarget::PlyMesh; }

Result<ConvertTarget> convert_target_of(const std::string& path, bool as_points, bool ascii) {
  const std::string suffix = formats::suffix_of(path);
  const std::span<const std::string_view> written = mesh_suffixes();
  if (std::find(written.begin(), written.end(), suffix) == written.end()) {
    std::string sentence = "found the suffix \"" + suffix + "\"; allowed " + document::joined(written);
    const std::string_view nearest = nearest_name(suffix, written);
    if (!nearest.empty()) sentence += "; nearest " + std::string(nearest);
    return fail(Code::BadUsage, std::move(sentence), path);
  }
  if (as_points) {
    if (suffix == "ply") return ConvertTarget::PlyPoints;
    return fail(Code::BadUsage, "a ." + suffix + " file holds faces, the input has none; write the points to a .ply",
                path);
  }
  if (suffix == "stl") return ascii ? ConvertTarget::StlAscii : ConvertTarget::StlBinary;
  if (format_of_suffix(suffix) == "iges") return ConvertTarget::Iges;
  if (suffix == "dxf") return ConvertTarget::Dxf;
  if (suffix == "3mf") return ConvertTarget::ThreeMf;
  return suffix == "obj" ? ConvertTarget::Obj : ConvertTarget::PlyMesh;
}

std::vector<std::string> conversion_losses(const formats::MeshFile& mesh, ConvertTarget to, double unit_mm) {
  std::vector<std::string> losses;
  const bool points = to == ConvertTarget::PlyPoints;
  if (points && !mesh.triangles.empty())
    losses.push_back(grouped(mesh.triangles.size()) + " triangles: a cloud holds points only");
  if (!points && mesh.polygons_split > 0)
    losses.push_back(grouped(mesh.polygons_split) + " faces of more than three corners become triangles");
  if (mesh.faces_left_out > 0) losses.push_back(grouped(mesh.faces_left_out) + " faces of fewer than three corners");
  if (!mesh.patch.empty() && (points || is_stl(to)))
    losses.push_back("the patch ids of " + grouped(mesh.patch.size()) + " triangles");
  if (!(mesh.error.empty() && mesh.error_rms.empty()) && !is_ply_mesh(to))
    losses.push_back("the errors of " + grouped(mesh.positions.size()) + " vertices");
  if (is_stl(to)) {
    if (const std::uint64_t unused = unused_vertices(mesh); unused > 0)
      losses.push_back(grouped(unused) + " vertices that no face uses");
    if (mesh.format.substr(0, 3) != "stl" && !mesh.triangles.empty())
      losses.push_back("which corners share a vertex: readers join those with equal coordinates");
  }
  for (const std::string& property : mesh.properties) losses.push_back(property);
  if (!mesh.comments.empty() && !is_ply_mesh(to) && !points) losses.push_back(counted(mesh.comments.size(), "comment"));
  if (mesh.offset && !(*mesh.offset == Vec3{}) && (to == ConvertTarget::StlBinary || points))
    losses.push_back("the offset " + number_text(mesh.offset->x) + " " + number_text(mesh.offset->y) + " " +
                     number_text(mesh.offset->z) + " mm, which must be added for the global frame");
  if (is_float32(to)) add_rounding(mesh, unit_mm, losses);
  return losses;
}

std::vector<std::string> conversion_losses(const formats::ViewHeader& cloud, ConvertTarget to) {
  std::vector<std::string> losses;
  if (cloud.has_faces && to == ConvertTarget::PlyPoints) losses.push_back("the faces: a cloud holds points only");
  if (cloud.has_grid) losses.push_back("the rows and columns of the range grid");
  losses.insert(losses.end(), cloud.notes.begin(), cloud.notes.end());
  losses.push_back(
      "every property of the points but their position (colours, normals, intensities), if there were any");
  return losses;
}

}  // namespace scanmill::pipeline
