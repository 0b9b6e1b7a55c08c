// SPDX-License-Identifier: Apache-2.0
// Poses of all views at once, from how well their pieces of surface lie on each other: point-to-plane registration that
// begins where the machine says and ends within its stated accuracy.
//
// What all views share, a motion of the whole, no view can tell: the machine's word alone decides there, or bodies
// whose place is known (`datum`).
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "cloud/cloud.hpp"
#include "refine/params.hpp"

namespace scanmill::refine {

/// How far the sensor's reference point may have stood from where the machine says, and how much it may be turned: the
/// limit, and three standard deviations of the prior.
struct Accuracy {
  double shift_mm = 0, turn_deg = 0;
};

/// A body that stands where it is said to stand; `box` in its own frame.
struct Datum {
  Pose frame;
  Bounds box;
};

/// Two views that see the same surface. Gaps are 1.48 times the median of their sizes: the rms of normal noise.
struct PairReport {
  std::uint32_t a = 0, b = 0;  // view ids, a < b
  std::uint64_t matches = 0;
  double before_mm = 0, after_mm = 0;
};

struct ViewReport {
  std::uint64_t patches = 0;
  double shift_mm = 0, turn_deg = 0;
  bool at_limit = false;  // it would have gone farther
};

struct Report {
  double patch_mm = 0;
  std::uint64_t patches = 0, matches = 0, datum_matches = 0;
  std::int64_t rounds = 0;
  bool settled = false;                // the last round moved no patch by a tenth of a micrometre
  double before_mm = 0, after_mm = 0;  // of all matches
  double fitted_mm = 0;                // where moving brought it; after_mm unless the views were left
  bool left = false;                   // moving gained nothing beyond noise: poses are what the machine says
  double noise_mm = 0;                 // of a piece's height, from the noise of its points (median)
  double bend_mm = 0;                  // of a piece's height, from how far it is from flat (median)
  std::array<bool, 6> datum_open{};    // turns, then shifts of the whole that the datum's faces do not tell
  double datum_before_mm = 0, datum_after_mm = 0;  // of patches on bodies
  std::vector<PairReport> pairs;
  std::vector<ViewReport> views;  // by view id
};

struct Refinement {
  std::vector<Pose> poses;  // by view id; those of views without patches as they were
  Report report;
};

/// points  placed by `poses`
/// poses   sensor (or view) frame to global frame, by view id; a view turns about its pose's translation
/// errors  those of patches_of; BadParameter when params are out of their limits; Cancelled
/// cost    some 0.1 s per round and 100,000 patches with ten neighbours, and a system of six rows per view (profile
///         storage) per round
Result<Refinement> refine_poses(const PointSource& points, std::span<const Pose> poses, const Accuracy& accuracy,
                                std::span<const Datum> datums, const Params& params, const Context& context);

}  // namespace scanmill::refine
