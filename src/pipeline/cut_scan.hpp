// SPDX-License-Identifier: Apache-2.0
// One scan as tasks that any number of processes can do: passes over pieces of the input, frames over bricks of the
// lattice. What a task makes is a file; a task whose file is there is done. The bytes of the result do not depend on
// how input and lattice are cut (docs/algorithm.md, "Bricks"). Here is the reduction; cut_surface.hpp has the rest.
//
//   map p     one pass over a piece of the input: winners and moments of its bins, in the order of keys
//   gather    all of them merged; which bricks there are, and the noise
//   frame b   local planes of the bins of some bricks, from their totals and those two bins around
//   pick p    second pass over a piece: the point nearest to the plane (representative: surface)
//   mesh      all of that joined and thinned, the mesh of it, its edges swapped
//   verify p  third pass over a piece: distances of its points from the mesh
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/progress.hpp"
#include "pipeline/part_file.hpp"
#include "reduce/parts.hpp"

namespace scanmill::pipeline {

struct Cut {
  std::string folder;              // of the parts; exists
  std::string identity;            // 64 hex digits: of all that decides the reduced points
  std::uint32_t pieces = 1;        // of the input
  std::uint32_t batches = 1;       // of bricks
  std::uint32_t brick_bins = 256;  // edge; a power of two from 8 to 1024
};

enum class PartStage : std::uint8_t { Map, Gather, Frame, Pick, Mesh, Verify };
struct PartTask {
  PartStage stage = PartStage::Map;
  std::uint32_t number = 0;
};
/// "map 3", "gather".
std::string name_of(const PartTask& task);

PartKind kind_of(const Cut& cut, std::string name, std::size_t row_bytes);
std::string path_of(const Cut& cut, std::string name);
std::optional<PartFile> open_part(const Cut& cut, const PartTask& task);
/// errors  IoFailed naming the task that makes it
Result<PartFile> need_part(const Cut& cut, const PartTask& task);

/// Of the reduction, wave by wave: a task needs all of the waves before its own.
std::vector<std::vector<PartTask>> waves_of(const Cut& cut, reduce::Representative representative);
/// All waves of a scan; the last task of a scan, which writes its files, needs them all.
std::vector<std::vector<PartTask>> scan_waves(const Cut& cut, reduce::Representative representative);
bool is_done(const Cut& cut, const PartTask& task);

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
  /// Once all are done. The same as reduce_cloud gives, but for the two figures of memory in the report.
  Result<reduce::Reduction> join(const Context& context) const;
  Result<BrickCounts> bricks() const;

 private:
  Result<void> map(std::uint32_t piece, const Context& context) const;
  Result<void> gather(const Context& context) const;
  Result<void> frame(std::uint32_t batch, const Context& context) const;
  Result<void> pick(std::uint32_t piece, const Context& context) const;

  const PointSource& points_;
  reduce::LatticeParams lattice_;
  reduce::Params params_;
  Cut cut_;
};

}  // namespace scanmill::pipeline
