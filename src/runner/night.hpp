// SPDX-License-Identifier: Apache-2.0
// This run against the one before: which scans came out worse, by how much.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "document/document.hpp"
#include "runner/output_tree.hpp"
#include "runner/run_report.hpp"
#include "runner/work.hpp"

namespace scanmill::runner {

/// A figure of a scan in both runs.
struct Figure {
  std::string name, unit;  // "greatest fit error", "mm"
  double then = 0, now = 0;
};

struct WorseScan {
  std::string name;
  std::vector<Figure> figures;         // those that became worse
  std::vector<std::string> new_gates;  // sentences of gates that failed now and not then
};

/// Below this share a greater fit error is the noise of scanning a part twice, not a worse part.
inline constexpr double kWorseShare = 0.02;

/// What is compared of an earlier run, by scan.
class LastNight {
 public:
  struct Scan {
    std::string name;
    Counts counts;
    std::vector<std::string> failed_gates;
  };
  /// Of a run.json, or of what save_night() kept.
  explicit LastNight(const document::Node& run);
  /// Of the text of either. Where scans stand a line each, as save_night() writes them, there is one at a time in
  /// memory. errors  BadParameter when it is no JSON of that kind
  static Result<LastNight> parse(std::string_view text, const std::string& name);
  const Scan* find(std::string_view name) const;
  const std::string& ended() const { return ended_; }  // empty: not told

 private:
  void add(const document::Node& scan);
  void sort();

  std::string ended_;
  std::vector<Scan> scans_;  // by name
};

/// Scans whose result stands and is worse than in `last`: fit error greater by more than kWorseShare, more open loops,
/// or a gate that fails now and did not then. By growth of the fit error in mm, then of the loops, then newly failed
/// gates, then name.
std::vector<WorseScan> worse_scans(const RunReport& report, const LastNight& last);

/// The scans' figures of the last run that reached its end, for the next run to compare with; nothing when there is
/// none that can be read. A run that was killed, interrupted or told --only leaves them alone; a scan without a result
/// of its own keeps the figures it had.
std::optional<LastNight> load_night(const OutputTree& tree);
Result<void> save_night(const RunReport& report, const LastNight* last, const OutputTree& tree);

/// What the page of the run is made from: run.json with, per scan, `advice` and `new`, and on top `verdict`, `worse`
/// and `compared_with` (when the run before ended; null without one). `report` and `last` must outlive it.
Night night_of(const RunReport& report, const LastNight* last, const std::vector<WorseScan>& worse);

}  // namespace scanmill::runner
