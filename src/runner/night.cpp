// SPDX-License-Identifier: Apache-2.0
#include "runner/night.hpp"

#include <algorithm>
#include <map>
#include <tuple>

#include "runner/advice.hpp"
#include "store/files.hpp"

namespace scanmill::runner {

using document::Node;

namespace {

constexpr std::uint64_t kLongestNight = 256ull << 20;
constexpr const char* kCompared[] = {"max_error_mm", "boundary_loops"};

Node texts(const std::vector<std::string>& list) {
  Node node = Node::sequence();
  for (const std::string& text : list) node.push(text);
  return node;
}

/// The scans of a run.json by name; views into it.
std::map<std::string_view, const Node*> scans_of(const Node& run) {
  std::map<std::string_view, const Node*> scans;
  if (const Node* list = run.find("scans"); list && list->is_sequence())
    for (const Node& scan : list->items())
      if (const Node* name = scan.find("name"); name && name->is_string()) scans[name->as_string()] = &scan;
  return scans;
}

std::optional<double> number_in(const Node* map, const char* key) {
  const Node* value = map ? map->find(key) : nullptr;
  return value && value->is_number() ? std::optional(value->as_number()) : std::nullopt;
}

/// "verify.max_error_mm: found 2 mm, allowed 1 mm" is the gate verify.max_error_mm.
std::string_view gate_of(std::string_view sentence) { return sentence.substr(0, sentence.find(':')); }

bool has_gate(const Node* gates, std::string_view gate) {
  return gates && gates->is_sequence() && std::any_of(gates->items().begin(), gates->items().end(), [&](const Node& g) {
           return g.is_string() && gate_of(g.as_string()) == gate;
         });
}

WorseScan compare(const ScanEntry& entry, const Node& then) {
  WorseScan worse{entry.name, {}, {}};
  const Node* counts = then.find("counts");
  const auto check = [&](const char* key, const char* name, const char* unit, double share) {
    const auto before = number_in(counts, key), now = number_in(&entry.counts, key);
    if (before && now && *now > *before * (1 + share)) worse.figures.push_back({name, unit, *before, *now});
  };
  check(kCompared[0], "greatest fit error", "mm", kWorseShare);
  check(kCompared[1], "open loops", "", 0);
  for (const std::string& sentence : entry.failed_gates)
    if (!has_gate(then.find("failed_gates"), gate_of(sentence))) worse.new_gates.push_back(sentence);
  return worse;
}

double growth(const WorseScan& scan, std::string_view unit) {
  for (const Figure& figure : scan.figures)
    if (figure.unit == unit) return figure.now - figure.then;
  return 0;
}

}  // namespace

std::vector<WorseScan> worse_scans(const RunReport& report, const Node& last) {
  const auto before = scans_of(last);
  std::vector<WorseScan> found;
  for (const ScanEntry& entry : report.scans) {
    const auto then = before.find(entry.name);
    // A stale result is the one of an earlier night; what failed is listed as failed.
    if (then == before.end() || (entry.fate != ScanFate::Done && entry.fate != ScanFate::Unchanged)) continue;
    if (!then->second->find("counts")) continue;  // it had no result to compare with
    WorseScan worse = compare(entry, *then->second);
    if (!worse.figures.empty() || !worse.new_gates.empty()) found.push_back(std::move(worse));
  }
  std::sort(found.begin(), found.end(), [](const WorseScan& a, const WorseScan& b) {
    const auto rank = [](const WorseScan& s) { return std::tuple(growth(s, "mm"), growth(s, ""), s.new_gates.size()); };
    return rank(a) != rank(b) ? rank(a) > rank(b) : a.name < b.name;
  });
  return found;
}

std::optional<Node> load_night(const OutputTree& tree) {
  if (!store::exists(tree.night_file())) return std::nullopt;
  const auto source = store::open_file(tree.night_file(), tree.night_file());
  if (!source) return std::nullopt;
  const auto text = read_all(**source, kLongestNight);
  if (!text) return std::nullopt;
  auto night = document::parse_json(*text, tree.night_file());
  return night && night->is_map() ? std::optional(*std::move(night)) : std::nullopt;
}

Result<void> save_night(const RunReport& report, const Node* last, const OutputTree& tree) {
  if (!report.only.empty() || report.exit_code < 0 || report.exit_code >= 128 || report.exit_code == 1) return {};
  const auto before = last ? scans_of(*last) : std::map<std::string_view, const Node*>{};
  Node scans = Node::sequence();
  for (const ScanEntry& entry : report.scans) {
    const auto then = before.find(entry.name);
    const bool has_figures = entry.counts.is_map() && !entry.counts.entries().empty();
    Node scan = Node::map();
    scan.set("name", entry.name);
    if (has_figures) {
      Node counts = Node::map();
      for (const char* key : kCompared)
        if (const Node* value = entry.counts.find(key)) counts.set(key, *value);
      scan.set("counts", std::move(counts));
      if (!entry.failed_gates.empty()) scan.set("failed_gates", texts(entry.failed_gates));
    } else if (then != before.end()) {
      for (const char* key : {"counts", "failed_gates"})
        if (const Node* value = then->second->find(key)) scan.set(key, *value);
    }
    scans.push(std::move(scan));
  }
  Node night = Node::map();
  night.set("scanmill_night", 1);
  night.set("ended", report.ended);
  night.set("scans", std::move(scans));
  return store::write_text(tree.night_file(), document::to_json(night) + "\n");
}

Node night_document(const RunReport& report, const Node* last, const std::vector<WorseScan>& worse) {
  Node night = to_document(report);
  const auto before = last ? scans_of(*last) : std::map<std::string_view, const Node*>{};
  std::vector<Node>& scans = night.find("scans")->items();
  for (std::size_t k = 0; k < scans.size(); ++k) {
    const ScanEntry& entry = report.scans[k];
    if (const std::string advice = advice_for(entry); !advice.empty()) scans[k].set("advice", advice);
    const bool first_try = entry.why.size() == 1 && entry.why[0] == "new";
    if (first_try && before.find(entry.name) == before.end()) scans[k].set("new", true);
  }
  Node list = Node::sequence();
  for (const WorseScan& scan : worse) {
    Node row = Node::map();
    row.set("name", scan.name);
    Node figures = Node::sequence();
    for (const Figure& figure : scan.figures) {
      Node cell = Node::map();
      cell.set("name", figure.name);
      cell.set("unit", figure.unit);
      cell.set("then", figure.then);
      cell.set("now", figure.now);
      figures.push(std::move(cell));
    }
    row.set("figures", std::move(figures));
    row.set("new_gates", texts(scan.new_gates));
    list.push(std::move(row));
  }
  night.set("worse", std::move(list));
  night.set("verdict", verdict_of(report));
  const Node* ended = last ? last->find("ended") : nullptr;
  night.set("compared_with", ended ? *ended : Node());
  return night;
}

}  // namespace scanmill::runner
