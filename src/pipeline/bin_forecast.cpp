// SPDX-License-Identifier: Apache-2.0
#include "pipeline/bin_forecast.hpp"

#include "base/digest.hpp"

namespace scanmill::pipeline {

BinForecast::BinForecast(const reduce::LocalFrame& frame, int workers, int one_in)
    : frame_(frame), one_in_(static_cast<std::uint64_t>(one_in)), parts_(static_cast<std::size_t>(workers)) {}

void BinForecast::look(int worker, const PointBlock& block) {
  Part& part = parts_[static_cast<std::size_t>(worker)];
  part.bins.clear();
  LocalBin last{};
  bool known = false, taken = false;
  for (const Vec3 p : block.positions) {
    LocalBin bin;
    if (!frame_.bin_of(p, bin)) continue;
    const LocalBin leaf{bin[0] >> 3, bin[1] >> 3, bin[2] >> 3};
    if (!known || leaf != last) {
      const auto word = [](std::int32_t v) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(v)); };
      taken = mix64(word(leaf[0]) ^ mix64(word(leaf[1]) ^ mix64(word(leaf[2])))) % one_in_ == 0;
      last = leaf;
      known = true;
    }
    if (taken) part.bins.push_back(bin);
  }
  part.slots.resize(part.bins.size());
  part.tree.slots_of(part.bins, part.slots);
}

void BinForecast::take(Part& from) {
  Part& all = parts_.front();
  all.bins.clear();
  for (const BinTree::Entry& entry : from.tree.sorted(frame_.base)) all.bins.push_back(entry.bin);
  all.slots.resize(all.bins.size());
  all.tree.slots_of(all.bins, all.slots);
}

std::uint64_t BinForecast::bins() {
  for (std::size_t n = 1; n < parts_.size(); ++n) {
    take(parts_[n]);
    parts_[n] = {};
  }
  return static_cast<std::uint64_t>(parts_.front().tree.size()) * one_in_;
}

void BinForecast::add(BinForecast& other) {
  for (Part& part : other.parts_) take(part);
}

}  // namespace scanmill::pipeline
