// SPDX-License-Identifier: Apache-2.0
#include "geom/angles.hpp"
#include "machines.hpp"
#include "plan/motion.hpp"
#include "plan/order.hpp"
#include "plan/propose.hpp"
#include "simulate/object.hpp"
#include "simulate/trace.hpp"

namespace scanmill::plan {
namespace {

struct Workers {
  explicit Workers(int threads) : loop(threads) {}
  ChunkLoop loop;
  CancelFlag cancel;
  Context context() const { return {loop, cancel}; }
};

/// Facets and samples straight from a solid: every 8th sample is a facet with the exact normal.
Surface surface_of_object(const simulate::Object& object, double bin_mm, std::size_t samples) {
  Surface surface;
  surface.bin_mm = bin_mm;
  surface.samples = simulate::sample_surface(object, samples, 3);
  for (std::size_t i = 0; i < samples; i += 8)
    surface.facets.push_back({surface.samples[i], simulate::normal_at(object, surface.samples[i])});
  return surface;
}

TEST(FacetsSeen, AgreesWithRaysThroughTheExactSolid) {
  const auto object = *simulate::make_object("figurine");
  const Surface surface = surface_of_object(*object, 1.2, 30000);
  Sensor sensor;
  Bounds box = object->bounds();
  std::size_t both = 0, differ = 0;
  for (const Vec3 eye : {Vec3{0, 0, 156}, Vec3{126, 110, 0}, Vec3{80, -128, 64}, Vec3{-16, 110, 110}}) {
    const Pose view = pose_looking_at(eye, eye * 0.12, {0, 1, 0});
    const auto seen = facets_seen(surface, sensor, view, sine_cosine_of(60).cosine);
    std::vector<std::uint8_t> is_seen(surface.facets.size(), 0);
    for (const std::uint32_t f : seen) is_seen[f] = 1;
    for (std::size_t f = 0; f < surface.facets.size(); ++f) {
      const Facet& facet = surface.facets[f];
      const Vec3 q = view.inverse().apply(facet.point), towards = unit(eye - facet.point);
      bool wanted = dot(towards, facet.normal) >= sine_cosine_of(60).cosine && std::abs(q.z - 150) <= 15 &&
                    std::abs(q.x) * 150 / q.z < 25 && std::abs(q.y) * 150 / q.z < 25;
      if (wanted) {
        const simulate::Ray ray{eye, -towards};
        simulate::Interval range = simulate::clip(ray, box);
        range.low = std::max(range.low, 0.0);
        wanted = simulate::first_crossing(*object, ray, range, 1) > norm(eye - facet.point) - 0.05;
      }
      both += wanted && is_seen[f] != 0;
      differ += wanted != (is_seen[f] != 0);
    }
  }
  EXPECT_GT(both, 2000u);
  EXPECT_LT(static_cast<double>(differ), 0.02 * static_cast<double>(both)) << differ << " of " << both;
}

TEST(SurfaceOf, CoversABoxWithFacetsOfBothSidesOfAThinPlate) {
  const Surface box = *surface_of(mesh_of_box({{0, 0, 0}, {10, 6, 4}}), 1);
  double area = 0;
  for (const Facet& facet : box.facets) {
    EXPECT_NEAR(norm(facet.normal), 1, 1e-12);
    const Vec3 p = facet.point;
    const double off = std::min(
        {std::abs(p.x), std::abs(p.x - 10), std::abs(p.y), std::abs(p.y - 6), std::abs(p.z), std::abs(p.z - 4)});
    EXPECT_LT(off, 1e-9);
    area += 1;
  }
  EXPECT_EQ(area, 2 * (60 + 40 + 24));
  const Surface plate = *surface_of(mesh_of_box({{0.1, 0.1, 0.2}, {9.9, 9.9, 0.4}}), 1);
  std::size_t up = 0, down = 0;
  for (const Facet& facet : plate.facets) {
    up += facet.normal.z > 0.9;
    down += facet.normal.z < -0.9;
  }
  EXPECT_EQ(up, 100u);
  EXPECT_EQ(down, 100u);
  EXPECT_FALSE(surface_of(Mesh{}, 1).ok());
  EXPECT_FALSE(surface_of(mesh_of_box({{0, 0, 0}, {1e5, 1e5, 1}}), 0.01).ok());
}

/// How much a ring of views round the z axis sees: `count` views, their heights by turns -45, 0 and 45 degrees, each as
/// near as the band allows.
std::size_t seen_by_ring(const Surface& surface, const Sensor& sensor, const simulate::Object& object, int count) {
  std::vector<std::uint8_t> seen(surface.facets.size(), 0);
  for (int n = 0; n < count; ++n) {
    const auto [s, c] = sine_cosine_of(360.0 * n / count);
    const auto [up, out] = sine_cosine_of(45.0 * (n % 3 - 1));
    const Vec3 way{c * out, s * out, up};
    double reach = 100;
    while (reach > 0 && object.distance(way * reach) > 0) reach -= 0.5;
    const Pose view = pose_looking_at(way * (reach - 5 + sensor.stand_off_mm), {}, {0, 0, 1});
    for (const std::uint32_t f : facets_seen(surface, sensor, view, sine_cosine_of(60).cosine)) seen[f] = 1;
  }
  return static_cast<std::size_t>(std::count(seen.begin(), seen.end(), 1));
}

TEST(Propose, CoversWhatIsVisibleWithNoMoreStationsThanARing) {
  const ScanPlan rig = [] {
    ScanPlan plan = machine_file("fixed");
    plan.sensor = Sensor{};
    plan.stations.clear();
    plan.part.reset();
    return plan;
  }();
  const Workers workers(2);
  for (const char* name : {"figurine", "handset"}) {
    const auto object = *simulate::make_object(name);
    const Surface surface = surface_of_object(*object, name == std::string("handset") ? 5 : 3, 8000);
    const auto found = propose(rig, surface, {}, workers.context());
    ASSERT_TRUE(found.ok()) << found.error().text();
    EXPECT_GE(static_cast<double>(found->covered), 0.99 * static_cast<double>(found->visible)) << name;
    EXPECT_GE(static_cast<double>(found->visible), 0.97 * static_cast<double>(found->facets)) << name;
    for (const int count : {8, 24}) {
      const std::size_t ring = seen_by_ring(surface, rig.sensor, *object, count);
      ProposeParams params;
      params.coverage = std::min(1.0, static_cast<double>(ring) / static_cast<double>(found->visible));
      const auto same = propose(rig, surface, params, workers.context());
      ASSERT_TRUE(same.ok());
      EXPECT_GE(same->covered, std::min<std::uint64_t>(ring, found->visible));
      EXPECT_LE(same->stations.size(), static_cast<std::size_t>(count)) << name << " ring of " << count;
    }
  }
}

TEST(Propose, StaysWithinTheMachineAndClearOfBodies) {
  ScanPlan rig = machine_file("bradley");
  rig.stations.clear();
  rig.part = Box{{-30, -20, -15}, {30, 20, 15}};
  const Surface surface = *surface_of(mesh_of_box(*rig.part), 2);
  const Workers one(1), seven(7);
  const auto found = propose(rig, surface, {}, one.context());
  ASSERT_TRUE(found.ok()) << found.error().text();
  EXPECT_LT(found->visible, found->facets) << "the bottom cannot be seen from below the horizon's wrong side";
  EXPECT_GE(static_cast<double>(found->covered), 0.99 * static_cast<double>(found->visible));
  ScanPlan planned = rig;
  planned.stations = found->stations;
  const Replay played = replay(planned);
  for (const Step& step : played.steps)
    for (const Finding& finding : step.state.findings) ADD_FAILURE() << finding.text;
  const auto again = propose(rig, surface, {}, seven.context());
  planned.stations = again->stations;
  ScanPlan first = rig;
  first.stations = found->stations;
  EXPECT_EQ(document::to_yaml(to_document(planned)), document::to_yaml(to_document(first)));
}

TEST(Propose, UsesWhatATurntableCanDo) {
  ScanPlan rig = machine_file("turntable");
  rig.part = Box{{-30, -20, 20}, {30, 20, 60}};
  const Surface surface = *surface_of(mesh_of_box(*rig.part), 4);
  const Workers workers(2);
  const auto found = propose(rig, surface, {}, workers.context());
  ASSERT_TRUE(found.ok()) << found.error().text();
  // Four sides and the top; nothing looks at the bottom.
  std::size_t bottom = 0;
  for (const Facet& facet : surface.facets) bottom += facet.normal.z < -0.5;
  EXPECT_EQ(found->visible, found->facets - bottom);
  EXPECT_GE(static_cast<double>(found->covered), 0.99 * static_cast<double>(found->visible));
  EXPECT_LE(found->stations.size(), 8u);
  rig.stations = found->stations;
  EXPECT_EQ(replay(rig).totals.errors, 0u);
}

TEST(Propose, SaysWhenNothingCanBeSeen) {
  ScanPlan rig = machine_file("bradley");
  const Surface surface = *surface_of(mesh_of_box({{5000, 0, 0}, {5010, 10, 10}}), 1);
  const Workers workers(1);
  const auto found = propose(rig, surface, {}, workers.context());
  ASSERT_FALSE(found.ok());
  EXPECT_NE(found.error().message.find("no place from which the sensor sees anything"), std::string::npos);
}

TEST(ShortestWay, IsNoLongerThanAnyOrderOfFewPlaces) {
  ScanPlan rig = machine_file("bradley");
  rig.machine->keep_out.clear();
  rig.part.reset();
  std::vector<std::vector<double>> places{{600, 400, 200, 0, -20},  {100, 50, 220, 90, -40},   {500, 300, 200, 10, -30},
                                          {150, 100, 200, 80, -10}, {300, 250, 240, -90, -90}, {650, 60, 100, 20, -5}};
  const Workers workers(1);
  const auto cost = [&](const std::vector<std::vector<double>>& order) {
    std::vector<double> here;
    for (const Joint& joint : rig.machine->joints) here.push_back(joint.home);
    double sum = 0;
    for (const auto& next : order) {
      sum += cost_of(move_between(*rig.machine, here, next));
      here = next;
    }
    return sum;
  };
  std::vector<std::vector<double>> way;
  for (const Stop& stop : shortest_way(rig, places, workers.context())) {
    EXPECT_FALSE(stop.via);
    way.push_back(stop.joints);
  }
  ASSERT_EQ(way.size(), places.size());
  double least = 1e9, worst = 0;
  std::sort(places.begin(), places.end());
  do {
    least = std::min(least, cost(places));
    worst = std::max(worst, cost(places));
  } while (std::next_permutation(places.begin(), places.end()));
  EXPECT_LE(cost(way), 1.1 * least);
  EXPECT_LT(cost(way), worst);
}

TEST(ShortestWay, DrawsTheHeadBackWhereTheStraightWayIsBlocked) {
  const ScanPlan rig = machine_file("bradley");
  const Workers workers(1);
  // From one side of the part to the other, level.
  const auto way = shortest_way(rig, {{185, 250, 40, 0, 0}, {565, 250, 40, 180, 0}}, workers.context());
  std::size_t via = 0;
  for (const Stop& stop : way) via += stop.via;
  EXPECT_GE(via, 1u);
  ScanPlan planned = rig;
  planned.stations.clear();
  for (const Stop& stop : way) {
    planned.stations.push_back(at_joints("p" + std::to_string(planned.stations.size()), stop.joints));
    planned.stations.back().via = stop.via;
  }
  const Replay played = replay(planned);
  EXPECT_EQ(played.totals.errors, 0u) << (played.steps.back().state.findings.empty()
                                              ? ""
                                              : played.steps.back().state.findings[0].text);
}

}  // namespace
}  // namespace scanmill::plan
