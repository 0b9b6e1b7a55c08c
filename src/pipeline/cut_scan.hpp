// SPDX-License-Identifier: Apache-2.0
// One scan as tasks that any number of processes can do: passes over pieces of the input, and over bricks of the
// lattice with what is around them. What a task makes is a file; a task whose file is there is done. The bytes of the
// result do not depend on how input and lattice are cut (docs/algorithm.md, "Bricks").
//
//   map p     one pass over a piece of the input: winners and moments of its bins, in the order of keys
//   gather    all of them merged; which bricks there are, and the noise
//   frame b   local planes of the bins of some bricks, from their totals and those two bins around
//   pick p    second pass over a piece: the point nearest to the plane (representative: surface)
//   points    winners and planes joined to one row a bin
//   thin b    which points of some bricks are too near to others; where that hangs on points far away, it stays open
//   settle    the open ones, over all rows
//   stars b   the triangles that the points of some bricks propose, and which of them agree (engine: stars)
//   mesh      the vote over all bricks, completion, patches, merged
//   swap b    the edges at the vertices of some bricks swapped, with the mesh around them
//   join      all bricks' together, once their neighbours saw the same
//   verify v  third pass, over several pieces: distances of their points from the mesh
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "pipeline/part_file.hpp"
#include "pipeline/what.hpp"

namespace scanmill::pipeline {

struct Cut {
  std::string folder;              // of the parts; exists
  std::string identity;            // 64 hex digits: of all that decides the mesh
  std::uint32_t pieces = 1;        // of the input
  std::uint32_t batches = 1;       // of bricks
  std::uint32_t brick_bins = 256;  // edge; a power of two from 8 to 1024
};

enum class PartStage : std::uint8_t { Map, Gather, Frame, Pick, Points, Thin, Settle, Stars, Mesh, Swap, Join, Verify };
struct PartTask {
  PartStage stage = PartStage::Map;
  std::uint32_t number = 0;
};
/// "map 3", "gather".
std::string name_of(const PartTask& task);
/// What `gather` leaves beside its own part: where the bins of a piece are among all.
std::string link_name(std::uint32_t piece);

PartKind kind_of(const Cut& cut, std::string name, std::size_t row_bytes);
std::string path_of(const Cut& cut, std::string name);
std::optional<PartFile> open_part(const Cut& cut, const PartTask& task);
/// errors  IoFailed naming the task that makes it
Result<PartFile> need_part(const Cut& cut, const PartTask& task);
Result<PartWriter> create_part(const Cut& cut, const PartTask& task);

/// Of the reduction, wave by wave: a task needs all of the waves before its own.
std::vector<std::vector<PartTask>> waves_of(const Cut& cut, reduce::Representative representative);
/// All waves of a scan; the last task of a scan, which writes its files, needs them all.
std::vector<std::vector<PartTask>> scan_waves(const Cut& cut, const What& what);
/// Every one of them looks for the nearest among all triangles, and to prepare that costs as much as some hundred million
/// points: so a task for four pieces, but four at least where there are as many.
std::uint32_t verify_tasks(const Cut& cut);
/// Its part is there, or one that comes of it and leaves no other reader.
bool is_done(const Cut& cut, const PartTask& task);
/// Removes the parts that nothing reads any more now that this one is there.
void remove_read_parts(const Cut& cut, PartStage made);
/// Its tasks may need as much memory as a scan in one piece.
bool wants_whole(PartStage stage);

}  // namespace scanmill::pipeline
