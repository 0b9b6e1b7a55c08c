// SPDX-License-Identifier: Apache-2.0
#include "optimise/parts.hpp"

#include <algorithm>
#include <tuple>

#include "optimise/shape.hpp"

namespace scanmill::optimise {
namespace {

/// Which account says what happened in a block.
class Owners {
 public:
  explicit Owners(std::span<const Account> accounts) {
    for (std::uint32_t n = 0; n < accounts.size(); ++n)
      for (const Block& block : accounts[n].own) blocks_.emplace_back(block, n);
    std::sort(blocks_.begin(), blocks_.end());
  }
  /// kNobody when no account has the block.
  static constexpr std::uint32_t kNobody = 0xffffffffu;
  std::uint32_t of(const Block& block) const {
    const auto at = std::lower_bound(blocks_.begin(), blocks_.end(), std::pair{block, 0u});
    return at == blocks_.end() || at->first != block ? kNobody : at->second;
  }

 private:
  std::vector<std::pair<Block, std::uint32_t>> blocks_;
};

std::span<const Events> events_in(const Account& account, const Block& block) {
  const auto begin = std::lower_bound(account.events.begin(), account.events.end(), block,
                                      [](const Events& e, const Block& b) { return e.block < b; });
  auto end = begin;
  while (end != account.events.end() && end->block == block) ++end;
  return {begin, end};
}

/// A part whose own mesh has come to rest looks no more at the edges that are held, while others may go on: where
/// nothing is swapped any more, held edges stay held, whenever they are looked at.
bool same_in(const Block& block, const Account& a, const Account& b) {
  const auto of_a = events_in(a, block), of_b = events_in(b, block);
  auto counts = [&](const Events& e) { return e.swaps > 0 || e.turn <= std::min(a.turns[e.pass], b.turns[e.pass]); };
  auto i = of_a.begin(), j = of_b.begin();
  while (true) {
    while (i != of_a.end() && !counts(*i)) ++i;
    while (j != of_b.end() && !counts(*j)) ++j;
    if (i == of_a.end() || j == of_b.end()) return i == of_a.end() && j == of_b.end();
    if (std::tie(i->pass, i->turn, i->sum) != std::tie(j->pass, j->turn, j->sum)) return false;
    ++i, ++j;
  }
}

void add(Refused& sum, const Refused& r) {
  sum.patch_border += r.patch_border;
  sum.not_convex += r.not_convex;
  sum.range += r.range;
  sum.angle += r.angle;
  sum.fold += r.fold;
  sum.edge_exists += r.edge_exists;
  sum.crossing += r.crossing;
}

}  // namespace

bool agree(std::span<const Account> accounts) {
  const Owners owners(accounts);
  for (const Account& account : accounts) {
    if (!account.is_sure) return false;
    for (const Block& block : account.watched) {
      const std::uint32_t owner = owners.of(block);
      if (owner == Owners::kNobody || !same_in(block, account, accounts[owner])) return false;
    }
  }
  return true;
}

void PartReports::add(const PartTally& tally, std::span<const Round> rounds, std::span<const double> between) {
  for (std::size_t n = 0; n < 2; ++n) {
    sum_.swaps[n] += tally.swaps[n];
    optimise::add(sum_.refused[n], tally.refused[n]);
    sum_.longest2[n] = std::max(sum_.longest2[n], tally.longest2[n]);
  }
  sum_.before_feature.add(tally.before_feature);
  sum_.after_feature.add(tally.after_feature);
  rounds_.insert(rounds_.end(), rounds.begin(), rounds.end());
  std::sort(rounds_.begin(), rounds_.end());
  rounds_.erase(std::unique(rounds_.begin(), rounds_.end()), rounds_.end());
  between_.insert(between_.end(), between.begin(), between.end());
}

Report PartReports::report(std::span<const Triangle> before, const Mesh& mesh, const Params& params,
                           const Limits& limits, const Context& context) {
  auto p5_of = [&](std::span<const Triangle> triangles) {
    return fifth_percentile_deg(
        shapes_of(
            mesh.positions, triangles.size(), [&](std::size_t n) -> const Triangle& { return triangles[n]; }, context)
            .cos2);
  };
  Report report;
  if ((!params.smooth && !params.feature) || mesh.triangles.empty()) return report;
  std::uint32_t passes = 0;
  double p5 = p5_of(before);
  auto pass = [&](PassReport& to, bool is_last) {
    const std::uint32_t n = passes++;
    to.done = true;
    to.swaps = sum_.swaps[n];
    for (const Round& round : rounds_) to.rounds += round.pass == n;
    to.refused = sum_.refused[n];
    to.angle_p5_before_deg = p5;
    to.angle_p5_after_deg = p5 = is_last ? p5_of(mesh.triangles) : fifth_percentile_deg(std::move(between_));
    to.longest_edge_mm = std::sqrt(sum_.longest2[n]);
  };
  if (params.smooth) pass(report.smooth, !params.feature);
  if (params.feature) {
    pass(report.feature, true);
    report.before_feature = sum_.before_feature.creases(limits.range_mm);
    report.after_feature = sum_.after_feature.creases(limits.range_mm);
  }
  return report;
}

}  // namespace scanmill::optimise
