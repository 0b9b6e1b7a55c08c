// SPDX-License-Identifier: Apache-2.0
// Sections as metrologists draw them: the line of the mesh, the measured points beside it, and how far these are off.
#pragma once
#include <span>
#include <vector>

#include "base/context.hpp"
#include "base/result.hpp"
#include "cloud/cloud.hpp"
#include "mesh/mesh.hpp"
#include "mesh/section.hpp"
#include "verify/section_rule.hpp"

namespace scanmill::verify {

/// Most points of a section that are kept for drawing.
inline constexpr std::size_t kSectionPoints = 4000;
/// Most planes of one scan.
inline constexpr std::size_t kMostSections = 100;

/// Features that planes may go through; what is not known stays empty.
struct SectionFeatures {
  std::optional<Vec3> worst;         // the input point farthest from the mesh
  std::optional<Vec3> longest_loop;  // centre of the longest open loop
};

/// The planes of the rules, in their order; a rule through a feature that is not there gives none.
/// errors  BadParameter for a zero axis, or more than kMostSections planes
Result<std::vector<SectionFrame>> section_frames(const Mesh& mesh, std::span<const SectionRule> rules, double bin_mm,
                                                 const SectionFeatures& features, std::vector<double>& magnify);

/// Lines of the mesh in one plane. A vertex in the plane counts as above it, so every line is closed or ends at open
/// edges; places on an edge are computed from its lower row, so neighbours meet exactly. cost O(F + S log S)
std::vector<SectionLine> cut(const Mesh& mesh, const SectionFrame& frame);

/// Cuts the mesh and reads all points once.
///
/// frames   as section_frames() makes them; `magnify` one per frame, 0 to choose
/// returns  one section per frame; points nearest to an open edge are drawn, but counted apart and never the worst;
///          the same for any number of threads and any order of blocks: sampled points are those
///          with the least hash of their source, sums are whole numbers of 2^-20 bin_mm
/// errors   BadInput when no triangle of the mesh has an area; Cancelled; what `points` reports
Result<std::vector<Section>> sections_of(const Mesh& mesh, const PointSource& points,
                                         std::span<const SectionFrame> frames, std::span<const double> magnify,
                                         double bin_mm, const Context& context);

}  // namespace scanmill::verify
