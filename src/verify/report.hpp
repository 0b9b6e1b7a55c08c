// SPDX-License-Identifier: Apache-2.0
// The metrologist's figures of a mesh against its cloud, as plain values.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/ids.hpp"
#include "geom/vec3.hpp"
#include "verify/closest.hpp"

namespace scanmill::verify {

/// Of unsigned distances, mm: the value of rank floor(q (n - 1)) in ascending order, exact to 4e-6 bin edges or 1e-6 of
/// it, whichever is more.
struct Percentiles {
  double p50 = 0, p90 = 0, p95 = 0, p99 = 0, p999 = 0;
};

/// Distances of a class of points from the mesh, mm. Greatest distances are exact; means are of whole 2^-20 bin edges.
struct DistanceFigures {
  std::uint64_t count = 0;
  double max_mm = 0, rms_mm = 0, mean_mm = 0, signed_mean_mm = 0;
  double above_mm = 0, below_mm = 0;  // greatest distance on the normal's side, and on the other; both >= 0
  std::optional<Percentiles> percentiles;
};

struct PatchFigures {
  std::uint32_t patch = 0;
  std::string name;  // empty when none was given
  std::uint64_t triangles = 0;
  DistanceFigures distances;  // without percentiles
};

struct WorstPoint {
  Vec3 place;  // the input point, global frame, mm
  SourceKey source;
  double distance_mm = 0, signed_mm = 0;
  std::uint32_t triangle = 0;  // the nearest
  std::uint32_t patch = 0;
  bool open_border = false;
};

/// Counts by signed distance in steps of h/32 from -2 h to 2 h: bin n holds [-2 h + n h/32, -2 h + (n + 1) h/32).
struct SignedHistogram {
  static constexpr int kStepsPerBin = 32, kBinsEachSide = 2;
  double step_mm = 0;  // h/32
  std::uint64_t below = 0, above = 0;
  std::array<std::uint64_t, 2 * kBinsEachSide * kStepsPerBin> counts{};
};

/// Input points of the vertex's own bin.
struct VertexError {
  double signed_mm = 0;  // the one of largest magnitude; of two equal ones that above
  double rms_mm = 0;
  std::uint64_t points = 0;  // 0: no point of its bin was seen; the others are 0 then
};

struct Coverage {
  std::uint64_t triangles = 0, triangles_near = 0;  // near: nearest triangle of at least one point within h
  std::uint64_t bins = 0, bins_near = 0;  // near: at least one point of it lies within h; 0 without vertex bins
};

/// A limit of the job and what was found.
struct Gate {
  std::string name;  // the job's key
  double limit = 0, found = 0;
  bool passed = true;  // found <= limit
};

struct Report {
  double bin_mm = 0;
  std::uint64_t points_read = 0, not_finite = 0, sensor_invalid = 0;  // of the files; points judged are all.count
  std::uint64_t points_near = 0;  // of those judged: within one bin edge of the mesh
  DistanceFigures all;
  DistanceFigures interior, open_border;  // apart: the nearest place lies on an open edge of the mesh, or not
  DistanceFigures patch_borders;          // nearest triangle has a corner on an edge between two patches
  std::vector<PatchFigures> patches;      // by patch number; those with triangles
  SignedHistogram histogram;
  std::vector<WorstPoint> worst, worst_interior;  // ten each, greatest first; ties by source
  std::vector<VertexError> vertices;              // one per vertex when vertex bins were given
  Coverage coverage;
  // The paper states the greatest fit error and the sensor's accuracy apart, and what they come to together.
  double fit_error_mm = 0, sensor_accuracy_mm = 0, total_error_mm = 0;
  std::vector<Gate> gates;  // those that the job asks for
  bool passed() const {
    for (const Gate& gate : gates)
      if (!gate.passed) return false;
    return true;
  }
};

}  // namespace scanmill::verify
