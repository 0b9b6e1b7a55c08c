// SPDX-License-Identifier: Apache-2.0
#include <bit>

#include "base/random.hpp"
#include "machines.hpp"
#include "plan/motion.hpp"
#include "plan/solve.hpp"

namespace scanmill::plan {
namespace {

const char* const kMachines[] = {"bradley", "turntable", "gantry"};

/// Any setting within the limits; joints without limits within a turn.
std::vector<double> any_joints(const Machine& machine, Random& random) {
  std::vector<double> joints;
  for (const Joint& joint : machine.joints)
    joints.push_back(joint.low ? random.uniform(*joint.low, *joint.high) : random.uniform(-180, 180));
  return joints;
}

TEST(CountsOf, AreExactThereAndBack) {
  for (const char* name : kMachines) {
    const ScanPlan plan = machine_file(name);
    for (const Joint& joint : plan.machine->joints)
      for (std::uint64_t i = 0; i < 3000; ++i) {
        Random random(4, i, 1);
        const auto counts = static_cast<std::int64_t>(random.uniform(-3e6, 3e6));
        for (const int direction : {-1, 1}) {
          const double turns = turns_of(joint, counts);
          const double value = value_of_turns(joint, turns, direction);
          EXPECT_EQ(counts_of(joint, value, direction), counts) << name << " " << joint.name;
          EXPECT_NEAR(turns_of_value(joint, value, direction), turns, 1e-9 * (1 + std::abs(turns)));
        }
      }
  }
}

TEST(CountsOf, BringAnyValueBackWithinHalfACount) {
  for (const char* name : kMachines) {
    const ScanPlan plan = machine_file(name);
    for (std::uint64_t i = 0; i < 3000; ++i) {
      Random random(5, i, 1);
      const std::vector<double> joints = any_joints(*plan.machine, random);
      for (std::size_t k = 0; k < joints.size(); ++k) {
        const Joint& joint = plan.machine->joints[k];
        const double back = value_of(joint, counts_of(joint, joints[k], 1), 1);
        EXPECT_LE(std::abs(back - joints[k]), travel_per_count(joint) * (0.5 + 1e-9)) << joint.name;
      }
    }
  }
}

TEST(Bradley, OneCountOnXMovesEveryPointByLeadOverCountsAndGear) {
  for (std::uint64_t i = 0; i < 30; ++i) {
    Random random(6, i, 1);
    ScanPlan plan = machine_file("bradley");
    Joint& x = plan.machine->joints[0];
    x.gear = i % 2 == 0 ? 1 : 3.5;
    std::vector<std::int64_t> counts{static_cast<std::int64_t>(random.uniform(0, 300000)), 100000, -20000,
                                     static_cast<std::int64_t>(random.uniform(-18000, 18000)), -4000};
    plan.stations = {at_counts("before", counts)};
    ++counts[0];
    plan.stations.push_back(at_counts("after", counts));
    place_stations(plan);
    const double wanted = x.lead_mm / (static_cast<double>(x.counts_per_rev) * x.gear);
    for (const Vec3 p : {Vec3{0, 0, 150}, Vec3{25, -25, 165}, Vec3{-20, 10, 135}}) {
      const Vec3 moved = plan.stations[1].pose.apply(p) - plan.stations[0].pose.apply(p);
      EXPECT_NEAR(moved.x, wanted, 1e-9);
      EXPECT_NEAR(norm(moved), wanted, 1e-9);
    }
  }
}

TEST(Bradley, LooksStraightDownAtThePartFromAbove) {
  // The mount at (375, 250, 300) over the deck, the head 40 mm below it, looking down: in the part's frame at z = 160.
  const ScanPlan plan = with_stations("bradley", {at_joints("above", {375, 250, 240, 0, -90})});
  const std::vector<State> states = settle(plan);
  EXPECT_NEAR(norm(states[0].at.view.translation - Vec3{0, 0, 160}), 0, 1e-12);
  EXPECT_NEAR(norm(states[0].at.view.turn({0, 0, 1}) - Vec3{0, 0, -1}), 0, 1e-15);
  EXPECT_EQ(states[0].counts, (std::vector<std::int64_t>{150000, 100000, 0, 0, -9000}));
  EXPECT_EQ(states[0].turns, (std::vector<double>{75, 50, 0, 0, -22.5}));
  EXPECT_TRUE(states[0].findings.empty());
}

TEST(Turntable, TurnsThePartUnderTheSensor) {
  const ScanPlan plan = with_stations("turntable", {at_joints("a", {0, 0, 0}), at_joints("b", {90, 0, 0})});
  const std::vector<State> states = settle(plan);
  // The table turned anticlockwise by 90 degrees: as the part sees it the sensor went clockwise, from -x to +y.
  EXPECT_NEAR(norm(states[0].at.view.translation - Vec3{-220, 0, 80}), 0, 1e-12);
  EXPECT_NEAR(norm(states[1].at.view.translation - Vec3{0, 220, 80}), 0, 1e-12);
  EXPECT_NEAR(norm(states[1].at.view.turn({0, 0, 1}) - Vec3{0, -1, 0}), 0, 1e-15);
}

TEST(Settle, TakesBacklashFromTheWayAJointCame) {
  ScanPlan plan = with_stations("gantry", {});
  const double b = plan.machine->joints[2].backlash, count = travel_per_count(plan.machine->joints[2]);
  ASSERT_GT(b, 0);
  // home is z = 400 at count 0, reached upwards
  for (const std::int64_t z : {-1000, -2000, -1500, -1500, -1600})
    plan.stations.push_back(at_counts("s" + std::to_string(plan.stations.size()), {0, 0, z, 0, 0}));
  const std::vector<State> states = settle(plan);
  EXPECT_NEAR(states[0].joints[2], 400 - 1000 * count + b, 1e-12);
  EXPECT_NEAR(states[1].joints[2], 400 - 2000 * count + b, 1e-12);
  EXPECT_NEAR(states[2].joints[2], 400 - 1500 * count, 1e-12);
  EXPECT_EQ(states[3].joints[2], states[2].joints[2]) << "a joint that stays keeps its flank";
  EXPECT_NEAR(states[4].joints[2], 400 - 1600 * count + b, 1e-12);
  // The same places commanded as joints give the same counts.
  ScanPlan commanded = plan;
  for (std::size_t s = 0; s < plan.stations.size(); ++s)
    commanded.stations[s] = at_joints(plan.stations[s].name, states[s].joints);
  const std::vector<State> again = settle(commanded);
  for (std::size_t s = 0; s < states.size(); ++s) EXPECT_EQ(again[s].counts, states[s].counts) << s;
}

TEST(Place, DependsOnTheOrderOfTheChainAndOnMountAndOffset) {
  ScanPlan plan = machine_file("bradley");
  const std::vector<double> joints{300, 200, 100, 30, -20};
  const Pose plain = place(*plan.machine, plan.mount, joints).view;
  plan.mount.offset = pose_from_angles({0, 0, 0}, {0.5, 0, 0});
  const Pose shifted = place(*plan.machine, plan.mount, joints).view;
  EXPECT_NEAR(norm(shifted.translation - plain.apply({0.5, 0, 0})), 0, 1e-12);
  std::swap(plan.machine->joints[3], plan.machine->joints[4]);
  const std::vector<double> swapped{300, 200, 100, -20, 30};
  EXPECT_GT(gap_between(place(*plan.machine, plan.mount, swapped).view, shifted).degrees, 1);
}

TEST(BoxesMeet, AgreesWithSamplesOfBothBoxes) {
  int met = 0, apart = 0;
  for (std::uint64_t i = 0; i < 400; ++i) {
    Random random(8, i, 2);
    const Pose frame = pose_from_angles({random.uniform(0, 360), random.uniform(0, 360), random.uniform(0, 360)},
                                        {random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)});
    const Box a{{-1, -0.5, -2}, {1, 0.5, 0.2}}, b{{-1, -1, -1}, {0.5, 1, 1}};
    bool shared = false;
    for (int n = 0; n < 8000 && !shared; ++n) {
      const Vec3 p = frame.apply({-1 + 2 * (n % 20) / 19.0, -0.5 + (n / 20 % 20) / 19.0, -2 + 2.2 * (n / 400) / 19.0});
      shared =
          p.x >= b.low.x && p.x <= b.high.x && p.y >= b.low.y && p.y <= b.high.y && p.z >= b.low.z && p.z <= b.high.z;
    }
    const bool found = boxes_meet(frame, a, Pose{}, b);
    EXPECT_EQ(found, boxes_meet(Pose{}, b, frame, a));
    EXPECT_TRUE(found || !shared) << i;
    met += found;
    apart += !found;
  }
  EXPECT_GT(met, 50);
  EXPECT_GT(apart, 50);
}

TEST(Solve, FindsJointsForEveryPoseTheMachineCanTake) {
  for (const char* name : kMachines) {
    const ScanPlan plan = machine_file(name);
    std::vector<double> home;
    for (const Joint& joint : plan.machine->joints) home.push_back(joint.home);
    for (std::uint64_t i = 0; i < 300; ++i) {
      Random random(7, i, 1);
      const Pose view = place(*plan.machine, plan.mount, any_joints(*plan.machine, random)).view;
      const Solution found = solve(*plan.machine, plan.mount, plan.sensor.stand_off_mm, {view, true}, home);
      EXPECT_EQ(found.reach, Reach::Exact) << name << " " << i << " " << found.miss_mm;
      const PoseGap gap = gap_between(place(*plan.machine, plan.mount, found.joints).view, view);
      EXPECT_LT(gap.mm, 1e-6);
      EXPECT_LT(gap.degrees, 1e-6);
      for (std::size_t k = 0; k < found.joints.size(); ++k)
        if (plan.machine->joints[k].low) {
          EXPECT_GE(found.joints[k], *plan.machine->joints[k].low);
          EXPECT_LE(found.joints[k], *plan.machine->joints[k].high);
        }
    }
  }
}

TEST(Solve, SaysWhatIsMissing) {
  const ScanPlan plan = machine_file("bradley");
  const std::vector<double> home{0, 0, 240, 0, 0};
  const Pose view = place(*plan.machine, plan.mount, std::vector<double>{300, 200, 100, 30, -20}).view;
  const Pose rolled = view.after(pose_turned({0, 0, 1}, 35));
  const Solution roll = solve(*plan.machine, plan.mount, 150, {rolled, true}, home);
  EXPECT_EQ(roll.reach, Reach::RollFree);
  EXPECT_NEAR(roll.roll_deg, 35, 1e-6);
  EXPECT_EQ(solve(*plan.machine, plan.mount, 150, {rolled, false}, home).reach, Reach::Exact);
  const Pose high = place(*plan.machine, plan.mount, std::vector<double>{300, 200, 267.25, 30, -20}).view;
  const Solution beyond = solve(*plan.machine, plan.mount, 150, {high, true}, home);
  EXPECT_EQ(beyond.reach, Reach::OutsideLimits);
  EXPECT_NEAR(beyond.joints[2], 267.25, 1e-6);
  const ScanPlan table = machine_file("turntable");
  const Pose nowhere = pose_looking_at({0, -100, 500}, {0, 0, 0}, {0, 0, 1});
  EXPECT_EQ(solve(*table.machine, table.mount, 220, {nowhere, false}, std::vector<double>{0, 0, 0}).reach,
            Reach::Nowhere);
}

TEST(Move, TakesTheTimeOfATrapezoid) {
  Machine machine;
  machine.joints.resize(2);
  machine.joints[0].velocity = 50;
  machine.joints[0].acceleration = 200;
  machine.joints[1].velocity = 10;
  machine.joints[1].acceleration = 20;
  const std::vector<double> zero{0, 0};
  // 100 mm: 0.25 s to get to 50 mm/s, 6.25 mm each at both ends, the rest at 50 mm/s
  EXPECT_NEAR(*move_between(machine, zero, std::vector<double>{100, 0}).time_s, 100.0 / 50 + 50.0 / 200, 1e-12);
  // 5 mm: never gets to speed
  EXPECT_NEAR(*move_between(machine, zero, std::vector<double>{-5, 0}).time_s, 2 * std::sqrt(5.0 / 200), 1e-12);
  // together: the slower one decides
  EXPECT_NEAR(*move_between(machine, zero, std::vector<double>{100, 40}).time_s, 40.0 / 10 + 10.0 / 20, 1e-12);
  EXPECT_EQ(*move_between(machine, zero, zero).time_s, 0);
  machine.joints[1].velocity.reset();
  EXPECT_FALSE(move_between(machine, zero, std::vector<double>{1, 1}).time_s.has_value());
  EXPECT_TRUE(move_between(machine, zero, std::vector<double>{1, 0}).time_s.has_value());
}

TEST(Move, NeverExceedsVelocityAndAcceleration) {
  const ScanPlan plan = machine_file("bradley");
  for (std::uint64_t i = 0; i < 100; ++i) {
    Random random(11, i, 1);
    const std::vector<double> from = any_joints(*plan.machine, random), to = any_joints(*plan.machine, random);
    const Move move = move_between(*plan.machine, from, to);
    const double dt = *move.time_s / 400;
    std::vector<double> last = from, speed(5, 0);
    for (int k = 1; k <= 400; ++k) {
      const std::vector<double> now = move.at_share(move.share_at(dt * k));
      for (std::size_t j = 0; j < 5; ++j) {
        const double v = (now[j] - last[j]) / dt;
        EXPECT_LE(std::abs(v), *plan.machine->joints[j].velocity * (1 + 1e-6));
        EXPECT_LE(std::abs(v - speed[j]), *plan.machine->joints[j].acceleration * dt * (1 + 1e-6) + 1e-9);
        speed[j] = v;
      }
      last = now;
    }
    for (std::size_t j = 0; j < 5; ++j) EXPECT_EQ(last[j], to[j]);
  }
}

}  // namespace
}  // namespace scanmill::plan
