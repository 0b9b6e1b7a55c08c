// SPDX-License-Identifier: Apache-2.0
#include "optimise/witness.hpp"

namespace scanmill::optimise {

Witness::Witness(const Part& part) : part_(part), blocks_(part.block), block_of_(part.block.size()) {
  std::sort(blocks_.begin(), blocks_.end());
  blocks_.erase(std::unique(blocks_.begin(), blocks_.end()), blocks_.end());
  for (std::size_t v = 0; v < block_of_.size(); ++v)
    block_of_[v] =
        static_cast<std::uint32_t>(std::lower_bound(blocks_.begin(), blocks_.end(), part.block[v]) - blocks_.begin());
}

void Witness::begin_pass(std::uint16_t pass) {
  close_turn();
  pass_ = pass;
  turns_ = 0;
  own_swaps_ = 0;
}

void Witness::begin_turn() {
  close_turn();
  ++turns_;
  round_ = 0;
}

void Witness::close_turn() {
  for (const auto& [block, events] : open_) closed_.emplace_back(block, events);
  open_.clear();
}

void Witness::see(const Quad& q, Obstacle obstacle, bool is_outdone) {
  const std::uint64_t a = part_.vertex[std::min(q.a, q.b)], b = part_.vertex[std::max(q.a, q.b)];
  const bool is_swapped = obstacle == Obstacle::None && !is_outdone;
  const std::uint64_t outcome = obstacle != Obstacle::None ? 2 + static_cast<std::uint64_t>(obstacle) : is_outdone;
  const std::uint64_t sum = mix64(mix64(a << 32 | b) ^ mix64(std::uint64_t{round_} << 8 | outcome));
  std::uint32_t seen[4] = {block_of_[q.a], block_of_[q.b], block_of_[q.c], block_of_[q.d]};
  std::sort(std::begin(seen), std::end(seen));
  for (std::size_t n = 0; n < 4; ++n) {
    if (n > 0 && seen[n] == seen[n - 1]) continue;
    Events& events = open_[seen[n]];
    if (events.turn == 0)
      events = {blocks_[seen[n]], static_cast<std::uint16_t>(pass_), static_cast<std::uint16_t>(turns_), 0, 0};
    events.swaps += is_swapped;
    events.sum += sum;
  }
  if (!is_swapped || !part_.own[std::min(q.a, q.b)]) return;
  ++own_swaps_;
  const Round round{pass_, turns_, round_};
  if (rounds_.empty() || rounds_.back() != round) rounds_.push_back(round);
}

}  // namespace scanmill::optimise
