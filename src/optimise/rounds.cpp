// SPDX-License-Identifier: Apache-2.0
#include "optimise/rounds.hpp"

#include <numeric>

namespace scanmill::optimise {

Contest::Contest(Surface& surface, NearVertices& near, const Context& context)
    : surface_(surface),
      near_(near),
      guard_(surface, near),
      context_(context),
      dirty_(surface.slot_count()),
      dirty_in_(surface.slot_count(), 1),
      gain_(kPerSlot * surface.slot_count(), 0),
      refusal_(kPerSlot * surface.slot_count(), Refusal::None),
      winner_of_(surface.slot_count(), kNone) {
  std::iota(dirty_.begin(), dirty_.end(), 0u);
}

// Before the loop: a cancelled loop leaves pieces undone.
void Contest::clear_pieces(std::size_t count) {
  if (pieces_.size() < count) pieces_.resize(count);
  for (auto& piece : pieces_) piece.clear();
}

void Contest::drop_stale_candidates() {
  std::erase_if(candidates_, [&](std::uint32_t h) {
    return dirty_in_[slot_of(h)] == round_ || !(gain_[h] > 0) || dirty_in_[slot_of(surface_.twin(h))] == round_;
  });
}

// An edge competes with all edges whose two triangles and neighbours have a triangle in common with its own: those of
// the triangles at most two steps away.
bool Contest::is_best(std::uint32_t half) const {
  const float mine = gain_[half];
  const std::uint32_t other_half = surface_.twin(half);
  const std::uint64_t my_key = key(half);
  auto beaten_in = [&](std::uint32_t t) {
    for (std::uint32_t h = half_of(t, 0); h < half_of(t, 3); ++h)
      if (gain_[h] >= mine && h != half && h != other_half && (gain_[h] > mine || key(h) < my_key)) return true;
    return false;
  };
  std::uint32_t near[6];
  unsigned count = 0;
  for (const std::uint32_t t : {slot_of(half), slot_of(other_half)}) {
    if (beaten_in(t)) return false;
    for (const std::uint32_t h : surface_.slot(t).twin)
      if (h != kNone && h != half && h != other_half) near[count++] = slot_of(h);
  }
  for (unsigned i = 0; i < count; ++i)
    if (beaten_in(near[i])) return false;
  for (unsigned i = 0; i < count; ++i)
    for (const std::uint32_t h : surface_.slot(near[i]).twin)
      if (h != kNone && beaten_in(slot_of(h))) return false;
  return true;
}

void Contest::find_winners() {
  const std::size_t pieces = (candidates_.size() + kGrain - 1) / kGrain;
  clear_pieces(pieces);
  for_each_piece(context_, candidates_.size(), kGrain, [&](std::size_t begin, std::size_t end, std::size_t piece, int) {
    for (std::size_t i = begin; i < end; ++i)
      if (is_best(candidates_[i])) pieces_[piece].push_back(candidates_[i]);
  });
  winners_.clear();
  for (std::size_t piece = 0; piece < pieces; ++piece)
    for (const std::uint32_t h : pieces_[piece]) winners_.push_back({h, gain_[h], surface_.quad(h)});
}

void Contest::choose() {
  find_winners();
  if (context_.cancel.is_set()) winners_.clear();
  obstacle_.assign(winners_.size(), Obstacle::None);
  outdone_.assign(winners_.size(), 0);
  for (std::uint32_t w = 0; w < winners_.size(); ++w) {
    const Quad& q = winners_[w].quad;
    winner_of_[q.t] = winner_of_[q.u] = w;
    // The new edges count at once, so that of two winners close to each other at least one sees the other.
    const double length2 = norm2(surface_.at(q.c) - surface_.at(q.d));
    near_.reach_at_least(q.c, length2);
    near_.reach_at_least(q.d, length2);
  }
  for_each_range(context_, winners_.size(), 256, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> rivals;
    for (std::size_t w = begin; w < end; ++w) {
      rivals.clear();
      obstacle_[w] = guard_.judge(static_cast<std::uint32_t>(w), winners_, winner_of_, rivals);
      if (obstacle_[w] != Obstacle::None) continue;
      for (const std::uint32_t r : rivals)
        std::atomic_ref(outdone_[better(winners_[w], winners_[r]) ? r : w]).store(1, std::memory_order_relaxed);
    }
  });
  for (const Winner& w : winners_) winner_of_[w.quad.t] = winner_of_[w.quad.u] = kNone;
}

void Contest::tell(Witness& witness) const {
  witness.begin_round();
  for (std::size_t w = 0; w < winners_.size(); ++w) witness.see(winners_[w].quad, obstacle_[w], outdone_[w] != 0);
}

bool Contest::close_round() {
  ++round_;
  dirty_.clear();
  auto look_at = [&](std::uint32_t t) {
    if (dirty_in_[t] == round_) return;  // a triangle over two sides
    dirty_in_[t] = round_;
    dirty_.push_back(t);
  };
  bool any = false;
  for (std::size_t w = 0; w < winners_.size(); ++w) {
    const Winner& winner = winners_[w];
    if (obstacle_[w] != Obstacle::None) {
      const std::uint32_t twin = surface_.twin(winner.half);
      gain_[winner.half] = gain_[twin] = 0;
      refusal_[winner.half] = obstacle_[w] == Obstacle::Crossing ? Refusal::Crossing : Refusal::EdgeExists;
      continue;
    }
    if (outdone_[w]) continue;
    any = true;
    ++swaps_made_;
    for (const std::uint32_t t : {winner.quad.t, winner.quad.u}) {
      look_at(t);
      for (const std::uint32_t h : surface_.slot(t).twin)
        if (h != kNone) look_at(slot_of(h));
    }
  }
  winners_.clear();
  return any;
}

bool Contest::reopen() {
  if (swaps_made_ == swaps_at_reopening_) return false;
  swaps_at_reopening_ = swaps_made_;
  ++round_;
  for (std::uint32_t h = 0; h < refusal_.size(); ++h) {
    if (refusal_[h] != Refusal::Crossing && refusal_[h] != Refusal::EdgeExists) continue;
    const std::uint32_t twin = surface_.twin(h);
    if (twin == kNone || twin < h || dirty_in_[slot_of(h)] == round_) continue;
    dirty_in_[slot_of(h)] = round_;
    dirty_.push_back(slot_of(h));
  }
  return !dirty_.empty();
}

Refused Contest::count_refused(std::span<const std::uint8_t> own) const {
  Refused counts;
  for (std::uint32_t h = 0; h < refusal_.size(); ++h) {
    if (refusal_[h] == Refusal::None) continue;
    const std::uint32_t twin = surface_.twin(h);
    if (twin == kNone || twin < h) continue;  // what an edge left behind that is elsewhere now
    if (!own.empty() && !own[std::min(surface_.from(h), surface_.to(h))]) continue;
    switch (refusal_[h]) {
      case Refusal::None:
        break;
      case Refusal::PatchBorder:
        ++counts.patch_border;
        break;
      case Refusal::NotConvex:
        ++counts.not_convex;
        break;
      case Refusal::Range:
        ++counts.range;
        break;
      case Refusal::Angle:
        ++counts.angle;
        break;
      case Refusal::Fold:
        ++counts.fold;
        break;
      case Refusal::EdgeExists:
        ++counts.edge_exists;
        break;
      case Refusal::Crossing:
        ++counts.crossing;
        break;
    }
  }
  return counts;
}

}  // namespace scanmill::optimise
