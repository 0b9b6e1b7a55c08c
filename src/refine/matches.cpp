// SPDX-License-Identifier: Apache-2.0
#include "refine/matches.hpp"

#include <algorithm>
#include <cmath>

namespace scanmill::refine {
namespace {

constexpr double kReach = 1.5;          // edges
constexpr double kLeastCosine = 0.906;  // 25 degrees
constexpr std::size_t kGrain = 256;

/// Patches sorted into cubes of the reach, rows of cubes along z behind each other; copied, so that those of a place
/// stand together in memory.
class Cubes {
 public:
  Cubes(const std::vector<Patch>& patches, double reach) : reach_(reach) {
    for (std::size_t i = 0; i < patches.size(); ++i)
      sorted_.push_back({key(step(patches[i].centre.x), step(patches[i].centre.y), step(patches[i].centre.z)),
                         static_cast<std::uint32_t>(i)});
    std::sort(sorted_.begin(), sorted_.end(),
              [](const Entry& a, const Entry& b) { return a.key != b.key ? a.key < b.key : a.row < b.row; });
    copies_.reserve(patches.size());
    for (const Entry& entry : sorted_) copies_.push_back(patches[entry.row]);
  }

  /// Calls see(row, patch) for every patch in the 27 cubes around p.
  template <class See>
  void around(Vec3 p, See see) const {
    const std::int64_t x = step(p.x), y = step(p.y), z = step(p.z);
    for (std::int64_t i = x - 1; i <= x + 1; ++i)
      for (std::int64_t j = y - 1; j <= y + 1; ++j) {
        const std::uint64_t last = key(i, j, z + 1);
        auto at = std::lower_bound(sorted_.begin(), sorted_.end(), key(i, j, z - 1),
                                   [](const Entry& entry, std::uint64_t wanted) { return entry.key < wanted; });
        for (; at != sorted_.end() && at->key <= last; ++at)
          see(at->row, copies_[static_cast<std::size_t>(at - sorted_.begin())]);
      }
  }

 private:
  struct Entry {
    std::uint64_t key;
    std::uint32_t row;
  };
  static constexpr std::int64_t kMiddle = 1 << 20;

  std::int64_t step(double v) const {
    return static_cast<std::int64_t>(
        std::clamp(std::floor(v / reach_) + static_cast<double>(kMiddle), 1.0, 2.0 * kMiddle - 2));
  }
  static std::uint64_t key(std::int64_t x, std::int64_t y, std::int64_t z) {
    return static_cast<std::uint64_t>(x << 42 | y << 21 | z);
  }

  double reach_;
  std::vector<Entry> sorted_;
  std::vector<Patch> copies_;
};

/// The nearest patch of each view, for one patch at a time.
class NearestOfViews {
 public:
  explicit NearestOfViews(std::size_t views) : best_(views) {}
  void clear() {
    for (const std::uint32_t view : met_) best_[view] = {};
    met_.clear();
  }
  void take(std::uint32_t view, std::uint32_t row, double distance2) {
    Best& best = best_[view];
    if (best.row == kNone) met_.push_back(view);
    if (best.row != kNone && (distance2 > best.distance2 || (distance2 == best.distance2 && row > best.row))) return;
    best = {row, distance2};
  }
  /// Rows, by view.
  template <class Take>
  void each(Take take) {
    std::sort(met_.begin(), met_.end());
    for (const std::uint32_t view : met_) take(best_[view].row);
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;
  struct Best {
    std::uint32_t row = kNone;
    double distance2 = 0;
  };
  std::vector<Best> best_;
  std::vector<std::uint32_t> met_;
};

}  // namespace

std::vector<Match> matches_of(const Patches& patches, const Context& context) {
  const std::vector<Patch>& all = patches.list;
  const double reach = kReach * patches.edge_mm;
  const Cubes cubes(all, reach);
  std::size_t views = 0;
  for (const Patch& patch : all) views = std::max<std::size_t>(views, patch.view + 1);
  std::vector<std::vector<Match>> of_piece((all.size() + kGrain - 1) / kGrain);
  for_each_piece(context, all.size(), kGrain, [&](std::size_t begin, std::size_t end, std::size_t piece, int) {
    NearestOfViews nearest(views);
    for (std::size_t a = begin; a < end; ++a) {
      const Patch& own = all[a];
      nearest.clear();
      cubes.around(own.centre, [&](std::uint32_t row, const Patch& other) {
        const double distance2 = norm2(other.centre - own.centre);
        if (distance2 > reach * reach || other.view == own.view) return;
        const double cosine = dot(other.normal, own.normal);
        if ((patches.sided ? cosine : std::abs(cosine)) < kLeastCosine) return;
        nearest.take(other.view, row, distance2);
      });
      nearest.each([&](std::uint32_t row) {
        Match match;
        match.a = static_cast<std::uint32_t>(a);
        match.b = row;
        const Vec3 n = own.normal, m = all[row].normal;
        match.normal = unit(dot(n, m) < 0 ? n - m : n + m);
        match.gap = dot(own.centre - all[row].centre, match.normal);
        of_piece[piece].push_back(match);
      });
    }
  });
  std::vector<Match> matches;
  if (context.cancel.is_set()) return matches;
  for (const std::vector<Match>& piece : of_piece) matches.insert(matches.end(), piece.begin(), piece.end());
  return matches;
}

}  // namespace scanmill::refine
