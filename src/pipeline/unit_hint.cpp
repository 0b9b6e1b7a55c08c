// SPDX-License-Identifier: Apache-2.0
#include "pipeline/unit_hint.hpp"

#include "base/text.hpp"
#include "pipeline/density.hpp"

namespace scanmill::pipeline {
namespace {

constexpr double kAbout = 1.3;  // a cloud is rarely seen from all sides; 10 and 25.4 stay apart

bool is_about(double ratio, double wanted) { return ratio < wanted * kAbout && ratio * kAbout > wanted; }

}  // namespace

Result<void> BoundedPoints::read_block(std::size_t number, PointBlock& out) const {
  TRY(points_.read_block(number, out));
  Bounds box;
  for (const Vec3& p : out.positions) box.add(p);
  if (box.empty()) return {};
  const std::lock_guard lock(mutex_);
  bounds_.add(box.low);
  bounds_.add(box.high);
  return {};
}

std::string unit_hint(const Bounds& mesh, const Bounds& cloud, double units_mm) {
  if (mesh.empty() || cloud.empty()) return {};
  const double mesh_size = norm(mesh.size()), cloud_size = norm(cloud.size());
  if (!(mesh_size > 0) || !(cloud_size > 0)) return {};
  const double ratio = mesh_size / cloud_size;
  if (is_about(ratio, 1)) return {};
  const std::string sizes = "the cloud measures " + number_text(two_digits(cloud_size)) + " mm, the mesh " +
                            number_text(two_digits(mesh_size)) + " mm from corner to corner: ";
  std::string cloud_unit, mesh_unit;
  for (const LengthUnit& unit : kLengthUnits) {
    if (unit.mm != units_mm && is_about(ratio, unit.mm / units_mm)) cloud_unit = unit.word;
    if (unit.mm > 1 && is_about(ratio * unit.mm, 1)) mesh_unit = unit.word;
  }
  std::string remedy = cloud_unit.empty() ? "" : "if the cloud is in " + cloud_unit + ", add --units " + cloud_unit;
  if (!mesh_unit.empty())
    remedy += std::string(remedy.empty() ? "" : "; ") + "if the mesh is in " + mesh_unit +
              ", convert it to mm first (scanmill convert --units " + mesh_unit + ")";
  return remedy.empty() ? remedy : sizes + remedy;
}

}  // namespace scanmill::pipeline
