// SPDX-License-Identifier: Apache-2.0
// Whole pictures: what each style shows, from where, and what becomes of input that cannot be drawn.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "render/colours.hpp"
#include "render/overlay.hpp"
#include "scenes.hpp"

namespace scanmill::render {
namespace {

PictureParams params_of(Style style, View view = View::Iso) {
  PictureParams p;
  p.style = style;
  p.view = view;
  p.width = 320;
  p.height = 240;
  return p;
}

Image picture(const Scene& scene, const PictureParams& params, int threads = 1) {
  auto result = render(scene, params, Workers(threads).context());
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().text());
  return result.ok() ? *result : Image();
}

constexpr View kViews[] = {View::Iso, View::PlusX, View::MinusX, View::PlusY, View::MinusY, View::PlusZ, View::MinusZ};
constexpr Style kStyles[] = {Style::Points, Style::Wire, Style::Shaded, Style::Patches, Style::Error};

TEST(Axes, AreRightHandedAndTheViewerStandsOnTheNamedSide) {
  for (const View view : kViews) {
    const Axes a = axes_of(view);
    EXPECT_NEAR(norm(cross(a.right, a.up) - a.toward), 0, 1e-15);
    EXPECT_NEAR(norm(a.right), 1, 1e-15);
    EXPECT_NEAR(dot(a.right, a.up), 0, 1e-15);
  }
  EXPECT_EQ(axes_of(View::PlusX).toward, (Vec3{1, 0, 0}));
  EXPECT_EQ(axes_of(View::MinusY).toward, (Vec3{0, -1, 0}));
  EXPECT_EQ(axes_of(View::MinusY).right, (Vec3{1, 0, 0}));
  EXPECT_EQ(axes_of(View::MinusZ).toward, (Vec3{0, 0, -1}));
  EXPECT_GT(axes_of(View::Iso).up.z, 0.8);
}

TEST(Fit, FillsTheBoxFromEverySide) {
  Random random(5, 0, 0);
  for (const View view : kViews) {
    Extent extent{axes_of(view), {100, 200, 300}, {}};
    std::vector<Vec3> points;
    for (int i = 0; i < 200; ++i)
      points.push_back({100 + random.uniform(-9, 9), 200 + random.uniform(-5, 5), 300 + random.uniform(-2, 2)});
    for (const Vec3 p : points) extent.add(p);
    const Box box{10, 20, 300, 200};
    const Projection project = fit(extent, box);
    double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
    for (const Vec3 p : points) {
      const Spot s = project(p);
      left = std::min(left, s.x);
      right = std::max(right, s.x);
      top = std::min(top, s.y);
      bottom = std::max(bottom, s.y);
    }
    EXPECT_GE(left, 10 - 1e-9);
    EXPECT_LE(right, 310 + 1e-9);
    EXPECT_GE(top, 20 - 1e-9);
    EXPECT_LE(bottom, 220 + 1e-9);
    EXPECT_TRUE(std::abs(right - left - 300) < 1e-6 || std::abs(bottom - top - 200) < 1e-6);
    EXPECT_NEAR(left + right, 320, 1e-6);
    EXPECT_NEAR(top + bottom, 240, 1e-6);
  }
}

TEST(Render, GivesTheSameBytesForAnyNumberOfThreads) {
  const Mesh mesh = bumpy_sheet(60, 9);
  std::vector<double> errors;
  for (const Vec3 p : mesh.positions) errors.push_back(p.z - 1);
  const std::vector<Vec3> seeds{{10, 10, 2}, {40, 40, 2}}, removed{{-5, 0, 0}, {70, 10, 3}};
  const Scene scene{&mesh, mesh.positions, removed, errors, seeds};
  for (const Style style : kStyles) {
    const Image one = picture(scene, params_of(style), 1);
    EXPECT_EQ(one, picture(scene, params_of(style), 2));
    EXPECT_EQ(one, picture(scene, params_of(style), 7));
    EXPECT_GT(one.rgb.size() / 3 - pixels_of(one, kPaper), 5000u);
  }
}

TEST(Render, DoesNotDependOnWhereThePartLies) {
  const Mesh mesh = bumpy_sheet(10, 4);
  Mesh moved = mesh, translated = mesh;
  for (Vec3& p : moved.positions) p = {std::floor(p.x * 1024) / 1024, p.y, std::floor(p.z * 1024) / 1024};
  Mesh at_origin = moved;
  for (Vec3& p : moved.positions) p += Vec3{4096, -8192, 1024};
  translated = at_origin;
  translated.offset = {4096, -8192, 1024};
  const std::vector<Vec3> seeds{{4, 4, 2}}, moved_seeds{{4100, -8188, 1026}};
  for (const Style style : {Style::Shaded, Style::Wire, Style::Patches, Style::Points}) {
    const Image expected = picture({&at_origin, {}, {}, {}, seeds}, params_of(style));
    EXPECT_EQ(picture({&moved, {}, {}, {}, moved_seeds}, params_of(style)), expected);
    EXPECT_EQ(picture({&translated, {}, {}, {}, moved_seeds}, params_of(style)), expected);
  }
}

TEST(RenderShaded, ShowsTheInsideInAnotherHueAndOpenEdgesRed) {
  const Mesh closed = box_mesh({6, 4, 3}), open = box_mesh({6, 4, 3}, 2);
  const Image whole = picture({&closed, {}, {}, {}, {}}, params_of(Style::Shaded));
  EXPECT_EQ(orange(whole), 0u);
  EXPECT_EQ(pixels_of(whole, kBoundary), 0u);
  const Image holed = picture({&open, {}, {}, {}, {}}, params_of(Style::Shaded));
  EXPECT_GT(orange(holed), 500u);
  EXPECT_GT(pixels_of(holed, kBoundary), 50u);
  Mesh turned = closed;
  for (Triangle& t : turned.triangles) std::swap(t[1], t[2]);
  const Image inside_out = picture({&turned, {}, {}, {}, {}}, params_of(Style::Shaded));
  EXPECT_EQ(orange(inside_out) > 2000, true);
}

TEST(RenderShaded, LooksAtTheNamedSide) {
  // Only the face at x = 0 is there, outward -x: seen from -x its outside, from +x its inside.
  Mesh mesh = box_mesh({6, 4, 3});
  mesh.triangles.resize(2);
  mesh.patch.resize(2);
  EXPECT_GT(bluish(picture({&mesh, {}, {}, {}, {}}, params_of(Style::Shaded, View::MinusX))), 5000u);
  EXPECT_GT(orange(picture({&mesh, {}, {}, {}, {}}, params_of(Style::Shaded, View::PlusX))), 5000u);
}

TEST(RenderPatches, DrawsBordersAndSeeds) {
  const Mesh mesh = bumpy_sheet(20, 2);
  const std::vector<Vec3> seed{{9, 9, 2}}, none;
  const PictureParams p = params_of(Style::Patches, View::PlusZ);
  const Image with = picture({&mesh, {}, {}, {}, seed}, p), without = picture({&mesh, {}, {}, {}, none}, p);
  EXPECT_NE(with, without);
  EXPECT_GT(pixels_of(with, kInk), pixels_of(without, kInk) + 5);
  Mesh single = mesh;
  single.patch.assign(single.patch.size(), 0);
  EXPECT_LT(pixels_of(picture({&single, {}, {}, {}, none}, p), kInk) + 200, pixels_of(without, kInk));
}

TEST(RenderError, PaintsSignsApartAndNamesTheRange) {
  const Mesh mesh = bumpy_sheet(20, 2);
  std::vector<double> plus(mesh.positions.size(), 0.05), minus(mesh.positions.size(), -0.05);
  PictureParams p = params_of(Style::Error, View::PlusZ);
  p.error_range_mm = 0.05;
  const Image red = picture({&mesh, {}, {}, plus, {}}, p), blue = picture({&mesh, {}, {}, minus, {}}, p);
  EXPECT_GT(bluish(blue), bluish(red) + 5000);
  p.error_range_mm = 0;
  EXPECT_EQ(picture({&mesh, {}, {}, plus, {}}, p), red);
  p.error_range_mm = 0.5;
  EXPECT_NE(picture({&mesh, {}, {}, plus, {}}, p), red);
}

TEST(RenderError, AsksForAnErrorPerVertex) {
  const Mesh mesh = box_mesh({1, 1, 1});
  const Workers workers;
  auto none = render({&mesh, {}, {}, {}, {}}, params_of(Style::Error), workers.context());
  ASSERT_FALSE(none.ok());
  EXPECT_NE(none.error().message.find("verify"), std::string::npos);
  const std::vector<double> few(3, 0.0);
  auto wrong = render({&mesh, {}, {}, few, {}}, params_of(Style::Error), workers.context());
  ASSERT_FALSE(wrong.ok());
  EXPECT_NE(wrong.error().message.find("3 fit errors for 8 vertices"), std::string::npos);
}

TEST(RenderPoints, LeavesFarRemovedPointsOutOfTheFit) {
  std::vector<Vec3> points = bumpy_sheet(30, 1).positions;
  const std::vector<Vec3> near{{-3, 0, 0}}, far{{-3, 0, 0}, {1e7, 0, 0}, {0, NAN, 0}};
  const PictureParams p = params_of(Style::Points, View::PlusZ);
  const Image clean = picture({nullptr, points, near, {}, {}}, p), noisy = picture({nullptr, points, far, {}, {}}, p);
  const Layout layout = layout_of(320, 240, false, 0);
  for (int y = 0; y < static_cast<int>(layout.strip.top); ++y)
    for (int x = 0; x < 320; ++x) ASSERT_EQ(clean.pixel(x, y), noisy.pixel(x, y));
  EXPECT_NE(clean, noisy);  // the caption counts them
  EXPECT_NE(clean, picture({nullptr, points, {}, {}, {}}, p));
}

TEST(Render, DrawsDegenerateScenesWithAMessage) {
  const Mesh empty;
  Mesh point_like;  // triangles without area, all in one place
  point_like.positions.assign(3, {1, 2, 3});
  point_like.triangles = {{0, 1, 2}};
  Mesh line;
  line.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  line.triangles = {{0, 1, 2}};
  const std::vector<Vec3> one{{1, 2, 3}}, lost{{NAN, 0, 0}, {INFINITY, 0, 0}};
  const std::vector<double> zeros(3, 0.0);
  for (const Style style : kStyles)
    for (const View view : kViews) {
      const PictureParams p = params_of(style, view);
      const Image nothing = picture({&empty, {}, {}, {}, {}}, p);
      EXPECT_GT(pixels_of(nothing, kInk), 20u);  // the message
      EXPECT_EQ(picture({nullptr, {}, {}, {}, {}}, p), nothing);
      EXPECT_NE(picture({&point_like, {}, {}, zeros, {}}, p), nothing);
      EXPECT_NE(picture({&line, {}, {}, zeros, {}}, p), nothing);
    }
  const PictureParams p = params_of(Style::Points);
  EXPECT_NE(picture({nullptr, one, {}, {}, {}}, p), picture({nullptr, {}, {}, {}, {}}, p));
  EXPECT_GT(pixels_of(picture({nullptr, lost, {}, {}, {}}, p), kInk), 20u);
}

TEST(Render, LeavesOutWhatIsNotFinite) {
  Mesh mesh = bumpy_sheet(10, 3);
  mesh.positions[55].z = std::numeric_limits<double>::quiet_NaN();
  mesh.positions[3].x = -std::numeric_limits<double>::infinity();
  for (const Style style : {Style::Points, Style::Wire, Style::Shaded, Style::Patches})
    EXPECT_GT(76800 - pixels_of(picture({&mesh, {}, {}, {}, {}}, params_of(style)), kPaper), 3000u);
}

TEST(Render, DrawsHugeAndTinyCoordinates) {
  for (const double scale : {1e-9, 1e9, 1e140}) {
    Mesh mesh = box_mesh(Vec3{6, 4, 3} * scale, 2);
    for (const Style style : {Style::Points, Style::Wire, Style::Shaded, Style::Patches}) {
      const Image image = picture({&mesh, {}, {}, {}, mesh.positions}, params_of(style));
      EXPECT_GT(76800 - pixels_of(image, kPaper), style == Style::Points ? 200u : 10000u) << scale;
    }
  }
}

TEST(Render, RefusesABrokenMeshAndSizesOutOfRange) {
  const Workers workers;
  Mesh mesh = box_mesh({1, 1, 1});
  mesh.triangles[5][2] = 77;
  auto broken = render({&mesh, {}, {}, {}, {}}, params_of(Style::Shaded), workers.context());
  ASSERT_FALSE(broken.ok());
  EXPECT_EQ(broken.error().code, Code::BadInput);
  EXPECT_NE(broken.error().message.find("triangle 5 names vertex 77 of 8"), std::string::npos);
  PictureParams p = params_of(Style::Shaded);
  p.width = 10;
  p.error_range_mm = -1;
  auto small = render({nullptr, {}, {}, {}, {}}, p, workers.context());
  ASSERT_FALSE(small.ok());
  EXPECT_EQ(small.error().code, Code::BadParameter);
  EXPECT_NE(small.error().message.find("width"), std::string::npos);
  EXPECT_NE(small.error().message.find("error_range_mm"), std::string::npos);
}

TEST(Render, ShowsTheTitleAboveThePart) {
  const Mesh mesh = box_mesh({6, 4, 3});
  PictureParams p = params_of(Style::Shaded);
  p.title = "Geh\xc3\xa4use <1> \xe6\x97\xa5 that is much too long for a picture of this width, so that it is cut";
  const Image image = picture({&mesh, {}, {}, {}, {}}, p);
  const Layout layout = layout_of(320, 240, true, 0);
  std::size_t ink = 0;
  for (int y = 0; y < static_cast<int>(layout.part.top); ++y)
    for (int x = 0; x < 320; ++x) ink += image.pixel(x, y) != kPaper;
  EXPECT_GT(ink, 300u);
}

}  // namespace
}  // namespace scanmill::render
