// SPDX-License-Identifier: Apache-2.0
// Points of fixture and deck, and outliers, taken out by rule (Bradley 2001, section 4; there by hand).
//
// Rules are fixed first, from the whole cloud, then a wrapper filters blocks as they are read. The order is keep_box,
// remove_box, remove_plane, statistical, component; a point counts for the first rule that takes it.
#pragma once
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "clean/bins.hpp"
#include "clean/params.hpp"
#include "clean/plane.hpp"
#include "cloud/cloud.hpp"

namespace scanmill::clean {

enum class Rule : std::uint8_t { Kept, KeepBox, RemoveBox, OnPlane, BelowPlane, Statistical, Component };
inline constexpr std::size_t kRules = 7;
/// "keep_box", "remove_box", "remove_plane", "below_plane", "outliers.statistical", "outliers.component"; "kept".
const char* name_of(Rule rule);

/// Points by rule; [Rule::Kept] are those that go on.
struct RuleCounts {
  std::array<std::uint64_t, kRules> points{};
  std::uint64_t& operator[](Rule rule) { return points[static_cast<std::size_t>(rule)]; }
  std::uint64_t operator[](Rule rule) const { return points[static_cast<std::size_t>(rule)]; }
  std::uint64_t removed() const;
  friend bool operator==(const RuleCounts&, const RuleCounts&) = default;
};

/// Everything decided beforehand; blocks are then filtered one by one.
struct Rules {
  std::optional<Box> keep_box;
  std::vector<Box> remove_box;
  std::optional<FittedPlane> plane;  // share 0 where it was given
  double plane_distance_mm = 0;
  bool below_plane = false;
  std::optional<OutlierLattice> lattice;
  std::vector<BinFate> fates;  // of the bins in `outliers`, by row
  BinIndex outliers;           // the bins that go
  OutlierReport outlier_report;

  /// The rules without the outlier bins.
  Rule of(Vec3 p) const;
};

/// Fixes the rules. Reads the points once for a fitted plane, once for outliers, not at all without these.
///
/// points  global frame, mm
/// bin_mm  the job's bin edge, for outliers that do not name one; 0 when it is not known
/// seed    of the job; with it the same points always give the same rules
/// errors  BadParameter when a value cannot be, or outliers have no bin edge; BadInput when no plane stands out or the
///         cloud is too wide; Cancelled; what `points` reports
/// memory  the occupied bins (about 20 bytes each and worker), and a sample of 8,192 points
Result<std::shared_ptr<const Rules>> fix_rules(const PointSource& points, const Params& params, double bin_mm,
                                               std::uint64_t seed, const Context& context);

/// A point that went.
struct RemovedPoint {
  SourceKey source;
  Vec3 position;
  Rule rule = Rule::Kept;
  bool operator<(const RemovedPoint& other) const { return source < other.source; }
};

/// The points that stay. Any block, any order, any thread; counts and sample add up over the blocks read so far, each
/// block once.
class CleanPoints final : public PointSource {
 public:
  /// `sample`: how many removed points to remember, for a picture: those whose source key hashes least.
  CleanPoints(const PointSource& points, std::shared_ptr<const Rules> rules, std::size_t sample = 200000);
  ~CleanPoints() override;

  std::size_t block_count() const override;
  Result<void> read_block(std::size_t number, PointBlock& out) const override;
  std::uint64_t expected_points() const override;

  /// Sums over all views, and one per view id.
  RuleCounts counts() const;
  std::vector<RuleCounts> counts_by_view() const;
  /// Ascending source key.
  std::vector<RemovedPoint> removed_sample() const;
  const Rules& rules() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// "keep_box 12, remove_plane 1,234": the rules that took points; empty when none did.
std::string summary_of(const RuleCounts& counts);

}  // namespace scanmill::clean
