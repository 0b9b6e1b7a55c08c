// SPDX-License-Identifier: Apache-2.0
// How far apart the points of a reduced cloud lie, and what to say when the bins do not suit that.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "pipeline/judge_scan.hpp"
#include "reduce/reduce.hpp"

namespace scanmill::pipeline {

/// Bins finer than this many spacings leave neighbours without a common edge.
inline constexpr double kFinestBinSpacings = 1.3;
/// Bins of this many spacings suit a cloud without noise.
inline constexpr double kGoodBinSpacings = 2;
/// A mesh that stands for fewer of the points is told of.
inline constexpr double kLeastMeshedShare = 0.9;

/// Two significant digits, so that a person can read a suggestion.
double two_digits(double value);

/// Square root of the area per point, mm, of the rows marked in `rows` (empty: of all); the area is that of bins joined
/// by powers of two until they hold nine points each. Nothing with fewer than 100 points.
std::optional<double> spacing_of(const reduce::ReducedCloud& cloud, std::span<const std::uint8_t> rows = {});

/// Says so when the bins are finer than kFinestBinSpacings; else empty.
std::string fine_bins_note(const reduce::ReducedCloud& cloud);

/// Says so when fewer than kLeastMeshedShare of the points lie within a bin edge of the mesh, and what to do; else
/// empty.
/// meshed   of `points`, the points that were reduced
/// cover    the job's seeds.cover
std::string coverage_note(std::uint64_t meshed, std::uint64_t points, const Unmeshed& off,
                          const reduce::ReducedCloud& cloud, bool cover);

}  // namespace scanmill::pipeline
