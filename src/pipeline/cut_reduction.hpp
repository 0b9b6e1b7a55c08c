// SPDX-License-Identifier: Apache-2.0
// The reduction of a scan that is cut (cut_scan.hpp): all tasks up to `settle`.
#pragma once
#include "base/context.hpp"
#include "pipeline/cut_scan.hpp"
#include "reduce/parts.hpp"

namespace scanmill::pipeline {

struct BrickCounts {
  std::uint64_t bricks = 0, bins = 0, most_bins = 0;  // most: of one brick
};

/// points    as the stage `reduce` gets them; outlives this
/// lattice   is_cuttable
class CutReduction {
 public:
  CutReduction(const PointSource& points, const reduce::LatticeParams& lattice, const reduce::Params& params, Cut cut);
  /// errors  IoFailed when a part it needs is not there, naming the task that makes it; those of the stage; NoSpace
  Result<void> make(const PartTask& task, const Context& context) const;
  Result<BrickCounts> bricks() const;

 private:
  Result<void> map(std::uint32_t piece, const Context& context) const;
  Result<void> gather(const Context& context) const;
  Result<void> frame(std::uint32_t batch, const Context& context) const;
  Result<void> pick(std::uint32_t piece, const Context& context) const;
  Result<void> points(const Context& context) const;
  Result<void> thin(std::uint32_t batch, const Context& context) const;
  Result<void> settle(const Context& context) const;

  const PointSource& points_;
  reduce::LatticeParams lattice_;
  reduce::Params params_;
  Cut cut_;
};

/// Once all are done. The same as reduce_cloud gives, but for the two figures of memory in the report.
Result<reduce::Reduction> join_reduction(const Cut& cut);
/// Of it, what tells where points lie: lattice, base, bins and index.
Result<reduce::ReducedCloud> join_bins(const Cut& cut);

}  // namespace scanmill::pipeline
