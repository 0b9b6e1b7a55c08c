// SPDX-License-Identifier: Apache-2.0
// Values of a plan's text with every problem noted on the way. Internal to `plan`.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/fields.hpp"
#include "base/text.hpp"
#include "document/document.hpp"
#include "geom/pose.hpp"
#include "plan/machine.hpp"

namespace scanmill::plan {

/// A value for a message: as written, or what kind of thing it is.
std::string found(const document::Node& node);

class Text {
 public:
  explicit Text(const std::string& name) : name_(name) {}

  std::string problems;  // a line each

  void problem(document::Mark mark, const std::string& key, const std::string& what, const std::string& allowed,
               std::string_view nearest = {});
  /// Keys that begin with "x-" are the writer's own.
  void check_keys(const document::Node& map, const std::string& prefix, std::span<const std::string_view> keys);
  std::string text_of(const document::Node& node, const std::string& key);
  /// Reads a value into the member of `field`; `object` is left alone when the value is not allowed.
  template <class T>
  void read_field(const document::Node& value, const std::string& key, const Field& field, T& object) {
    T trial = object;
    if (assign(value, key, field, &trial)) object = std::move(trial);
  }
  /// N finite numbers; false with a problem noted otherwise.
  template <std::size_t N>
  bool read_numbers(const document::Node& node, const std::string& key, std::array<double, N>& out) {
    const std::vector<double> numbers = numbers_of(node, key, N);
    if (numbers.empty()) return false;
    std::copy(numbers.begin(), numbers.end(), out.begin());
    return true;
  }
  bool read_vector(const document::Node& node, const std::string& key, Vec3& out);
  /// In one of the four forms of plan.hpp.
  Pose read_pose(const document::Node& node, const std::string& key);
  Box read_box(const document::Node& node, const std::string& key);
  Machine read_machine(const document::Node& node);

 private:
  bool assign(const document::Node& value, const std::string& key, const Field& field, void* object);
  std::vector<double> numbers_of(const document::Node& node, const std::string& key, std::size_t count);
  Pose read_matrix(const document::Node& node, const std::string& key);
  Pose read_quaternion(const document::Node& node, const document::Node& quaternion, const std::string& key);
  Pose read_angles(const document::Node& node, const document::Node& angles, const std::string& key);
  Pose read_eye(const document::Node& node, const std::string& key);
  Joint read_joint(const document::Node& node, const std::string& key);
  void check_joint(const Joint& joint, const document::Node& node, const std::string& key);
  KeepOut read_keep_out(const document::Node& node, const std::string& key);

  const std::string& name_;
};

document::Node triple(Vec3 v);
document::Node pose_node(const Pose& pose);
document::Node box_node(const Box& box);
document::Node machine_node(const Machine& machine);

}  // namespace scanmill::plan
