// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "base/random.hpp"
#include "refine/refine.hpp"

namespace scanmill::refine {
namespace {

/// A bumpy sheet z = f(x, y), seen from above by views that overlap by half; nothing slides on it unnoticed.
double height(double x, double y) {
  auto bump = [&](double cx, double cy, double r, double h) {
    const double d2 = ((x - cx) * (x - cx) + (y - cy) * (y - cy)) / (r * r);
    return h / ((1 + d2) * (1 + d2));
  };
  return bump(-12, 3, 6, 5) + bump(8, -6, 5, -4) + bump(15, 9, 7, 6) + bump(0, 12, 4, 3) + bump(-4, -11, 6, 4) +
         0.1 * x;
}

Pose above(double x, double y) { return pose_looking_at({x, y, 150}, {x, y, 0}, {0, 1, 0}); }

/// Points of one view, given in its own frame; a block each.
class Views final : public PointSource {
 public:
  std::vector<Pose> told;                   // where the machine says
  std::vector<std::vector<Vec3>> measured;  // in the sensor's frame

  void take(const Pose& told_pose, const Pose& true_pose, double cx, double cy, std::uint64_t seed, double noise) {
    Random random(seed, 0, 0);
    const Pose back = true_pose.inverse();
    std::vector<Vec3> points;
    for (double x = cx - 12; x < cx + 12; x += 0.15)
      for (double y = cy - 12; y < cy + 12; y += 0.15) {
        const double u = x + random.uniform(-0.05, 0.05), v = y + random.uniform(-0.05, 0.05);
        points.push_back(back.apply({u, v, height(u, v) + noise * random.gauss()}));
      }
    told.push_back(told_pose);
    measured.push_back(std::move(points));
  }
  std::size_t block_count() const override { return told.size(); }
  std::uint64_t expected_points() const override { return 0; }
  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    out.clear();
    out.view = ViewId{static_cast<std::uint32_t>(number)};
    out.view_point.eye = told[number].translation;
    for (const Vec3& p : measured[number]) {
      out.positions.push_back(told[number].apply(p));
      out.rows.push_back(out.rows.size());
    }
    return {};
  }
};

Pose off_by(const Pose& pose, Vec3 shift, Vec3 axis, double degrees) {
  Pose off = pose_turned(axis, degrees);
  off.translation = shift;
  return pose.after(off);
}

/// Six views on a 3 x 2 grid; those but the first stand `shift_mm` and `turn_deg` off.
Views sheet(double shift_mm, double turn_deg, double noise = 0.02) {
  Views views;
  Random random(5, 0, 1);
  for (int k = 0; k < 6; ++k) {
    const double x = 10.0 * (k % 3) - 10, y = 10.0 * (k / 3) - 5;
    auto direction = [&] { return unit({random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)}); };
    const Vec3 shift = direction() * shift_mm, axis = direction();
    const Pose pose = above(x, y);
    views.take(pose, off_by(pose, shift, axis, turn_deg), x, y, 10 + static_cast<std::uint64_t>(k), noise);
  }
  return views;
}

Refinement refined(const Views& views, const Accuracy& accuracy, int threads = 1, std::span<const Datum> datums = {}) {
  const ChunkLoop loop(threads);
  const CancelFlag cancel;
  return refine_poses(views, views.told, accuracy, datums, Params{}, {loop, cancel}).value();
}

/// Rms height over the sheet of all points, as placed by these poses.
double rms_off_sheet(const Views& views, std::span<const Pose> poses) {
  double sum = 0, count = 0;
  for (std::size_t v = 0; v < views.measured.size(); ++v)
    for (const Vec3& p : views.measured[v]) {
      const Vec3 at = poses[v].apply(p);
      sum += (at.z - height(at.x, at.y)) * (at.z - height(at.x, at.y));
      count += 1;
    }
  return std::sqrt(sum / count);
}

TEST(RefinePoses, BringsViewsBackOntoEachOther) {
  const Views views = sheet(0.1, 0.05);
  const Refinement result = refined(views, {0.15, 0.08});
  const Report& report = result.report;
  EXPECT_TRUE(report.settled);
  EXPECT_GT(report.before_mm, 0.04);
  EXPECT_LT(report.after_mm, 0.006);
  EXPECT_GE(report.pairs.size(), 11u);
  for (const PairReport& pair : report.pairs) {
    EXPECT_LT(pair.a, pair.b);
    EXPECT_LT(pair.after_mm, 0.02);
  }
  // Of the true sheet only the motion of the whole is left, and that is the mean of six errors.
  EXPECT_LT(rms_off_sheet(views, result.poses), 0.8 * rms_off_sheet(views, views.told));
}

TEST(RefinePoses, LeavesViewsThatFitWhereTheyAre) {
  const Views views = sheet(0, 0);
  const Refinement result = refined(views, {0.15, 0.08});
  for (const ViewReport& view : result.report.views) {
    EXPECT_LT(view.shift_mm, 0.02);  // along the sheet, which is nearly flat
    EXPECT_LT(view.turn_deg, 0.02);
    EXPECT_FALSE(view.at_limit);
  }
}

TEST(RefinePoses, MovesNothingForTheSakeOfNoise) {
  const Views views = sheet(0, 0);
  const Refinement result = refined(views, {0.15, 0.08});
  EXPECT_TRUE(result.report.left);
  EXPECT_EQ(result.poses, views.told);
  EXPECT_EQ(result.report.after_mm, result.report.before_mm);
  EXPECT_GT(result.report.fitted_mm, 0.9 * result.report.before_mm);
  EXPECT_FALSE(refined(sheet(0.1, 0.05), {0.15, 0.08}).report.left);
}

TEST(RefinePoses, KnowsPiecesThatAreTooCoarseForTheSurface) {
  const Views views = sheet(0.1, 0.05);
  const ChunkLoop loop(1);
  const CancelFlag cancel;
  auto with = [&](double edge) {
    Params params;
    params.patch_mm = edge;
    return refine_poses(views, views.told, {0.15, 0.08}, {}, params, {loop, cancel}).value();
  };
  const Refinement fine = with(1), coarse = with(6);
  EXPECT_LT(fine.report.bend_mm, fine.report.noise_mm);
  EXPECT_GT(coarse.report.bend_mm, 10 * coarse.report.noise_mm);
  EXPECT_LT(rms_off_sheet(views, coarse.poses), rms_off_sheet(views, views.told));
}

TEST(RefinePoses, NeverLeavesTheStatedAccuracy) {
  const Views views = sheet(0.3, 0.2);
  const Accuracy accuracy{0.1, 0.05};
  const Refinement result = refined(views, accuracy);
  bool any = false;
  for (std::size_t v = 0; v < views.told.size(); ++v) {
    const PoseGap gap = gap_between(result.poses[v], views.told[v]);
    EXPECT_LE(gap.mm, accuracy.shift_mm * (1 + 1e-9));
    EXPECT_LE(gap.degrees, accuracy.turn_deg * (1 + 1e-6));
    any |= result.report.views[v].at_limit;
  }
  EXPECT_TRUE(any);
  const Refinement still = refined(views, {0, 0});
  for (std::size_t v = 0; v < views.told.size(); ++v) EXPECT_LT(gap_between(still.poses[v], views.told[v]).mm, 1e-12);
}

TEST(RefinePoses, GivesTheSameBitsForAnyNumberOfThreads) {
  const Views views = sheet(0.1, 0.05);
  const Refinement one = refined(views, {0.15, 0.08}, 1);
  for (const int threads : {2, 7}) EXPECT_EQ(one.poses, refined(views, {0.15, 0.08}, threads).poses);
}

TEST(RefinePoses, HoldsTheWholeOnABodyThatIsKnown) {
  // All views are off in the same way, which they cannot notice among themselves; the top of a block in view can.
  Views views;
  Random random(3, 0, 0);
  for (int k = 0; k < 3; ++k) {
    const double x = 8.0 * k - 8;
    const Pose pose = above(x, 0), true_pose = off_by(pose, {0, 0, 0.08}, {1, 0, 0}, 0);
    const Pose back = true_pose.inverse();
    std::vector<Vec3> points;
    for (double u = x - 12; u < x + 12; u += 0.15)
      for (double v = -10; v < 10; v += 0.15) points.push_back(back.apply({u, v, -3 + 0.01 * random.gauss()}));
    views.told.push_back(pose);
    views.measured.push_back(std::move(points));
  }
  const Datum block{pose_shifted({0, 0, -13}), {{-30, -20, 0}, {30, 20, 10}}};
  const Refinement free = refined(views, {0.15, 0.08}), held = refined(views, {0.15, 0.08}, 1, {{block}});
  EXPECT_EQ(free.report.datum_matches, 0u);
  EXPECT_GT(held.report.datum_matches, 100u);
  EXPECT_NEAR(held.report.datum_before_mm, 0.08 * 1.4826, 0.02);  // all the same way: 1.48 times the median
  EXPECT_LT(held.report.datum_after_mm, 0.005);
  // A level face tells height and both tilts, and nothing of the rest.
  EXPECT_EQ(held.report.datum_open, (std::array<bool, 6>{false, false, true, true, true, false}));
  for (const Pose& pose : held.poses) EXPECT_NEAR(pose.translation.z, 150 - 0.08, 0.003);
  for (const Pose& pose : free.poses) EXPECT_NEAR(pose.translation.z, 150, 0.003);
}

TEST(RefinePoses, IgnoresPointsThatBelongToNothing) {
  Views views = sheet(0.1, 0.05);
  Random random(9, 0, 0);
  for (auto& points : views.measured)
    for (std::size_t i = 0; i < points.size(); i += 50) points[i].z += random.uniform(-5, 5);
  EXPECT_LT(refined(views, {0.15, 0.08}).report.after_mm, 0.012);
}

TEST(RefinePoses, NamesACloudWithoutFlatPieces) {
  Views views;
  views.told = {Pose{}, Pose{}};
  Random random(2, 0, 0);
  views.measured.resize(2);
  for (int i = 0; i < 4000; ++i)
    views.measured[static_cast<std::size_t>(i % 2)].push_back(
        {random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(-9, 9)});
  const ChunkLoop loop(1);
  const CancelFlag cancel;
  const auto result = refine_poses(views, views.told, {1, 1}, {}, Params{}, {loop, cancel});
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, Code::BadInput);
  EXPECT_NE(result.error().message.find("flat enough"), std::string::npos);
}

}  // namespace
}  // namespace scanmill::refine
