// SPDX-License-Identifier: Apache-2.0
#include "export/poses.hpp"

#include <cmath>

#include "base/text.hpp"
#include "geom/angles.hpp"

namespace scanmill::exporting {
namespace {

std::string rows_of(const Pose& pose) {
  const auto m = pose.matrix();
  std::string text;
  for (std::size_t i = 0; i < 16; ++i) text += number_text(m[i]) + (i % 4 == 3 ? "\n" : " ");
  return text;
}

double signed_degrees(double sine, double cosine) {
  const double angle = degrees_of(std::abs(sine), cosine);
  return sine < 0 ? -angle : angle;
}

}  // namespace

Result<std::string> conf_text(std::span<const PosedFile> views) {
  std::string text = "camera 0 0 0 0 0 0 1\n";
  for (const PosedFile& view : views) {
    if (view.file.find_first_of(" \t") != std::string::npos)
      return fail(Code::BadParameter,
                  "the file name '" + view.file + "' holds a blank, which a .conf cannot say; rename it");
    const auto q = quaternion_of(view.pose.inverse());  // the format turns by the transposed rotation
    const Vec3 t = view.pose.translation;
    text += "bmesh " + view.file;
    for (const double value : {t.x, t.y, t.z, q[0], q[1], q[2], q[3]}) text += " " + number_text(value);
    text += "\n";
  }
  return text;
}

std::string aln_text(std::span<const PosedFile> views) {
  std::string text = std::to_string(views.size()) + "\n";
  for (const PosedFile& view : views) text += view.file + "\n#\n" + rows_of(view.pose);
  return text + "0\n";
}

std::string log_text(std::span<const PosedFile> views) {
  std::string text;
  for (std::size_t i = 0; i < views.size(); ++i)
    text += std::to_string(i) + " " + std::to_string(i) + " " + std::to_string(i + 1) + "\n" + rows_of(views[i].pose);
  return text;
}

std::string matrices_text(std::span<const PosedFile> views) {
  std::string text;
  for (const PosedFile& view : views) text += (text.empty() ? "" : "\n") + rows_of(view.pose);
  return text;
}

std::string dtk_text(const Pose& pose) {
  auto r = pose.rotation;
  for (const std::size_t at : {2u, 5u, 6u, 7u}) r[at] = -r[at];
  // R = Rx Ry Rz: r02 = sin y, r12 = -sin x cos y, r01 = -cos y sin z. Looking along the pole one angle is free.
  const double cos_y = std::sqrt(r[0] * r[0] + r[1] * r[1]);
  const bool pole = cos_y < 1e-12;
  const double y = signed_degrees(r[2], cos_y), x = pole ? signed_degrees(r[7], r[4]) : signed_degrees(-r[5], r[8]);
  const double z = pole ? 0 : signed_degrees(-r[1], r[0]);
  const Vec3 t = pose.translation;
  return number_text(t.x) + " " + number_text(t.y) + " " + number_text(0 - t.z) + "\n" + number_text(x) + " " +
         number_text(y) + " " + number_text(z) + "\n";
}

}  // namespace scanmill::exporting
