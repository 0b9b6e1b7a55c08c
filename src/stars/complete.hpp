// SPDX-License-Identifier: Apache-2.0
// Completion: the places where corners disagree (docs/algorithm.md, "Complete"). Internal to `stars`.
#pragma once
#include <vector>

#include "base/progress.hpp"
#include "stars/site.hpp"
#include "stars/vote.hpp"

namespace scanmill::stars {

using Loop = std::vector<std::uint32_t>;  // missing half-edges loop[k] -> loop[k + 1]; least vertex first

/// Loops of missing half-edges that touch the given vertices (ascending), at most `longest` edges; shortest first, then
/// by vertices.
std::vector<Loop> trace_loops(const Site& site, const std::vector<std::uint32_t>& vertices, std::size_t longest);
/// Vertices that end an open half-edge, ascending.
std::vector<std::uint32_t> open_vertices(const Site& site);

/// How a long loop is stopped and tells that it goes on.
class Pace {
 public:
  Pace(const Context& context, Progress& progress) : context_(context), progress_(progress) {}
  /// False when cancelled: looked at every time, told of every 64th.
  bool go_on(std::size_t done, std::size_t total) const {
    if (done % 64 == 0) progress_.stage("complete", done, total);
    return !context_.cancel.is_set();
  }

 private:
  const Context& context_;
  Progress& progress_;
};

/// Tries the candidates in their order. All tests of an insertion hold. Stops early when `pace` says so.
void insert_candidates(Site& site, const std::vector<Candidate>& candidates, Report& report,
                       const Pace* pace = nullptr);

/// Closes one loop by its cheapest triangulation, or around one measured point when there is none. False: left open.
bool fill_loop(Site& site, const Loop& loop, Report& report);
/// Closes what can be closed of the loops that touch the vertices. Stops early when `pace` says so.
void fill_loops(Site& site, const std::vector<std::uint32_t>& vertices, Report& report, const Pace* pace = nullptr);
/// Greedy front over every open half-edge at the vertices, apexes being open or unused points.
void fill_front(Site& site, const std::vector<std::uint32_t>& vertices, double greatest_cost, bool with_sectors);
/// Where a vertex has several fans the largest stays. Returns the triangles removed.
std::size_t peel(Site& site, const std::vector<std::uint32_t>& vertices);
/// What a triangle costs a fill: circumradius over h, worse where it disagrees with the corners' normals.
double fill_cost(const Site& site, const Triangle& t);

/// One open loop as a transaction: free doubtful triangles around it (level 0 none .. 3 the whole ring), grow a front
/// through it, fill the rest; kept only if open edges plus unused points fall.
/// `changed` gets the vertices of the triangles that came and went.
bool repair_loop(Site& site, const Loop& loop, int level, Report& report, std::vector<std::uint32_t>& changed);

/// All of the above in order; afterwards no two triangles cross. Stops early when cancelled (the caller checks the
/// flag); tells how many loops of a round are done.
void complete(Site& site, const std::vector<Candidate>& candidates, Report& report, const Context& context,
              Progress& progress);

}  // namespace scanmill::stars
