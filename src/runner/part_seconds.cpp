// SPDX-License-Identifier: Apache-2.0
#include "runner/part_seconds.hpp"

#include <algorithm>
#include <optional>

#include "runner/forecast.hpp"
#include "store/files.hpp"

namespace scanmill::runner {

using document::Node;

namespace {

std::string path_of(const std::string& folder, std::string part) {
  std::replace(part.begin(), part.end(), ' ', '-');
  return folder + "/" + part + ".seconds";
}

std::optional<PartSeconds> load_seconds(const std::string& folder, const std::string& part) {
  const std::string path = path_of(folder, part);
  if (!store::exists(path)) return std::nullopt;
  const auto source = store::open_file(path, path);
  if (!source) return std::nullopt;
  const auto text = read_all(**source, 1 << 16);
  if (!text) return std::nullopt;
  const auto tree = document::parse_json(*text, path);
  if (!tree || !tree->is_map()) return std::nullopt;
  const Node *host = tree->find("host"), *ended = tree->find("ended"), *wall = tree->find("seconds"),
             *cpu = tree->find("cpu_seconds");
  if (!host || !ended || !wall || !cpu || !host->is_string() || !ended->is_string() || !wall->is_number() ||
      !cpu->is_number())
    return std::nullopt;
  return PartSeconds{part, host->as_string(), ended->as_string(), wall->as_number(), cpu->as_number()};
}

void add(std::vector<std::pair<std::string, double>>& sums, const std::string& kind, double seconds) {
  if (sums.empty() || sums.back().first != kind) sums.emplace_back(kind, 0);
  sums.back().second += seconds;
}

}  // namespace

void add_seconds(const std::string& folder, PartSeconds seconds) {
  if (const auto earlier = load_seconds(folder, seconds.part)) {
    seconds.wall += earlier->wall;
    seconds.cpu += earlier->cpu;
  }
  Node tree = Node::map();
  tree.set("host", seconds.host);
  tree.set("ended", seconds.ended);
  tree.set("seconds", seconds.wall);
  tree.set("cpu_seconds", seconds.cpu);
  (void)store::write_scratch(path_of(folder, seconds.part), document::to_json(tree) + "\n");
}

std::vector<PartSeconds> seconds_in(const CutParts& parts) {
  std::vector<PartSeconds> all;
  for (const auto& wave : parts.waves)
    for (const std::string& part : wave)
      if (auto seconds = load_seconds(parts.folder, part)) all.push_back(*std::move(seconds));
  return all;
}

StageSeconds by_kind(const std::vector<PartSeconds>& parts) {
  StageSeconds sums;
  for (const PartSeconds& part : parts) {
    add(sums.wall, kind_of_part(part.part), part.wall);
    add(sums.cpu, kind_of_part(part.part), part.cpu);
  }
  return sums;
}

}  // namespace scanmill::runner
