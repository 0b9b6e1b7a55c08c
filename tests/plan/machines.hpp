// SPDX-License-Identifier: Apache-2.0
// The machines of jobs/machines, and plans made from texts.
#pragma once
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "plan/plan.hpp"

namespace scanmill::plan {

inline std::string text_of_file(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(std::string(SCANMILL_SOURCE_DIR) + "/" + path).rdbuf();
  return text.str();
}

inline Result<ScanPlan> plan_of_text(const std::string& text, const std::string& name = "plan.yaml") {
  auto tree = document::parse_yaml(text, name);
  if (!tree.ok()) return tree.error();
  return plan_from(*tree, name);
}

inline ScanPlan machine_file(const std::string& name) {
  auto plan = plan_of_text(text_of_file("jobs/machines/" + name + ".yaml"), name);
  EXPECT_TRUE(plan.ok()) << (plan.ok() ? "" : plan.error().text());
  return plan.ok() ? *plan : ScanPlan{};
}

/// The machine of a file with these stations in place of its own.
inline ScanPlan with_stations(const std::string& machine, std::vector<Station> stations) {
  ScanPlan plan = machine_file(machine);
  plan.stations = std::move(stations);
  return plan;
}

inline Station at_joints(const std::string& name, std::vector<double> joints) {
  Station station;
  station.name = name;
  station.joints = std::move(joints);
  return station;
}

inline Station at_counts(const std::string& name, std::vector<std::int64_t> counts) {
  Station station;
  station.name = name;
  station.counts = std::move(counts);
  return station;
}

}  // namespace scanmill::plan
