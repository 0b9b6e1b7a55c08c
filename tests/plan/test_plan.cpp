// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <bit>
#include <fstream>
#include <sstream>

#include "base/random.hpp"
#include "plan/plan.hpp"

namespace scanmill::plan {
namespace {

std::string read_file(const std::string& name) {
  std::ostringstream text;
  text << std::ifstream(std::string(SCANMILL_SOURCE_DIR) + "/schemas/" + name).rdbuf();
  return text.str();
}

Result<ScanPlan> plan_of(const std::string& text) {
  auto tree = document::parse_yaml(text, "plan.yaml");
  if (!tree.ok()) return tree.error();
  return plan_from(*tree, "plan.yaml");
}

TEST(PlanFrom, TakesTheValidExample) {
  const auto plan = plan_of(read_file("examples/plan.valid.yaml"));
  ASSERT_TRUE(plan.ok()) << plan.error().text();
  EXPECT_EQ(plan->name, "figurine");
  EXPECT_EQ(plan->units_mm, 1);
  EXPECT_TRUE(plan->has_sensor);
  EXPECT_FALSE(plan->sensor.perspective);
  EXPECT_EQ(plan->sensor.noise_mm, 0.025);
  ASSERT_EQ(plan->stations.size(), 3u);
  EXPECT_EQ(plan->stations[0].data, "views/front.ply");
  EXPECT_EQ(plan->stations[0].sha256->size(), 64u);
  const Vec3 seen = plan->stations[0].pose.apply({0, 0, 150});
  EXPECT_NEAR(norm(seen - Vec3{0, 0, 20}), 0, 1e-12);
  const Vec3 turned = plan->stations[1].pose.apply({1, 0, 0});
  EXPECT_NEAR(norm(turned - Vec3{-150, 1, 20}), 0, 1e-12);
  EXPECT_EQ(plan->stations[2].pose.apply({1, 2, 3}), (Vec3{1, -2, 167}));
  EXPECT_TRUE(plan->stations[2].data.empty());
}

TEST(PlanFrom, ListsEveryProblemOfTheInvalidExample) {
  const auto plan = plan_of(read_file("examples/plan.invalid.yaml"));
  ASSERT_FALSE(plan.ok());
  EXPECT_EQ(plan.error().code, Code::BadParameter);
  EXPECT_EQ(
      plan.error().text(),
      "plan.yaml:2:1: unit: found an unknown key; allowed scanmill_plan, name, units, handedness, camera, machine, "
      "sensor, part, stations; nearest units\n"
      "plan.yaml:1:16: scanmill_plan: found 2; allowed 1\n"
      "plan.yaml:3:8: units: found metres; allowed mm, cm, m, in, um\n"
      "plan.yaml:5:3: sensor.pixel_x: found an unknown key; allowed pixels_x, pixels_y, field_x_mm, field_y_mm, "
      "stand_off_mm, "
      "depth_mm, noise_mm, max_incidence_deg, perspective, frame, mount_offset, body; nearest pixels_x\n"
      "plan.yaml:6:13: sensor.depth_mm: found 0; allowed (0, 1e+06]\n"
      "plan.yaml:9:20: stations[0].pose.matrix: found a list of 3 values; allowed a list of 16 finite numbers\n"
      "plan.yaml:10:11: stations[0].data: found ../front.ply; allowed a file inside the folder of the plan\n"
      "plan.yaml:12:11: stations[1].pose.target: found nothing; allowed a list of 3 finite numbers\n"
      "plan.yaml:13:13: stations[1].sha256: found abc; allowed 64 hexadecimal digits\n"
      "plan.yaml:11:11: stations[1].name: found front, the name of an earlier station; allowed a name of its own");
}

TEST(PlanFrom, RefusesWrongShapes) {
  for (const std::string text :
       {"", "[1]", "scanmill_plan: 1\n", "scanmill_plan: 1\nstations: []\n", "scanmill_plan: 1\nstations: [1]\n",
        "scanmill_plan: 1\nstations: [{name: a}]\n",
        "scanmill_plan: 1\nstations: [{pose: {eye: [0,0,0], target: [0,0,1]}}]\n",
        "scanmill_plan: 1\nstations: [{name: a, pose: {eye: [0,0,0], target: [0,0,0]}}]\n",
        "scanmill_plan: 1\nstations: [{name: a, pose: {quaternion: [0,0,0,0], translation: [0,0,0]}}]\n",
        "scanmill_plan: 1\nstations: [{name: a, pose: {matrix: [1,0,0,0,0,1,0,0,0,0,-1,0,0,0,0,1]}}]\n",
        "scanmill_plan: 1\nstations: [{name: a, pose: {}}]\n",
        "scanmill_plan: 1\nstations: [{name: a, pose: {eye: [0,0,0], target: [0,0,1], matrix: []}}]\n",
        "scanmill_plan: 1\nstations: [{name: a, data: /etc/passwd, pose: {eye: [0,0,0], target: [0,0,1]}}]\n",
        "scanmill_plan: 1\nstations: [{name: a, data: x, pose: {eye: [0,0,0], target: [0,0,1]}}, {name: b, data: ./x, "
        "pose: "
        "{eye: [0,0,0], target: [0,0,1]}}]\n"}) {
    const auto plan = plan_of(text);
    ASSERT_FALSE(plan.ok()) << text;
    EXPECT_EQ(plan.error().text().rfind("plan.yaml:", 0), 0u) << plan.error().text();
  }
}

TEST(ToDocument, ReadsBackToTheSameBits) {
  ScanPlan plan;
  plan.name = "007";
  plan.units_mm = 1000;
  plan.has_sensor = true;
  plan.sensor.noise_mm = 0.1;
  for (std::uint64_t i = 0; i < 200; ++i) {
    Random random(5, i, 1);
    Station station;
    station.name = "station " + std::to_string(i);
    station.data = "views/" + std::to_string(i) + ".ply";
    station.pose = *pose_from_quaternion(random.gauss(), random.gauss(), random.gauss(), random.gauss(),
                                         {random.gauss() * 100, random.gauss(), random.gauss()});
    plan.stations.push_back(station);
  }
  const auto again = plan_of(document::to_yaml(to_document(plan)));
  ASSERT_TRUE(again.ok()) << again.error().text();
  EXPECT_EQ(again->name, plan.name);
  EXPECT_EQ(again->units_mm, plan.units_mm);
  EXPECT_EQ(again->sensor.noise_mm, plan.sensor.noise_mm);
  ASSERT_EQ(again->stations.size(), plan.stations.size());
  for (std::size_t i = 0; i < plan.stations.size(); ++i) {
    EXPECT_EQ(again->stations[i].pose, plan.stations[i].pose) << i;
    EXPECT_EQ(again->stations[i].data, plan.stations[i].data);
  }
  EXPECT_EQ(document::to_yaml(to_document(*again)), document::to_yaml(to_document(plan)));
}

TEST(PlanSchema, KnowsTheSameKeysAsTheReader) {
  const auto schema = document::parse_json(read_file("plan.schema.json"), "plan.schema.json");
  ASSERT_TRUE(schema.ok()) << schema.error().text();
  const document::Node* sensor = schema->find("properties")->find("sensor")->find("properties");
  ASSERT_EQ(sensor->entries().size(), Sensor::fields().size() + 3);  // frame, mount_offset, body
  for (const Field& field : Sensor::fields()) {
    const document::Node* row = sensor->find(field.name);
    ASSERT_NE(row, nullptr) << field.name;
    if (field.words.empty() && !std::holds_alternative<bool* (*)(void*)>(field.member)) {
      EXPECT_EQ(row->find(field.minimum_excluded ? "exclusiveMinimum" : "minimum")->as_number(), field.minimum)
          << field.name;
      EXPECT_EQ(row->find("maximum")->as_number(), field.maximum) << field.name;
    }
  }
  const document::Node* joint = schema->find("definitions")->find("joint")->find("properties");
  ASSERT_EQ(joint->entries().size(), Joint::fields().size() + 4);  // name, axis, origin, limits
  for (const Field& field : Joint::fields()) EXPECT_NE(joint->find(field.name), nullptr) << field.name;
  const document::Node* machine = schema->find("properties")->find("machine")->find("properties");
  ASSERT_EQ(machine->entries().size(), Machine::fields().size() + 4);  // name, joints, part_frame, keep_out
  for (const Field& field : Machine::fields()) EXPECT_NE(machine->find(field.name), nullptr) << field.name;
  // Every key of the schema is one the reader knows: a plan that uses it wrongly is not told "unknown key".
  for (const auto& entry : schema->find("properties")->entries()) {
    const auto plan = plan_of(entry.key + ": {}\n");
    ASSERT_FALSE(plan.ok());
    EXPECT_EQ(plan.error().text().find("unknown key"), std::string::npos) << entry.key;
  }
  for (const auto& unit : schema->find("properties")->find("units")->find("enum")->items())
    EXPECT_TRUE(unit_mm(unit.as_string()).has_value());
}

}  // namespace
}  // namespace scanmill::plan
