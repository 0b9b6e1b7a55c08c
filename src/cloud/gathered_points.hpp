// SPDX-License-Identifier: Apache-2.0
// Large clouds whose points stand in no order: what lies together is brought together once, so that every pass after
// that looks at little of what it fills at a time.
#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "cloud/cloud.hpp"

namespace scanmill {

/// The points of another source, cube by cube of space and view by view, in memory of its own (which is paged to disk
/// where memory is short). The first point stays the first, alone in its block: what asks it for a place to start from
/// gets the same. Rows of a block are in no order.
class GatheredPoints final : public PointSource {
 public:
  static constexpr std::uint32_t kCubesAcross = 32;  // the longest side of the cloud
  static constexpr std::size_t kMostRuns = 1 << 17;  // of a cube and a view

  /// `bounds`: of all points.
  /// errors  what `points` reports; Cancelled; Unsupported when many views see many cubes
  /// ties    the order within a cube hangs on threads
  /// cost    one pass over the points; 16 bytes for a point that float32 holds exactly, else 32
  static Result<std::unique_ptr<GatheredPoints>> gather(const PointSource& points, const Bounds& bounds,
                                                        const Context& context);
  /// Of the cubes that points are in, the share that a block has points in, on average over some blocks: near 1 where
  /// points stand in no order, some hundredths where they come in lines.
  /// errors  what `points` reports
  static Result<double> scatter_of(const PointSource& points);
  /// That a point takes.
  static std::size_t bytes_of(Vec3 position);

  std::size_t block_count() const override { return 2 + blocks_.size(); }
  Result<void> read_block(std::size_t number, PointBlock& out) const override;
  std::uint64_t expected_points() const override { return expected_points_; }

 private:
  struct Gatherer;
  struct Piece {
    std::unique_ptr<std::byte[]> bytes;
    std::uint64_t first_row = 0;  // rows are counted from it
    std::uint32_t count = 0, room = 0;
    bool is_wide = false;
  };
  struct Run {  // of a cube and a view
    ViewId view{};
    std::vector<Piece> pieces;
  };
  struct Block {
    ViewId view{};
    std::span<const Piece> pieces;
  };

  GatheredPoints() = default;

  std::uint64_t expected_points_ = 0;
  PointBlock first_;  // one point
  std::vector<std::vector<Run>> cubes_;
  std::vector<Block> blocks_;
  std::vector<ViewPoint> view_points_;  // by number of the view
  PointBlock dropped_;                  // what was read beside the points
};

}  // namespace scanmill
