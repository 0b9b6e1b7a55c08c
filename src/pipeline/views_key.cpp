// SPDX-License-Identifier: Apache-2.0
// `views` between the job file and ViewsSpec, and its schema.
#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "pipeline/views.hpp"

namespace scanmill::pipeline {
namespace {

using document::Node;
using document::Problems;
using document::shown;

constexpr std::string_view kKeys[] = {"name", "files", "every", "poses", "pose", "eye", "intrinsics", "depth_scale"};
constexpr double kMostEvery = 1e9;

bool is_scan_name(std::string_view name) {
  const bool safe = std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '_' ||
           c == '/' || c == '-';
  });
  return safe && is_inside(name) && name.front() != '.' && name.back() != '/' &&
         name.find("/.") == std::string_view::npos && name.find("//") == std::string_view::npos;
}

/// One entry being read; `key` is "views[0]".
struct Entry {
  const Node& node;
  const std::string key;
  Problems& problems;

  std::string path(std::string_view name) const {
    return key.empty() ? std::string(name) : key + "." + std::string(name);
  }

  void wrong(const Node& value, std::string_view name, const std::string& allowed) const {
    problems.add(value.mark, path(name), "found " + shown(value) + "; allowed " + allowed);
  }

  std::string text(std::string_view name) const {
    const Node* value = node.find(name);
    if (value == nullptr) return {};
    if (value->is_string()) return value->as_string();
    return value->is_number() ? (value->text.empty() ? document::to_json(*value) : value->text) : std::string();
  }

  /// `count` finite numbers, in one list or in rows of four; empty and a problem otherwise.
  std::vector<double> numbers(const Node& value, std::string_view name, std::size_t count,
                              const std::string& allowed) const {
    std::vector<double> found;
    const auto add = [&](const Node& item) {
      if (item.is_number() && std::isfinite(item.as_number()))
        found.push_back(item.as_number());
      else
        found.resize(count + 1);
    };
    if (value.is_sequence())
      for (const Node& item : value.items()) {
        if (item.is_sequence() && count == 16 && item.items().size() == 4)
          for (const Node& inner : item.items()) add(inner);
        else
          add(item);
      }
    if (found.size() == count) return found;
    wrong(value, name, allowed);
    return {};
  }
};

void read_name(const Entry& entry, ViewsSpec& spec) {
  const Node* value = entry.node.find("name");
  spec.name = entry.text("name");
  if (value == nullptr)
    entry.problems.add(entry.node.mark, entry.key, "found no name; add name: of the scan");
  else if (!is_scan_name(spec.name))
    entry.wrong(*value, "name", "a name of letters, digits, . _ - and / that does not begin with a dot");
}

void read_files(const Entry& entry, ViewsSpec& spec) {
  const Node* value = entry.node.find("files");
  spec.files = entry.text("files");
  if (value == nullptr)
    entry.problems.add(entry.node.mark, entry.key, "found no files; add files: with a pattern such as 'depth/*.png'");
  else if (!is_inside(spec.files))
    entry.wrong(*value, "files", "a pattern of files inside the archive such as 'depth/*.png'");
}

void read_every(const Entry& entry, ViewsSpec& spec) {
  const Node* value = entry.node.find("every");
  if (value == nullptr) return;
  const double every = value->is_number() ? value->as_number() : 0;
  if (every >= 1 && every <= kMostEvery && every == std::floor(every))
    spec.every = static_cast<std::int64_t>(every);
  else
    entry.wrong(*value, "every", "a whole number in [1, 1000000000]");
}

void read_pose_keys(const Entry& entry, ViewsSpec& spec) {
  const Node* file = entry.node.find("poses");
  const Node* pose = entry.node.find("pose");
  if (file != nullptr) {
    spec.poses = entry.text("poses");
    if (!is_inside(spec.poses))
      entry.wrong(*file, "poses", "a file inside the archive: .log, .conf, .aln, .xf or text of 4x4 matrices");
  }
  if (pose == nullptr) return;
  if (file != nullptr)
    return entry.problems.add(pose->mark, entry.key + ".pose", "found both poses and pose; keep one");
  const auto numbers = entry.numbers(*pose, "pose", 16, "a 4x4 matrix: 16 numbers, or four rows of four");
  if (numbers.empty()) return;
  spec.pose.emplace();
  std::copy(numbers.begin(), numbers.end(), spec.pose->begin());
  if (const auto good = pose_from_matrix(*spec.pose); !good.ok())
    entry.problems.add(pose->mark, entry.key + ".pose", good.error().message);
}

void read_eye(const Entry& entry, ViewsSpec& spec) {
  const Node* value = entry.node.find("eye");
  if (value == nullptr) return;
  const auto place =
      entry.numbers(*value, "eye", 3, "three numbers [x, y, z]: where the sensor sat, such as [0, 0, 0]");
  if (!place.empty()) spec.eye = Vec3{place[0], place[1], place[2]};
}

Node described(const char* type, const char* help) {
  Node schema = Node::map();
  schema.set("description", help);
  schema.set("type", type);
  return schema;
}

Node number_list(const char* help, int count) {
  Node schema = described("array", help);
  Node number = Node::map();
  number.set("type", "number");
  schema.set("items", std::move(number));
  schema.set("minItems", count);
  schema.set("maxItems", count);
  return schema;
}

Node pose_schema() {
  Node rows = described("array", "Four rows of four numbers.");
  rows.set("items", number_list("A row.", 4));
  rows.set("minItems", 4);
  rows.set("maxItems", 4);
  Node choices = Node::sequence();
  choices.push(number_list("Row by row.", 16));
  choices.push(std::move(rows));
  Node schema = Node::map();
  schema.set("description",
             "View to global frame, a 4x4 matrix with the translation in the last column, in the units "
             "of the files; excludes poses.");
  schema.set("anyOf", std::move(choices));
  return schema;
}

}  // namespace

std::optional<formats::DepthCamera> read_camera(const Node& map, const std::string& key, Problems& problems) {
  const Entry entry{map, key, problems};
  const Node* value = map.find("intrinsics");
  const Node* scale = map.find("depth_scale");
  if (value == nullptr) {
    if (scale != nullptr)
      problems.add(scale->mark, entry.path("depth_scale"),
                   "found no intrinsics with it; add intrinsics: [fx, fy, cx, cy]");
    return std::nullopt;
  }
  const auto numbers = entry.numbers(*value, "intrinsics", 4, "four numbers [fx, fy, cx, cy] in pixels");
  if (numbers.empty()) return std::nullopt;
  if (numbers[0] == 0 || numbers[1] == 0)
    entry.wrong(*value, "intrinsics", "[fx, fy, cx, cy] with fx and fy other than 0");
  formats::DepthCamera camera{numbers[0], numbers[1], numbers[2], numbers[3]};
  if (scale == nullptr) return camera;
  if (scale->is_number() && scale->as_number() > 0 && std::isfinite(scale->as_number()))
    camera.depth_scale = scale->as_number();
  else
    entry.wrong(*scale, "depth_scale", "a number above 0: pixel values per unit of length");
  return camera;
}

std::vector<ViewsSpec> read_views(const Node& list, Problems& problems) {
  std::vector<ViewsSpec> views;
  if (!list.is_sequence()) {
    problems.add(list.mark, "views", "found " + shown(list) + "; allowed a list of maps with name and files");
    return views;
  }
  for (const Node& item : list.items()) {
    const std::string key = "views[" + std::to_string(views.size()) + "]";
    ViewsSpec& spec = views.emplace_back();
    if (!item.is_map()) {
      problems.add(item.mark, key, "found " + shown(item) + "; allowed a map of " + document::joined(kKeys));
      continue;
    }
    for (const Node::Entry& entry : item.entries())
      if (std::find(std::begin(kKeys), std::end(kKeys), entry.key) == std::end(kKeys) && !entry.key.starts_with("x-"))
        problems.add_unknown(entry, key, kKeys);
    const Entry entry{item, key, problems};
    read_name(entry, spec);
    read_files(entry, spec);
    read_every(entry, spec);
    read_pose_keys(entry, spec);
    read_eye(entry, spec);
    spec.camera = read_camera(item, key, problems);
    for (std::size_t i = 0; i + 1 < views.size(); ++i)
      if (!spec.name.empty() && views[i].name == spec.name)
        problems.add(item.mark, key + ".name", "found " + spec.name + " a second time; each scan has its own name");
  }
  return views;
}

Node to_document(const std::vector<ViewsSpec>& views) {
  Node list = Node::sequence();
  for (const ViewsSpec& spec : views) {
    Node entry = Node::map();
    entry.set("name", spec.name);
    entry.set("files", spec.files);
    entry.set("every", spec.every);
    if (!spec.poses.empty()) entry.set("poses", spec.poses);
    if (spec.pose) {
      Node pose = Node::sequence();
      for (const double value : *spec.pose) pose.push(value);
      entry.set("pose", std::move(pose));
    }
    if (spec.eye) {
      Node place = Node::sequence();
      for (const double value : {spec.eye->x, spec.eye->y, spec.eye->z}) place.push(value);
      entry.set("eye", std::move(place));
    }
    if (spec.camera) {
      Node intrinsics = Node::sequence();
      for (const double value : {spec.camera->fx, spec.camera->fy, spec.camera->cx, spec.camera->cy})
        intrinsics.push(value);
      entry.set("intrinsics", std::move(intrinsics));
      entry.set("depth_scale", spec.camera->depth_scale);
    }
    list.push(std::move(entry));
  }
  return list;
}

Node views_schema() {
  Node item = document::fields_schema({}, nullptr, "One scan.");
  Node properties = Node::map();
  properties.set("name", described("string", "Name of the scan."));
  properties.set(
      "files",
      described("string", "Pattern of its files, relative to the archive; * stands for any characters, ? for one."));
  Node every = described("integer", "Of the matching files take the first, and every so many.");
  every.set("minimum", 1);
  every.set("default", 1);
  properties.set("every", std::move(every));
  properties.set("poses", described("string",
                                    "File with a pose per file, relative to the archive: .log, .conf, .aln, "
                                    ".xf or text of 4x4 matrices; excludes pose."));
  properties.set("pose", pose_schema());
  properties.set("eye",
                 number_list("Where the sensor sat in the frame of every file, in its units: tells which side of a "
                             "surface is outside. Depth maps, PTX and PCD say it themselves.",
                             3));
  properties.set("intrinsics", number_list("Camera of depth maps: [fx, fy, cx, cy] in pixels.", 4));
  Node scale = described("number", "Pixel values of a depth map per unit of length.");
  scale.set("exclusiveMinimum", 0);
  scale.set("default", 1000);
  properties.set("depth_scale", std::move(scale));
  item.set("properties", std::move(properties));
  Node required = Node::sequence();
  required.push("name");
  required.push("files");
  item.set("required", std::move(required));
  Node schema = described("array", "Scans given by hand: files with poses, and the camera of depth maps.");
  schema.set("items", std::move(item));
  return schema;
}

}  // namespace scanmill::pipeline
