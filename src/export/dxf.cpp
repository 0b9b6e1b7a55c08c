// SPDX-License-Identifier: Apache-2.0
// DXF is a list of pairs: a group code on one line, its value on the next.
#include "export/dxf.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <iterator>

#include "export/little_endian.hpp"

namespace scanmill::exporting {
namespace {

// In the order of patch_colour(): blue, orange, green, magenta, yellow, red, violet, lime, brown, cyan.
constexpr int kColours[] = {5, 30, 3, 6, 2, 1, 190, 70, 34, 4};

}  // namespace

int dxf_colour(std::uint32_t patch) { return kColours[patch % std::size(kColours)]; }

void DxfWriter::group(int code, std::string_view value) { out_.number(code).text("\n").text(value).text("\n"); }

void DxfWriter::group(int code, std::int64_t value) { out_.number(code).text("\n").number(value).text("\n"); }

void DxfWriter::real(int code, double value) {
  const double v = without_minus_zero(value), size = std::abs(v);
  std::array<char, 64> text;
  const bool plain = size == 0 || (size > 1e-9 && size < 1e15);
  const auto end = plain ? std::to_chars(text.data(), text.data() + text.size(), v, std::chars_format::fixed).ptr
                         : std::to_chars(text.data(), text.data() + text.size(), v).ptr;
  const std::string_view shown(text.data(), static_cast<std::size_t>(end - text.data()));
  out_.number(code).text("\n").text(shown);
  if (shown.find_first_of(".e") == std::string_view::npos) out_.text(".0");
  out_.text("\n");
}

void DxfWriter::place(int first_code, Vec3 p) {
  real(first_code, p.x);
  real(first_code + 10, p.y);
  real(first_code + 20, p.z);
}

Result<void> DxfWriter::begin(const Bounds& bounds, std::span<const DxfLayer> layers,
                              std::span<const std::string> comments) {
  for (const std::string& comment : comments) group(999, comment);
  group(0, "SECTION");
  group(2, "HEADER");
  group(9, "$ACADVER");
  group(1, "AC1009");
  group(9, "$INSBASE");
  place(10, {});
  group(9, "$EXTMIN");
  place(10, bounds.empty() ? Vec3{} : bounds.low);
  group(9, "$EXTMAX");
  place(10, bounds.empty() ? Vec3{} : bounds.high);
  group(9, "$MEASUREMENT");
  group(70, std::int64_t{1});
  group(9, "$INSUNITS");
  group(70, std::int64_t{4});  // millimetres
  group(0, "ENDSEC");
  group(0, "SECTION");
  group(2, "TABLES");
  group(0, "TABLE");
  group(2, "LTYPE");
  group(70, std::int64_t{1});
  group(0, "LTYPE");
  group(2, "CONTINUOUS");
  group(70, std::int64_t{0});
  group(3, "Solid line");
  group(72, std::int64_t{65});
  group(73, std::int64_t{0});
  real(40, 0);
  group(0, "ENDTAB");
  group(0, "TABLE");
  group(2, "LAYER");
  group(70, static_cast<std::int64_t>(layers.size()));
  for (const DxfLayer& layer : layers) {
    group(0, "LAYER");
    group(2, layer.name);
    group(70, std::int64_t{0});
    group(62, std::int64_t{layer.colour});
    group(6, "CONTINUOUS");
    TRY(out_.flush_when_full());
  }
  group(0, "ENDTAB");
  group(0, "ENDSEC");
  group(0, "SECTION");
  group(2, "ENTITIES");
  return out_.flush_when_full();
}

Result<void> DxfWriter::face(std::string_view layer, Vec3 a, Vec3 b, Vec3 c) {
  group(0, "3DFACE");
  group(8, layer);
  place(10, a);
  place(11, b);
  place(12, c);
  place(13, c);
  return out_.flush_when_full();
}

Result<void> DxfWriter::polyline(std::string_view layer, std::span<const Vec3> points, bool closed) {
  group(0, "POLYLINE");
  group(8, layer);
  group(66, std::int64_t{1});
  place(10, {});
  group(70, std::int64_t{closed ? 9 : 8});
  for (const Vec3& p : points) {
    group(0, "VERTEX");
    group(8, layer);
    place(10, p);
    group(70, std::int64_t{32});
    TRY(out_.flush_when_full());
  }
  group(0, "SEQEND");
  group(8, layer);
  return out_.flush_when_full();
}

Result<void> DxfWriter::line(std::string_view layer, Vec3 from, Vec3 to) {
  group(0, "LINE");
  group(8, layer);
  place(10, from);
  place(11, to);
  return out_.flush_when_full();
}

Result<void> DxfWriter::point(std::string_view layer, Vec3 p) {
  group(0, "POINT");
  group(8, layer);
  place(10, p);
  return out_.flush_when_full();
}

Result<void> DxfWriter::text(std::string_view layer, Vec3 p, double height, std::string_view words) {
  group(0, "TEXT");
  group(8, layer);
  place(10, p);
  real(40, height);
  group(1, words);
  return out_.flush_when_full();
}

Result<void> DxfWriter::polyface(std::string_view layer, std::span<const Vec3> vertices,
                                 std::span<const Triangle> triangles) {
  group(0, "POLYLINE");
  group(8, layer);
  group(66, std::int64_t{1});
  place(10, {});
  group(70, std::int64_t{64});
  group(71, static_cast<std::int64_t>(vertices.size()));
  group(72, static_cast<std::int64_t>(triangles.size()));
  for (const Vec3& p : vertices) {
    group(0, "VERTEX");
    group(8, layer);
    place(10, p);
    group(70, std::int64_t{192});
    TRY(out_.flush_when_full());
  }
  for (const Triangle& t : triangles) {
    group(0, "VERTEX");
    group(8, layer);
    place(10, {});
    group(70, std::int64_t{128});
    for (int corner = 0; corner < 3; ++corner)
      group(71 + corner, std::int64_t{t[static_cast<std::size_t>(corner)]} + 1);
    TRY(out_.flush_when_full());
  }
  group(0, "SEQEND");
  group(8, layer);
  return out_.flush_when_full();
}

Result<void> DxfWriter::end() {
  group(0, "ENDSEC");
  group(0, "EOF");
  return out_.flush();
}

}  // namespace scanmill::exporting
