// SPDX-License-Identifier: Apache-2.0
// Clouds as streams of blocks: any block, any order, any thread. Stages never see files.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/ids.hpp"
#include "base/result.hpp"
#include "geom/pose.hpp"
#include "geom/vec3.hpp"

namespace scanmill {

/// How a view was looked at, in the frame its points are given in; what is not known stays empty.
struct ViewPoint {
  std::optional<Vec3> eye;        // place of the sensor, mm
  std::optional<Vec3> direction;  // unit vector from the surface towards the sensor, for sensors with parallel rays
};

/// Points of one view, in file order unless they were gathered (gathered_points.hpp).
struct PointBlock {
  ViewId view{};
  ViewPoint view_point;
  std::vector<Vec3> positions;       // all finite
  std::vector<std::uint64_t> rows;   // same length; in the order of the points
  std::uint64_t points_read = 0;     // rows of the file behind this block, dropped ones included
  std::uint64_t not_finite = 0;      // dropped: NaN or infinite coordinates
  std::uint64_t sensor_invalid = 0;  // dropped: the file says that the cell holds no measurement
  void clear() {
    positions.clear();
    rows.clear();
    points_read = not_finite = sensor_invalid = 0;
  }
};

/// A cloud in the global frame, mm. `read_block` may be called from several threads, any number of times, in any order;
/// the same number always gives the same points.
class PointSource {
 public:
  virtual ~PointSource() = default;
  virtual std::size_t block_count() const = 0;
  virtual Result<void> read_block(std::size_t number, PointBlock& out) const = 0;
  /// What the files declare or their sizes suggest; for progress and forecasts only.
  virtual std::uint64_t expected_points() const = 0;
};

/// A source over points in memory (tests, `mesh` on a reduced file); view 0, rows as given or 0, 1, 2, ...
class MemoryPoints final : public PointSource {
 public:
  explicit MemoryPoints(std::vector<Vec3> positions, ViewPoint view_point = {}, std::size_t block_size = 65536);
  std::size_t block_count() const override;
  Result<void> read_block(std::size_t number, PointBlock& out) const override;
  std::uint64_t expected_points() const override { return positions_.size(); }

 private:
  std::vector<Vec3> positions_;
  ViewPoint view_point_;
  std::size_t block_size_;
};

}  // namespace scanmill
