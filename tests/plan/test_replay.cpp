// SPDX-License-Identifier: Apache-2.0
#include "base/random.hpp"
#include "machines.hpp"
#include "plan/band.hpp"
#include "plan/motion.hpp"

namespace scanmill::plan {
namespace {

std::vector<std::string> kinds_of(const Replay& replay) {
  std::vector<std::string> kinds;
  for (const Step& step : replay.steps)
    for (const Finding& finding : step.state.findings) kinds.push_back(finding.kind);
  return kinds;
}

std::string only_text(const Replay& replay) {
  std::string text;
  for (const Step& step : replay.steps)
    for (const Finding& finding : step.state.findings) text += (text.empty() ? "" : "\n") + finding.text;
  return text;
}

TEST(MachineFiles, AreSoundAndReadBackToTheSame) {
  for (const char* name : {"bradley", "turntable", "gantry", "fixed"}) {
    const ScanPlan plan = machine_file(name);
    const Replay played = replay(plan);
    EXPECT_EQ(only_text(played), "") << name;
    const std::string text = document::to_yaml(to_document(plan));
    const auto again = plan_of_text(text);
    ASSERT_TRUE(again.ok()) << again.error().text() << text;
    EXPECT_EQ(document::to_yaml(to_document(*again)), text);
    ASSERT_EQ(again->stations.size(), plan.stations.size());
    for (std::size_t s = 0; s < plan.stations.size(); ++s) EXPECT_EQ(again->stations[s].pose, plan.stations[s].pose);
  }
}

TEST(Replay, NamesStationJointValueAndLimit) {
  EXPECT_EQ(only_text(replay(with_stations("bradley", {at_joints("far", {751, 250, 240, 0, -90})}))),
            "station far: joint x at 751 mm is beyond its limit of 750 mm");
  EXPECT_EQ(
      only_text(replay(with_stations("bradley", {at_counts("low", {150000, 100000, -96100, 0, 0})}))).substr(0, 70),
      "station low: joint z at -0.25 mm is beyond its limit of 0 mm\nstation l");
  EXPECT_EQ(
      only_text(replay(with_stations("gantry", {at_joints("up", {600, 400, 400, 0, 25})}))),
      "station up: joint b at 25 deg is beyond its limit of 20 deg\n"
      "station up: the sensor looks 24.9996 deg above the horizontal; the limit is 20 deg (machine.max_elevation_deg)");
}

TEST(Replay, NamesTheLimitThatForbidsAPose) {
  Station station;
  station.name = "pole";
  station.target = Target{{0, 0, 30}, {0, 0, 1}, {}};
  const Replay played = replay(with_stations("bradley", {station}));
  ASSERT_EQ(kinds_of(played), std::vector<std::string>{"unreachable"});
  EXPECT_EQ(only_text(played), "station pole: unreachable: joint z would have to go to 260 mm, its limit is 240 mm");
  EXPECT_EQ(played.totals.errors, 1u);
}

TEST(Replay, ReportsAPoseThatTheCountsDoNotConfirm) {
  ScanPlan plan = with_stations("bradley", {at_joints("a", {375, 250, 240, 0, -90})});
  plan.stations[0].counts = std::vector<std::int64_t>{150000, 100000, 0, 0, -9000};
  plan.stations[0].given_pose = settle(plan)[0].at.view;
  EXPECT_EQ(only_text(replay(plan)), "");
  plan.stations[0].given_pose->translation.x += 0.04;
  EXPECT_EQ(only_text(replay(plan)), "");
  plan.stations[0].given_pose->translation.x += 0.06;
  EXPECT_EQ(kinds_of(replay(plan)), std::vector<std::string>{"pose_differs"});
  EXPECT_NE(only_text(replay(plan)).find("lies 0.1 mm and 0 deg from the one of the counts"), std::string::npos);
  EXPECT_EQ(replay(plan).totals.warnings, 1u);
  plan.stations[0].given_pose.reset();
  plan.stations[0].counts = std::vector<std::int64_t>{150040, 100000, 0, 0, -9000};
  EXPECT_EQ(only_text(replay(plan)),
            "station a: joint x was told to go to 375 mm and its counts say 375.1, 0.1 mm off; allowed 0.01");
}

TEST(Replay, SeesTheHeadMeetThePartOnTheWay) {
  // From one side of the part to the other, level: the straight way leads through it.
  const ScanPlan plan =
      with_stations("bradley", {at_joints("left", {185, 250, 40, 0, 0}), at_joints("right", {565, 250, 40, 180, 0})});
  const Replay played = replay(plan);
  ASSERT_FALSE(played.steps[1].state.findings.empty());
  EXPECT_EQ(played.steps[1].state.findings[0].kind, "collision");
  EXPECT_NE(only_text(played).find("station right: on the way there the head meets"), std::string::npos);
}

TEST(Replay, AddsTimesAndWays) {
  const ScanPlan plan =
      with_stations("bradley", {at_joints("a", {100, 0, 240, 0, 0}), at_joints("b", {100, 100, 240, 0, 0})});
  const Replay played = replay(plan);
  EXPECT_NEAR(*played.steps[0].time_s, 100.0 / 50 + 50.0 / 200 + 2, 1e-12);
  EXPECT_NEAR(*played.steps[1].begin_s, *played.steps[0].time_s, 1e-12);
  EXPECT_NEAR(*played.totals.time_s, 2 * *played.steps[0].time_s, 1e-12);
  EXPECT_NEAR(played.totals.path_mm, 200, 1e-9);
  EXPECT_NEAR(played.totals.travel[0], 100, 1e-9);
  EXPECT_NEAR(played.totals.travel[1], 100, 1e-9);
}

TEST(CountBand, TellsPointsOutsideBandAndField) {
  Sensor sensor;
  sensor.noise_mm = 0;
  std::vector<Vec3> points{{0, 0, 150}, {24.9, 24.9, 150}, {0, 0, 134.9}, {0, 0, 165.5}, {26, 0, 150}};
  BandCounts counts;
  count_band(sensor, points, counts);
  EXPECT_EQ(counts.points, 5u);
  EXPECT_EQ(counts.too_near, 1u);
  EXPECT_EQ(counts.too_far, 1u);
  EXPECT_EQ(counts.beside, 1u);
  EXPECT_EQ(counts.nearest_mm, 134.9);
  EXPECT_EQ(counts.farthest_mm, 165.5);
  const auto findings = band_findings(sensor, "s1", counts);
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].severity, Severity::Error);
  EXPECT_EQ(findings[0].text,
            "station s1: 2 of 5 points lie outside the sensor's depth band of 135 to 165 mm (found 134.9 to 165.5 mm)");
  EXPECT_EQ(findings[0].limit, 165);
  counts.points = 1000;
  EXPECT_EQ(band_findings(sensor, "s1", counts)[0].severity, Severity::Warning);
  EXPECT_TRUE(band_findings(sensor, "s1", BandCounts{}).empty());
}

TEST(PlanFrom, NamesWhatIsWrongWithAMachine) {
  const auto plan = plan_of_text(
      "scanmill_plan: 1\n"
      "machine:\n"
      "  joints:\n"
      "    - {name: x, type: linear, axis: [1, 0, 0], limits: [5, 1], counts_per_rev: 2000}\n"
      "    - {name: x, type: rotory, axis: [0, 0, 0], lead_mm: -1}\n"
      "    - {type: rotary, axis: [0, 0, 1], lead_mm: 4, gear: 0, velocty: 3}\n"
      "stations:\n"
      "  - {name: s, counts: {x: 1.5, y: 2}}\n"
      "  - {name: t, target: {point: [0, 0, 0]}}\n"
      "  - {name: u, joints: {x: 1}}\n");
  ASSERT_FALSE(plan.ok());
  const std::string text = plan.error().text();
  for (const char* line :
       {"plan.yaml:4:56: machine.joints[0].limits: found a low limit above the high one; allowed [low, high]",
        "machine.joints[0].lead_mm: found nothing; allowed mm per turn of the screw",
        "machine.joints[1].type: found rotory; allowed linear, rotary; nearest rotary",
        "machine.joints[1].axis: found no direction", "machine.joints[1].lead_mm: found -1; allowed [0, 1",
        "machine.joints[1].name: found x, the name of an earlier joint", "machine.joints[2].name: found nothing",
        "machine.joints[2].velocty: found an unknown key", "nearest velocity",
        "machine.joints[2].gear: found 0; allowed [1e-06, 1e+06]",
        "machine.joints[2].lead_mm: found 4 on a rotary joint",
        "stations[0].counts.x: found 1.5; allowed a whole number", "stations[0].counts.y: found an unknown key",
        "stations[1].target.normal: found nothing"})
    EXPECT_NE(text.find(line), std::string::npos) << line << "\n" << text;
}

TEST(PlanFrom, BearsWildNumbers) {
  const std::string machine =
      "scanmill_plan: 1\nmachine: {joints: [{name: x, type: linear, axis: [1e-150, 0, 0], limits: [0, 10], lead_mm: "
      "1e-300, counts_per_rev: 1000000000}, {name: a, type: rotary, axis: [0, 0, 1e150], steps_per_rev: 1}]}\n";
  int sound = 0;
  for (const char* station :
       {"joints: {x: 5, a: 1e7}", "joints: {x: -1e300, a: 0}", "joints: {x: .inf, a: 0}",
        "counts: {x: 9007199254740992, a: -9007199254740992}", "counts: {x: 1e30, a: 0}",
        "pose: {eye: [1e300, 0, 0], target: [0, 0, 0]}", "pose: {eye: [1e11, 0, 0], target: [0, 0, 0]}",
        "target: {point: [1e11, 0, 0], normal: [1e-150, 0, 0]}"}) {
    const auto plan =
        plan_of_text(machine + "stations: [{name: s, " + station + "}, {name: t, joints: {x: 0, a: 0}}]\n");
    if (!plan.ok()) continue;
    ++sound;
    const Replay played = replay(*plan);
    EXPECT_TRUE(std::isfinite(played.totals.path_mm)) << station;
    for (const Step& step : played.steps) EXPECT_TRUE(is_finite(step.state.at.view.translation)) << station;
  }
  EXPECT_EQ(sound, 4);
}

}  // namespace
}  // namespace scanmill::plan
