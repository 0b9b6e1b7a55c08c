// SPDX-License-Identifier: Apache-2.0
// Completion touches 1-3 % of the points: candidates in canonical order, small loops, then repairs round by round until
// nothing improves. Every insertion needs free directed edges, free sectors, no fold, and no crossing with any triangle
// in reach; what cannot be closed under these rules stays open and is listed.
#include "stars/complete.hpp"

#include <algorithm>
#include <map>
#include <numeric>

#include "stars/crossings.hpp"

namespace scanmill::stars {
namespace {

constexpr std::size_t kLongestRepaired = 120;  // edges
constexpr int kRounds = 10;
/// Open edges plus unused points per kept point above which further rounds are not worth their time: bins too fine for
/// the points leave a sieve, where the first round closes about 4 % of what is open and all others together 1 %.
constexpr double kHopeless = 0.2;
constexpr std::int64_t kHopelessLeast = 5000;  // the border of a small open part is no sieve
constexpr double kFold = -0.5;

/// Removes one triangle of each crossing pair: fewer votes goes, then the larger circumradius, then the later one.
std::size_t cut_crossings(Site& site, Report& report, const Context& context) {
  std::vector<std::uint32_t> worse;
  auto goes = [&](std::uint32_t x, std::uint32_t y) {
    if (site.complex.votes(x) != site.complex.votes(y)) return site.complex.votes(x) < site.complex.votes(y);
    const Corners p = site.corners(site.complex.triangle(x)), q = site.corners(site.complex.triangle(y));
    const double rx = circumradius(p.at[0], p.at[1], p.at[2]), ry = circumradius(q.at[0], q.at[1], q.at[2]);
    return rx != ry ? rx > ry : p.id > q.id;
  };
  for (const auto& [s, t] : crossing_pairs(site, context)) worse.push_back(goes(s, t) ? s : t);
  std::sort(worse.begin(), worse.end());
  worse.erase(std::unique(worse.begin(), worse.end()), worse.end());
  for (const std::uint32_t t : worse) site.complex.remove(t);
  report.crossings_cut += worse.size();
  return worse.size();
}

/// Also finds vertices where two closed fans touch.
void peel_all(Site& site, Report& report) {
  std::vector<std::uint32_t> all(site.complex.vertex_count());
  std::iota(all.begin(), all.end(), 0u);
  while (const std::size_t removed = peel(site, all)) report.peeled += removed;
}

/// Which loops failed and what changed since: a repair is a pure function of its surroundings, so a loop that failed is
/// tried again only when something near it has changed.
class RepairHistory {
 public:
  explicit RepairHistory(const Site& site)
      : site_(site), changed_at_(site.complex.vertex_count(), 0), changed_near_at_(changed_at_) {}

  bool worth_trying(const Loop& loop) const {
    const auto found = failed_at_.find(loop);
    if (found == failed_at_.end()) return true;
    return std::any_of(loop.begin(), loop.end(), [&](std::uint32_t v) { return changed_near_at_[v] > found->second; });
  }
  void record(const Loop& loop, bool repaired) {
    if (!repaired) failed_at_[loop] = time_;
  }
  void changed(const std::vector<std::uint32_t>& vertices) {
    ++time_;
    for (const std::uint32_t v : vertices) {
      if (changed_at_[v] == time_) continue;
      changed_at_[v] = time_;
      near_.clear();
      site_.around(v, kSurroundings, near_);
      for (const std::int32_t row : near_) changed_near_at_[static_cast<std::size_t>(row)] = time_;
    }
  }

 private:
  static constexpr int kSurroundings = 6;  // bins: two rings of triangles and their reach
  const Site& site_;
  std::vector<std::uint32_t> changed_at_, changed_near_at_;
  std::vector<std::int32_t> near_;
  std::map<Loop, std::uint32_t> failed_at_;
  std::uint32_t time_ = 0;
};

bool repair(Site& site, const Loop& loop, Report& report, RepairHistory& history) {
  std::vector<std::uint32_t> changed;
  for (int level = 0; level < 4; ++level)
    if (repair_loop(site, loop, level, report, changed)) {
      history.changed(changed);
      return true;
    }
  return false;
}

}  // namespace

void insert_candidates(Site& site, const std::vector<Candidate>& candidates, Report& report, const Pace* pace) {
  for (std::size_t n = 0; n < candidates.size() && (pace == nullptr || pace->go_on(n, candidates.size())); ++n) {
    const Candidate& candidate = candidates[n];
    const Triangle& t = candidate.corners;
    if (!site.complex.edges_free(t) || !site.within_limits(t)) continue;
    if (!site.sectors_free(t))
      ++report.turned_back_sector;
    else if (!site.fold_free(t, kFold))
      ++report.turned_back_fold;
    else if (site.crossing_of(t) != kNone)
      ++report.turned_back_crossing;
    else {
      site.complex.add(t, candidate.votes);
      ++report.candidates_added;
    }
  }
}

void complete(Site& site, const std::vector<Candidate>& candidates, Report& report, const Context& context,
              Progress& progress) {
  const Pace pace(context, progress);
  insert_candidates(site, candidates, report, &pace);
  fill_loops(site, open_vertices(site), report, &pace);
  if (context.cancel.is_set()) return;
  report.peeled += peel(site, open_vertices(site));
  cut_crossings(site, report, context);  // confirmed triangles were not tested against each other
  RepairHistory history(site);
  const std::int64_t open = site.complex.open_edges() + site.complex.unused();
  const bool hopeless =
      open > kHopelessLeast && static_cast<double>(open) > kHopeless * static_cast<double>(report.kept);
  const int rounds = hopeless ? 1 : kRounds;
  for (int round = 0; round < rounds; ++round) {
    const std::int64_t before = site.complex.open_edges() + site.complex.unused();
    const std::vector<Loop> loops = trace_loops(site, open_vertices(site), kLongestRepaired);
    for (std::size_t n = 0; n < loops.size() && pace.go_on(n, loops.size()); ++n)
      if (history.worth_trying(loops[n])) history.record(loops[n], repair(site, loops[n], report, history));
    if (context.cancel.is_set()) return;
    if (site.complex.open_edges() + site.complex.unused() == before && round > 0) break;
  }
  peel_all(site, report);
}

}  // namespace scanmill::stars
