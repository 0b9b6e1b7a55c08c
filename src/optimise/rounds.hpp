// SPDX-License-Identifier: Apache-2.0
// Synchronous rounds of swaps under one rule. Internal to `optimise`.
//
// A rule has
//   double gain(std::uint32_t half) const    by how much swapping that inner edge improves the mesh; <= 0: not at all.
//                                            Depends on its two triangles and their neighbours only.
//   Vec3 normal(std::uint32_t slot) const    unit normal of a slot's triangle
//   void swapped(const Quad&)                the quad's triangles are the new ones now; called at the same time for
//   quads
//                                            that share no triangle with each other's sides
#pragma once
#include <algorithm>
#include <vector>

#include "base/context.hpp"
#include "optimise/crossing.hpp"
#include "optimise/guards.hpp"
#include "optimise/optimise.hpp"
#include "optimise/surface.hpp"
#include "optimise/witness.hpp"

namespace scanmill::optimise {

/// The part of a pass that knows no rule: who competes, who wins, what is to be looked at again.
class Contest {
 public:
  Contest(Surface& surface, NearVertices& near, const Context& context);

  /// After `judge_all`: the winners of this round that pass the last guards, as flags beside `winners()`.
  void choose();
  const std::vector<Winner>& winners() const { return winners_; }
  bool swaps(std::size_t winner) const { return obstacle_[winner] == Obstacle::None && !outdone_[winner]; }
  void tell(Witness& witness) const;
  /// The next round looks at the triangles around the swaps; true when any swap was made. Called after the swapping.
  bool close_round();
  /// Edges that were held by triangles elsewhere are to be looked at again; false when there is none or nothing has
  /// changed since the last time.
  bool reopen();
  bool competing() const { return !candidates_.empty(); }
  bool anything_to_judge() const { return !dirty_.empty(); }

  /// judge(half) gives {gain, refusal} for an inner edge; called for each edge of the triangles in question.
  template <class Judge>
  void judge_all(const Judge& judge);

  /// own: of which vertices edges are counted, at the lesser one; empty: of all.
  Refused count_refused(std::span<const std::uint8_t> own) const;
  std::uint64_t swaps_made() const { return swaps_made_; }

 private:
  bool is_best(std::uint32_t half) const;
  std::uint64_t key(std::uint32_t half) const {
    const std::uint64_t a = surface_.from(half), b = surface_.to(half);
    return a < b ? a << 32 | b : b << 32 | a;
  }
  bool better(const Winner& x, const Winner& y) const {
    return x.gain != y.gain ? x.gain > y.gain : key(x.half) < key(y.half);
  }
  void find_winners();
  void drop_stale_candidates();
  void clear_pieces(std::size_t count);

  static constexpr std::size_t kGrain = 2048;
  Surface& surface_;
  NearVertices& near_;
  CrossingGuard guard_;
  const Context& context_;
  std::uint32_t round_ = 1;
  std::uint64_t swaps_made_ = 0, swaps_at_reopening_ = 0;
  std::vector<std::uint32_t> dirty_;       // slots to judge in this round, each once
  std::vector<std::uint32_t> dirty_in_;    // per slot: the last round in which it was dirty
  std::vector<float> gain_;                // per half-edge, the same from both sides; 0 = does not compete
  std::vector<Refusal> refusal_;           // per edge, at its lesser half-edge
  std::vector<std::uint32_t> candidates_;  // lesser half-edges of the edges that compete
  std::vector<Winner> winners_;
  std::vector<Obstacle> obstacle_;
  std::vector<std::uint8_t> outdone_;
  std::vector<std::uint32_t> winner_of_;  // per slot, kNone outside a round
  std::vector<std::vector<std::uint32_t>> pieces_;
};

template <class Judge>
void Contest::judge_all(const Judge& judge) {
  drop_stale_candidates();
  const std::size_t pieces = (dirty_.size() + kGrain - 1) / kGrain;
  clear_pieces(pieces);
  for_each_piece(context_, dirty_.size(), kGrain, [&](std::size_t begin, std::size_t end, std::size_t piece, int) {
    auto& found = pieces_[piece];
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t t = dirty_[i];
      for (std::uint32_t h = half_of(t, 0); h < half_of(t, 3); ++h) {
        const std::uint32_t twin = surface_.twin(h);
        if (twin == kNone) {
          gain_[h] = 0;  // an inner edge of this slot may have competed under this number
          continue;
        }
        if (twin < h && dirty_in_[slot_of(twin)] == round_) continue;  // judged from the other side
        const std::uint32_t edge = std::min(h, twin);
        const auto [gain, refusal] = judge(edge);
        gain_[h] = gain_[twin] = gain;
        refusal_[edge] = refusal;
        if (gain > 0) found.push_back(edge);
      }
    }
  });
  for (std::size_t piece = 0; piece < pieces; ++piece)
    candidates_.insert(candidates_.end(), pieces_[piece].begin(), pieces_[piece].end());
}

struct Judged {
  float gain;
  Refusal refusal;
};

/// Until no swap is left that improves and passes the guards. The mesh is in between when cancelled. The witness of a
/// part sees it; refused edges are then counted of its own vertices only.
/// errors  Cancelled
template <class R>
Result<void> run_rounds(Surface& surface, R& rule, NearVertices& near, const Limits& limits, const Context& context,
                        PassReport& report, std::span<const std::uint8_t> own = {}, Witness* witness = nullptr) {
  Contest contest(surface, near, context);
  auto normal = [&](std::uint32_t slot) { return rule.normal(slot); };
  do {
    if (witness) witness->begin_turn();
    while (contest.anything_to_judge() || contest.competing()) {
      contest.judge_all([&](std::uint32_t edge) -> Judged {
        const double gain = rule.gain(edge);
        if (!(gain > 0)) return {0, Refusal::None};
        const Refusal refusal = refused_by(surface, surface.quad(edge), limits, normal);
        return {refusal == Refusal::None ? static_cast<float>(gain) : 0, refusal};
      });
      contest.choose();
      if (witness) contest.tell(*witness);
      const auto& winners = contest.winners();
      for_each_range(context, winners.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t w = begin; w < end; ++w) {
          if (!contest.swaps(w)) continue;
          surface.swap(winners[w].quad);
          rule.swapped(winners[w].quad);
        }
      });
      if (context.cancel.is_set()) return fail(Code::Cancelled, "cancelled while swapping edges");
      report.rounds += contest.close_round();
    }
  } while (contest.reopen());
  report.swaps = contest.swaps_made();
  report.refused = contest.count_refused(own);
  return {};
}

}  // namespace scanmill::optimise
