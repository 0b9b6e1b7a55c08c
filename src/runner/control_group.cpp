// SPDX-License-Identifier: Apache-2.0
#include "runner/control_group.hpp"

#include <algorithm>
#include <fstream>
#include <optional>
#include <sstream>
#include <vector>

namespace scanmill::runner {
namespace {

/// A tree of groups, as /proc/self/mountinfo has it.
struct Mount {
  std::string top, point;  // the group that stands at `point`
  bool is_v2 = false;
};

/// Blanks and the like are written \040 there.
std::string unescaped(const std::string& text) {
  const auto is_octal = [](char c) { return c >= '0' && c <= '7'; };
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\' && i + 3 < text.size() && is_octal(text[i + 1]) && is_octal(text[i + 2]) &&
        is_octal(text[i + 3])) {
      plain += static_cast<char>((text[i + 1] - '0') * 64 + (text[i + 2] - '0') * 8 + (text[i + 3] - '0'));
      i += 3;
    } else {
      plain += text[i];
    }
  }
  return plain;
}

bool holds_word(const std::string& list, const std::string& word) {
  return ("," + list + ",").find("," + word + ",") != std::string::npos;
}

/// The mounts that limit memory: any of version 2, and those of version 1 with the controller `memory`.
std::vector<Mount> memory_mounts(const std::string& path) {
  std::vector<Mount> mounts;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const std::size_t dash = line.find(" - ");
    if (dash == std::string::npos) continue;
    std::istringstream front(line.substr(0, dash)), back(line.substr(dash + 3));
    std::string id, parent, device, top, point, type, source, options;
    front >> id >> parent >> device >> top >> point;
    back >> type >> source >> options;
    if (type == "cgroup2" || (type == "cgroup" && holds_word(options, "memory")))
      mounts.push_back({unescaped(top), unescaped(point), type == "cgroup2"});
  }
  return mounts;
}

/// The process's group in the tree of version 2 ("0::/path"), or in that of the controller `memory`.
std::optional<std::string> group_of(const std::string& path, bool is_v2) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    if (is_v2 ? controllers.empty() : holds_word(controllers, "memory")) return line.substr(second + 1);
  }
  return std::nullopt;
}

/// The group's folder below the mount, as "" or "/a/b". A container may see its own group's path from the outside, or
/// one that leads out of what is mounted: then the mount itself is the nearest there is.
std::string below_mount(const std::string& group, const Mount& mount) {
  std::string path = group;
  if (mount.top != "/") {
    const bool is_inside = path == mount.top || path.starts_with(mount.top + "/");
    path = is_inside ? path.substr(mount.top.size()) : "";
  }
  if ((path + "/").find("/../") != std::string::npos) return "";
  while (!path.empty() && path.back() == '/') path.pop_back();
  return path;
}

/// 0 for "max", and where there is no such file.
std::uint64_t number_in(const std::string& path) {
  std::ifstream file(path);
  std::uint64_t value = 0;
  return file >> value ? value : 0;
}

/// Of lines "name 12".
std::optional<std::uint64_t> named_in(const std::string& path, const std::string& name) {
  std::ifstream file(path);
  std::string word;
  std::uint64_t value = 0;
  while (file >> word >> value)
    if (word == name) return value;
  return std::nullopt;
}

}  // namespace

std::uint64_t group_memory_limit(const std::string& proc, const std::string& root) {
  std::uint64_t least = 0;
  for (const Mount& mount : memory_mounts(proc + "/mountinfo")) {
    const auto group = group_of(proc + "/cgroup", mount.is_v2);
    if (!group) continue;
    const char* const name = mount.is_v2 ? "/memory.max" : "/memory.limit_in_bytes";
    for (std::string path = below_mount(*group, mount);; path.resize(path.rfind('/'))) {
      const std::uint64_t limit = number_in(root + mount.point + path + name);
      if (limit > 0) least = least == 0 ? limit : std::min(least, limit);
      if (path.empty()) break;
    }
  }
  return least;
}

std::optional<std::uint64_t> group_memory_kills(const std::string& proc, const std::string& root) {
  std::optional<std::uint64_t> sum;
  for (const Mount& mount : memory_mounts(proc + "/mountinfo")) {
    const auto group = group_of(proc + "/cgroup", mount.is_v2);
    if (!group) continue;
    const char* const name = mount.is_v2 ? "/memory.events" : "/memory.oom_control";
    if (const auto kills = named_in(root + mount.point + below_mount(*group, mount) + name, "oom_kill"))
      sum = sum.value_or(0) + *kills;
  }
  return sum;
}

}  // namespace scanmill::runner
