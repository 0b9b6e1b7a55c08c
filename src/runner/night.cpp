// SPDX-License-Identifier: Apache-2.0
#include "runner/night.hpp"

#include <algorithm>
#include <tuple>

#include "runner/advice.hpp"
#include "store/files.hpp"

namespace scanmill::runner {

using document::Node;

namespace {

constexpr std::uint64_t kLongestNight = 256ull << 20;
// A scan a line: no string of JSON holds a line feed as it is.
constexpr std::string_view kScansBegin = ",\"scans\":[\n", kScanEnd = ",\n", kScansEnd = "\n]}";
constexpr const char* kCompared[] = {"max_error_mm", "boundary_loops"};

Node texts(const std::vector<std::string>& list) {
  Node node = Node::sequence();
  for (const std::string& text : list) node.push(text);
  return node;
}

std::string text_in(const Node& map, std::string_view key) {
  const Node* value = map.find(key);
  return value && value->is_string() ? value->as_string() : std::string();
}

std::optional<double> number_in(const Counts& counts, const char* key) {
  const auto value = counts.find(key);
  return value ? std::optional(value->as_number()) : std::nullopt;
}

/// Those that are compared.
Counts compared(const Counts& all) {
  Counts some = Node::map();
  for (const char* key : kCompared)
    if (const auto value = all.find(key)) some.set(key, *value);
  return some;
}

/// "verify.max_error_mm: found 2 mm, allowed 1 mm" is the gate verify.max_error_mm.
std::string_view gate_of(std::string_view sentence) { return sentence.substr(0, sentence.find(':')); }

bool has_gate(const std::vector<std::string>& gates, std::string_view gate) {
  return std::any_of(gates.begin(), gates.end(), [&](const std::string& other) { return gate_of(other) == gate; });
}

WorseScan compare(const ScanEntry& entry, const LastNight::Scan& then) {
  WorseScan worse{entry.name, {}, {}};
  const auto check = [&](const char* key, const char* name, const char* unit, double share) {
    const auto before = number_in(then.counts, key), now = number_in(entry.counts, key);
    if (before && now && *now > *before * (1 + share)) worse.figures.push_back({name, unit, *before, *now});
  };
  check(kCompared[0], "greatest fit error", "mm", kWorseShare);
  check(kCompared[1], "open loops", "", 0);
  for (const std::string& sentence : entry.failed_gates)
    if (!has_gate(then.failed_gates, gate_of(sentence))) worse.new_gates.push_back(sentence);
  return worse;
}

double growth(const WorseScan& scan, std::string_view unit) {
  for (const Figure& figure : scan.figures)
    if (figure.unit == unit) return figure.now - figure.then;
  return 0;
}

}  // namespace

LastNight::LastNight(const Node& run) : ended_(text_in(run, "ended")) {
  const Node* list = run.find("scans");
  if (!list || !list->is_sequence()) return;
  scans_.reserve(list->items().size());
  for (const Node& scan : list->items()) add(scan);
  sort();
}

Result<LastNight> LastNight::parse(std::string_view text, const std::string& name) {
  const std::size_t first = text.find(kScansBegin), end = text.rfind(kScansEnd);
  if (first == std::string_view::npos || end == std::string_view::npos || end < first) {
    TRY_ASSIGN(const Node run, document::parse_json(text, name));
    if (!run.is_map()) return fail(Code::BadParameter, "found no map", name);
    return LastNight(run);
  }
  TRY_ASSIGN(const Node head, document::parse_json(std::string(text.substr(0, first)) + "}", name));
  LastNight night(head);
  for (std::size_t at = first + kScansBegin.size(); at < end;) {
    const std::size_t stop = std::min(end, text.find(kScanEnd, at));
    TRY_ASSIGN(const Node scan, document::parse_json(text.substr(at, stop - at), name));
    night.add(scan);
    at = stop + kScanEnd.size();
  }
  night.sort();
  return night;
}

void LastNight::add(const Node& node) {
  Scan scan{text_in(node, "name"), {}, {}};
  if (scan.name.empty()) return;
  if (const Node* counts = node.find("counts"); counts && counts->is_map()) scan.counts = compared(*counts);
  if (const Node* gates = node.find("failed_gates"); gates && gates->is_sequence())
    for (const Node& gate : gates->items())
      if (gate.is_string()) scan.failed_gates.push_back(gate.as_string());
  scans_.push_back(std::move(scan));
}

void LastNight::sort() {
  std::stable_sort(scans_.begin(), scans_.end(), [](const Scan& a, const Scan& b) { return a.name < b.name; });
}

const LastNight::Scan* LastNight::find(std::string_view name) const {
  const auto at = std::lower_bound(scans_.begin(), scans_.end(), name,
                                   [](const Scan& scan, std::string_view wanted) { return scan.name < wanted; });
  return at != scans_.end() && at->name == name ? &*at : nullptr;
}

std::vector<WorseScan> worse_scans(const RunReport& report, const LastNight& last) {
  std::vector<WorseScan> found;
  for (const ScanEntry& entry : report.scans) {
    const LastNight::Scan* then = last.find(entry.name);
    // A stale result is the one of an earlier night; what failed is listed as failed.
    if (!then || (entry.fate != ScanFate::Done && entry.fate != ScanFate::Unchanged)) continue;
    if (!then->counts.is_known()) continue;  // it had no result to compare with
    WorseScan worse = compare(entry, *then);
    if (!worse.figures.empty() || !worse.new_gates.empty()) found.push_back(std::move(worse));
  }
  std::sort(found.begin(), found.end(), [](const WorseScan& a, const WorseScan& b) {
    const auto rank = [](const WorseScan& s) { return std::tuple(growth(s, "mm"), growth(s, ""), s.new_gates.size()); };
    return rank(a) != rank(b) ? rank(a) > rank(b) : a.name < b.name;
  });
  return found;
}

std::optional<LastNight> load_night(const OutputTree& tree) {
  if (!store::exists(tree.night_file())) return std::nullopt;
  const auto source = store::open_file(tree.night_file(), tree.night_file());
  if (!source) return std::nullopt;
  const auto text = read_all(**source, kLongestNight);
  if (!text) return std::nullopt;
  auto night = LastNight::parse(*text, tree.night_file());
  return night ? std::optional<LastNight>(*std::move(night)) : std::nullopt;
}

Result<void> save_night(const RunReport& report, const LastNight* last, const OutputTree& tree) {
  if (!report.only.empty() || report.exit_code < 0 || report.exit_code >= 128 || report.exit_code == 1) return {};
  std::string text;
  for (const ScanEntry& entry : report.scans) {
    const LastNight::Scan* then = last ? last->find(entry.name) : nullptr;
    const bool has_figures = !entry.counts.empty();
    const Counts& counts = has_figures || !then ? entry.counts : then->counts;
    const std::vector<std::string>& gates = has_figures || !then ? entry.failed_gates : then->failed_gates;
    Node scan = Node::map();
    scan.set("name", entry.name);
    if (!counts.empty()) {
      scan.set("counts", compared(counts).document());
      if (!gates.empty()) scan.set("failed_gates", texts(gates));
    }
    if (!text.empty()) text += kScanEnd;
    text += document::to_json(scan);
  }
  Node night = Node::map();
  night.set("scanmill_night", 1);
  night.set("ended", report.ended);
  std::string head = document::to_json(night);
  head.pop_back();  // its brace
  text.insert(0, head.append(kScansBegin));
  text.append(kScansEnd) += "\n";
  return store::write_text(tree.night_file(), text);
}

Night night_of(const RunReport& report, const LastNight* last, const std::vector<WorseScan>& worse) {
  Night night;
  night.head = head_of(report);
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
  night.head.set("worse", std::move(list));
  night.head.set("verdict", verdict_of(report));
  night.head.set("compared_with", last && !last->ended().empty() ? Node(last->ended()) : Node());
  night.scans = report.scans.size();
  night.scan = [&report, last](std::size_t k) {
    const ScanEntry& entry = report.scans[k];
    Node scan = to_document(entry);
    if (const std::string advice = advice_for(entry); !advice.empty()) scan.set("advice", advice);
    const bool first_try = entry.why.size() == 1 && entry.why[0] == "new";
    if (first_try && !(last && last->find(entry.name))) scan.set("new", true);
    return scan;
  };
  return night;
}

}  // namespace scanmill::runner
