// SPDX-License-Identifier: Apache-2.0
// The 3-D view as bytes: what a browser is given says what the mesh is, in little room. How it looks and turns is
// tested in a browser (tests/jobs/report_in_browser.py).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/digest.hpp"
#include "base/random.hpp"
#include "report/view_script.hpp"
#include "sample.hpp"

namespace scanmill::report {
namespace {

std::string page_of(const ScanReport& report) {
  std::string bytes;
  auto sink = memory_sink("report.html", bytes);
  EXPECT_TRUE(write_scan_report(report, *sink).ok());
  EXPECT_TRUE(sink->commit().ok());
  return bytes;
}

std::string between(const std::string& page, const std::string& before, const std::string& after) {
  const std::size_t at = page.find(before);
  if (at == std::string::npos) return "";
  return page.substr(at + before.size(), page.find(after, at + before.size()) - at - before.size());
}

std::string from_base64(const std::string& text) {
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t group = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    group = group << 6 | static_cast<std::uint32_t>(letters.find(c));
    if ((bits += 6) >= 8) bytes += static_cast<char>(group >> (bits -= 8) & 255);
  }
  return bytes;
}

/// Reads as the comment in src/report/view.cpp says, not as its code does.
class Reader {
 public:
  explicit Reader(std::string bytes) : bytes_(std::move(bytes)) {}
  std::uint32_t byte() { return at_ < bytes_.size() ? static_cast<unsigned char>(bytes_[at_++]) : (++at_, 0u); }
  double share() {
    const std::uint32_t low = byte();
    return (low + 256 * byte()) / 65535.0;
  }
  std::int64_t difference() {
    std::int64_t value = 0, place = 1;
    for (std::uint32_t part = 128; part >= 128; place *= 128) {
      part = byte();
      value += (part % 128) * place;
    }
    return value % 2 == 1 ? -(value + 1) / 2 : value / 2;
  }
  bool at_end() const { return at_ == bytes_.size(); }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

TEST(View, HoldsTheMesh) {
  ScanReport report = bare_report();
  report.view = sample_view(40, 25);
  report.view->errors[7] = NAN;
  report.view->errors[8] = 9;
  report.view->errors[9] = -9;
  report.view->errors[10] = 0;
  const SurfaceView& view = *report.view;
  const std::string page = page_of(report);
  EXPECT_EQ(between(page, "data-triangles=\"", "\""), "2000");
  Reader in(from_base64(between(page, "id=\"view-data\">", "</script>")));
  Bounds box;
  for (const Vec3& p : view.positions) box.add(p);
  const Vec3 size = box.size();
  for (const Vec3& p : view.positions) {
    EXPECT_NEAR(box.low.x + in.share() * size.x, p.x, size.x / 65535 * 0.501);
    EXPECT_NEAR(box.low.y + in.share() * size.y, p.y, size.y / 65535 * 0.501);
    EXPECT_NEAR(box.low.z + in.share() * size.z, p.z, size.z / 65535 * 0.501);
  }
  std::int64_t last = 0;
  for (const auto& x : view.triangles) {
    const std::int64_t a = last + in.difference(), b = a + in.difference(), c = b + in.difference();
    last = a;
    ASSERT_EQ((std::array<std::int64_t, 3>{a, b, c}), (std::array<std::int64_t, 3>{x[0], x[1], x[2]}));
  }
  for (const std::uint32_t patch : view.patch) ASSERT_EQ(in.byte(), patch % view.patch_colours.size());
  for (std::size_t v = 0; v < view.errors.size(); ++v) {
    const std::uint32_t code = in.byte();
    if (v == 7 || v == 10) {
      EXPECT_EQ(code, v == 7 ? 0u : 128u) << "not known; none is the middle of the scale";
    } else if (std::abs(view.errors[v]) > 0.5) {
      EXPECT_EQ(code, view.errors[v] > 0 ? 255u : 1u);
    } else {
      EXPECT_NEAR(error_of_code(code) * 0.5, view.errors[v], 0.5 / 126 * 0.501);
    }
  }
  last = 0;
  for (const auto& [a, b] : view.open_edges) {
    last += in.difference();
    EXPECT_EQ(last, a);
    EXPECT_EQ(last + in.difference(), b);
  }
  EXPECT_TRUE(in.at_end());
}

TEST(View, LetsRunItsOwnScriptOnly) {
  const std::string page = page_of(sample_report());
  const std::string script = between(page, "<script>", "</script>");
  EXPECT_EQ(script, kViewScript);
  const std::string digest = from_base64(between(page, "script-src 'sha256-", "'"));
  std::string hex;
  for (const char c : digest) {
    hex += "0123456789abcdef"[static_cast<unsigned char>(c) >> 4];
    hex += "0123456789abcdef"[static_cast<unsigned char>(c) & 15];
  }
  EXPECT_EQ(hex, sha256_hex(script));
  EXPECT_EQ(page_of(bare_report()).find("script-src"), std::string::npos);
}

TEST(View, StandsBesideItsPicture) {
  ScanReport report = sample_report();
  std::string page = page_of(report);
  const std::size_t view = page.find("id=\"view\""), picture = page.find("<figure>"),
                    pictures = page.find("id=\"pictures\"");
  EXPECT_LT(view, picture);
  EXPECT_LT(picture, pictures);
  report.pictures.resize(1);
  page = page_of(report);
  EXPECT_EQ(page.find("id=\"pictures\""), std::string::npos);
  EXPECT_EQ(page.find("#pictures"), std::string::npos);
  report.pictures.clear();
  page = page_of(report);
  EXPECT_NE(page.find("The 3-D view needs JavaScript.</p></noscript>"), std::string::npos);
  EXPECT_EQ(page.find("Coarser"), std::string::npos);
  report.view->full_triangles = 3000000;
  report.view->cell_mm = 0.25;
  EXPECT_NE(page_of(report).find("1,200 of 3,000,000 triangles. Of the vertices in one cell of a grid of 0.25 mm"),
            std::string::npos);
}

TEST(View, NeedsLittleRoomEvenForAMeshInDisorder) {
  ScanReport report = bare_report();
  const std::size_t bare = page_of(report).size();
  report.view = sample_view(500, 100);  // 100,000 triangles
  const std::size_t in_order = page_of(report).size() - bare;
  EXPECT_LT(in_order, 1'500'000u);
  std::vector<std::uint32_t> row(report.view->positions.size());
  std::iota(row.begin(), row.end(), 0u);
  Random random(5, 0, 0);
  for (std::size_t n = row.size() - 1; n > 0; --n) std::swap(row[n], row[random.next() % (n + 1)]);
  for (auto& x : report.view->triangles)
    for (std::uint32_t& corner : x) corner = row[corner];
  EXPECT_LT(page_of(report).size() - bare, 2'000'000u);
}

TEST(View, SurvivesMeshesOfNoSize) {
  ScanReport report = bare_report();
  report.view = sample_view(3, 3);
  for (Vec3& p : report.view->positions) p = {4e6, -7, 0};
  EXPECT_EQ(page_of(report).find("nan"), std::string::npos);
  report.view = SurfaceView();
  EXPECT_NE(page_of(report).find("data-triangles=\"0\""), std::string::npos);
}

TEST(View, RefusesListsThatDoNotBelongTogether) {
  for (const int fault : {0, 1, 2, 3}) {
    ScanReport report = sample_report();
    if (fault == 0) report.view->patch.pop_back();
    if (fault == 1) report.view->errors.pop_back();
    if (fault == 2) report.view->triangles[5][1] = 651;
    if (fault == 3) report.view->open_edges[2].second = 651;
    std::string bytes;
    auto sink = memory_sink("report.html", bytes);
    const auto result = write_scan_report(report, *sink);
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().code, Code::Internal);
  }
}

}  // namespace
}  // namespace scanmill::report
