// SPDX-License-Identifier: Apache-2.0
// The points of one scan as a stream in the global frame, mm: units, poses and view directions applied.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "cloud/cloud.hpp"
#include "formats/view_reader.hpp"
#include "pipeline/discovery.hpp"
#include "plan/band.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {

/// A view that is there, opened.
struct OpenView {
  ViewId id{};       // its position in specs(), missing ones counted
  std::string path;  // relative to the archive
  formats::ViewHeader header;
  Pose pose;               // view frame in mm to global frame, the file's own pose included
  ViewPoint view_point;    // global frame
  store::FileStamp stamp;  // when it was opened
};

struct ViewCounts {
  std::uint64_t points_read = 0;
  std::uint64_t not_finite = 0;
  std::uint64_t sensor_invalid = 0;
  plan::BandCounts band;  // of plans with a sensor
  std::uint64_t kept() const { return points_read - not_finite - sensor_invalid; }
};

/// What reading a block leaves behind.
struct BlockTrace {
  std::uint64_t block = 0, points_read = 0, not_finite = 0, sensor_invalid = 0;
  plan::BandCounts band;
};

class ScanPoints final : public PointSource {
 public:
  /// Opens all views that are there; nothing but headers and line indices stays in memory. `units_mm` is the job's,
  /// used unless the scan says itself, 0: what the first file says, else mm; `format` is that of all its files.
  /// errors  BadInput or Unsupported from the files; BadInput when the scan is broken, holds no point or
  ///         says other units in the names of columns
  static Result<std::unique_ptr<ScanPoints>> open(const std::string& archive, const ScanSpec& scan, double units_mm,
                                                  formats::Format format = formats::Format::Auto);
  ~ScanPoints() override;

  std::size_t block_count() const override;
  /// View by view in id order, each in file order.
  Result<void> read_block(std::size_t number, PointBlock& out) const override;
  std::uint64_t expected_points() const override;

  const std::vector<OpenView>& views() const;
  /// The views of the scan with missing ones, one per scan of a file: rank of (path, scan number in the file).
  const std::vector<ViewSpec>& specs() const;
  double units_mm() const;
  /// Places the views anew: one pose per entry of specs(), those of missing views are not looked at. Not while blocks
  /// are read.
  void move_views(std::span<const Pose> poses);
  /// Sums over the blocks read so far, one per view of views(). Complete once every block was read; reading a block
  /// again changes nothing.
  std::vector<ViewCounts> counts() const;
  /// Of the blocks read so far, ascending; those without a row have none.
  std::vector<BlockTrace> traces() const;
  /// As if the blocks had been read here. False when there are no such blocks.
  bool recall(std::span<const BlockTrace> traces) const;
  /// SHA-256 of each view's file, hex, one per view of views(); files are read one per chunk of the loop.
  /// errors  BadInput when a file is not the one its plan names; Cancelled
  Result<std::vector<std::string>> digests(const Context& context) const;
  /// What the blocks read so far say about the sensor's depth band and field, station by station; empty when the scan
  /// has no plan with a sensor.
  std::vector<plan::Finding> band_findings() const;
  /// errors  BadInput with the findings that are errors, a line each; warnings are added to `notes`
  Result<void> check_bands(std::vector<std::string>& notes) const;
  /// errors  BadInput naming the file whose size, time or inode is not that of the moment it was opened
  Result<void> verify_unchanged() const;

 private:
  struct Impl;
  explicit ScanPoints(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Whether a cloud of these bounds (mm) can be meant: empty when it can, else a sentence with the likely unit.
/// units_mm  of the files the bounds were read from
/// points    how many lie in the bounds, for the sentence of those that coincide; 0: not said
/// bin_mm    0 when the job does not give it
std::string implausible_size(const Bounds& bounds, double units_mm, double bin_mm, std::uint64_t points = 0);

}  // namespace scanmill::pipeline
