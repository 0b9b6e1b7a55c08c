// SPDX-License-Identifier: Apache-2.0
// Writes down what a part decides, block by block. Internal to `optimise`.
#pragma once
#include <algorithm>
#include <unordered_map>
#include <vector>

#include "base/digest.hpp"
#include "optimise/crossing.hpp"
#include "optimise/parts.hpp"
#include "optimise/surface.hpp"

namespace scanmill::optimise {

class Witness {
 public:
  explicit Witness(const Part& part);

  void begin_pass(std::uint16_t pass);
  void begin_turn();
  void begin_round() { ++round_; }
  /// A winner of the round that is swapped, held, or outdone by another.
  void see(const Quad& quad, Obstacle obstacle, bool is_outdone);
  /// After the last pass: ascending, of the blocks for which wanted(number) holds.
  template <class Wanted>
  std::vector<Events> events(const Wanted& wanted);

  std::span<const Block> blocks() const { return blocks_; }  // ascending
  std::uint32_t block_of(std::uint32_t vertex) const { return block_of_[vertex]; }
  std::uint32_t turns() const { return turns_; }
  std::uint64_t own_swaps() const { return own_swaps_; }
  std::vector<Round>& rounds() { return rounds_; }

 private:
  void close_turn();

  const Part& part_;
  std::vector<Block> blocks_;
  std::vector<std::uint32_t> block_of_;             // per vertex
  std::unordered_map<std::uint32_t, Events> open_;  // of this turn, by block
  std::vector<std::pair<std::uint32_t, Events>> closed_;
  std::vector<Round> rounds_;
  std::uint32_t pass_ = 0, turns_ = 0, round_ = 0;
  std::uint64_t own_swaps_ = 0;
};

template <class Wanted>
std::vector<Events> Witness::events(const Wanted& wanted) {
  close_turn();
  std::vector<Events> events;
  for (const auto& [block, of] : closed_)
    if (wanted(block)) events.push_back(of);
  std::sort(events.begin(), events.end(), [](const Events& a, const Events& b) {
    return std::tie(a.block, a.pass, a.turn) < std::tie(b.block, b.pass, b.turn);
  });
  return events;
}

}  // namespace scanmill::optimise
