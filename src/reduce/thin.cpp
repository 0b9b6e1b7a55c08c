// SPDX-License-Identifier: Apache-2.0
// Greedy thinning by rounds (docs/algorithm.md, "Thin"). Every decision is a function of the points within a few bins.
#include "reduce/thin.hpp"

#include <algorithm>

namespace scanmill::reduce {
namespace {

constexpr std::size_t kGrain = 4096;
/// A ball of this radius (bin edges) between two measured points, with no kept point in it, is a void: kept points may
/// face each other over 2 h, and four of them at the corners of a rectangle over more than g1, 2.5 h.
constexpr double kVoid = 1.0;
constexpr double kFarthestPair = 2.2;   // bin edges: winners of neighbouring bins
constexpr double kOneFace = 0.7;        // least cosine of normals on one face
constexpr double kFlat = 0.2;           // greatest residual there, bin edges
constexpr std::size_t kMostLoose = 16;  // one row in so many: with more of them, windows are wide everywhere
constexpr double kLeastStep = 0.5;  // of c2: nearer to a kept point than that, a point would close little of the void

/// Points around one, kept from row to row for their memory.
struct Scratch {
  std::vector<std::int32_t> rows, wide;
  std::vector<std::uint32_t> kept;
};

using Rows = std::vector<std::uint32_t>;

/// What is known of a row: in a part of a cloud, what lies beyond it may leave a row open.
enum State : std::uint8_t { kDropped, kKept, kOpen };
using States = std::vector<std::uint8_t>;

struct Thinning {
  const ReducedCloud& cloud;
  const std::vector<double>& order;
  const std::vector<Vec3>& position;
  double limit2;
  const Context& context;
  const std::vector<std::uint8_t>& seen;  // per row: all around it is there; none: around all of them
  std::vector<std::uint8_t> wide = {};    // per row; none: all are

  bool is_before(std::size_t a, std::size_t b) const { return order[a] != order[b] ? order[a] < order[b] : a < b; }
  bool on_two_sides(std::size_t a, std::size_t b) const {
    return cloud.sign_known[a] && cloud.sign_known[b] && dot(cloud.normal[a], cloud.normal[b]) < 0;
  }
  /// Both on a face: not at a crease or the rim of a plate, where frames say little, nor across one.
  bool on_one_face(std::size_t a, std::size_t b) const {
    const double cosine = dot(cloud.normal[a], cloud.normal[b]);
    return cloud.residual[a] <= kFlat && cloud.residual[b] <= kFlat &&
           (cloud.sign_known[a] && cloud.sign_known[b] ? cosine : std::abs(cosine)) >= kOneFace;
  }
  double distance2(std::size_t a, std::size_t b) const { return norm2(position[a] - position[b]); }
  bool is_seen(std::size_t row) const { return seen.empty() || seen[row] != 0; }

  /// Fills `wide`. Points nearer than c2 whose positions have not left the measured points by more than half of what c2
  /// leaves of a bin edge lie in bins that touch; only around points that have does one look farther.
  void find_wide();
  /// The greedy set among the marked rows, which are `rows` in order. Rows marked kOpen may be among them or not.
  /// `close`, where there is one: 1 for rows found to lie nearer to a kept one than half c2, as is seen in passing; 0
  /// tells nothing.
  States greedy(const States& marked, const Rows& rows, std::vector<std::uint8_t>* close) const;
  /// kKept for the dropped rows that lie beside a void.
  States beside_voids(const States& marked, const States& kept, const std::vector<std::uint8_t>& close) const;
  /// Rows whose surroundings are not known: those at the rim of the part, and those near an open one. None: all are.
  std::vector<std::uint8_t> unsure(const States& kept) const;
  bool is_beside_void(std::size_t row, const States& marked, const States& kept, BinIndex::Reader& reader,
                      Scratch& near) const;
};

void Thinning::find_wide() {
  const double loose = (cloud.lattice.edge_mm - std::sqrt(limit2)) / 2 * (1 - 1e-9);
  if (!(loose > 0)) return;
  Rows rows;
  for (std::size_t row = 0; row < cloud.size(); ++row)
    if (norm2(position[row] - cloud.measured[row]) > loose * loose) rows.push_back(static_cast<std::uint32_t>(row));
  if (rows.size() > cloud.size() / kMostLoose) return;
  wide.assign(cloud.size(), 0);
  BinIndex::Reader reader(cloud.index);
  std::vector<std::int32_t> around;
  for (const std::uint32_t row : rows) {
    around.clear();
    reader.window(cloud.bins[row], 2, around);
    for (const std::int32_t near : around) wide[static_cast<std::size_t>(near)] = 1;
  }
}

States Thinning::greedy(const States& marked, const Rows& rows, std::vector<std::uint8_t>* close) const {
  const double close2 = kLeastStep * kLeastStep * limit2;
  const std::size_t n = rows.size();
  // Better neighbours within reach, as ranges of one array per piece.
  std::vector<Rows> rivals((n + kGrain - 1) / kGrain);
  Rows first(n), count(n);
  for_each_piece(context, n, kGrain, [&](std::size_t begin, std::size_t end, std::size_t piece, int) {
    BinIndex::Reader reader(cloud.index);
    std::vector<std::int32_t> around;
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t row = rows[i];
      first[i] = static_cast<std::uint32_t>(rivals[piece].size());
      around.clear();
      reader.window(cloud.bins[row], wide.empty() || wide[row] ? 2 : 1, around);
      for (const std::int32_t near : around) {
        const auto other = static_cast<std::size_t>(near);
        if (!marked[other] || !is_before(other, row)) continue;  // nor before itself
        if (distance2(row, other) >= limit2 || on_two_sides(row, other)) continue;
        rivals[piece].push_back(static_cast<std::uint32_t>(other));
      }
      count[i] = static_cast<std::uint32_t>(rivals[piece].size()) - first[i];
    }
  });
  States state(marked), next(n);
  Rows open;  // places in `rows` that can be decided
  for (std::size_t i = 0; i < n; ++i) {
    const bool sure = is_seen(rows[i]);
    state[rows[i]] = sure && count[i] == 0 ? kKept : kOpen;
    if (sure && count[i] != 0) open.push_back(static_cast<std::uint32_t>(i));
  }
  while (!open.empty() && !context.cancel.is_set()) {
    for_each_range(context, open.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t at = begin; at < end; ++at) {
        const std::uint32_t i = open[at];
        const std::uint32_t* rival = rivals[i / kGrain].data() + first[i];
        bool any_open = false, any_kept = false;
        for (std::uint32_t k = 0; k < count[i]; ++k) {
          any_open |= state[rival[k]] == kOpen;
          any_kept |= state[rival[k]] == kKept;
        }
        next[i] = any_kept ? kDropped : any_open ? kOpen : kKept;
        for (std::uint32_t k = 0; close != nullptr && any_kept && k < count[i]; ++k)
          (*close)[rows[i]] |= state[rival[k]] == kKept && distance2(rows[i], rival[k]) < close2;
      }
    });
    std::size_t left = 0;
    for (const std::uint32_t i : open) {
      state[rows[i]] = next[i];
      if (next[i] == kOpen) open[left++] = i;
    }
    if (left == open.size()) break;  // all wait for what is not known
    open.resize(left);
  }
  return state;
}

bool Thinning::is_beside_void(std::size_t row, const States& marked, const States& kept, BinIndex::Reader& reader,
                              Scratch& near) const {
  const double h = cloud.lattice.edge_mm, radius = kVoid * h, radius2 = radius * radius;
  const double least2 = kLeastStep * kLeastStep * limit2, farthest2 = kFarthestPair * kFarthestPair * h * h;
  // Some kept point lies within c2 of this one, so that balls about nearer pairs hold it.
  const double apart = std::max(0.0, radius - std::sqrt(limit2)), dropped2 = 4 * apart * apart;
  const double beyond = radius + apart, kept2 = beyond * beyond;
  near.rows.clear();
  near.kept.clear();
  reader.window(cloud.bins[row], 2, near.rows);
  for (const std::int32_t neighbour : near.rows) {
    const auto other = static_cast<std::size_t>(neighbour);
    if (!kept[other]) continue;
    const double d2 = distance2(row, other);
    if (d2 < least2) return false;
    near.kept.push_back(static_cast<std::uint32_t>(other));
    if (d2 < limit2) std::swap(near.kept.front(), near.kept.back());  // likely in the ball: asked first
  }
  const std::size_t inner = near.rows.size();
  bool widened = false;
  const auto holds_kept = [&](std::size_t begin, const Vec3& centre, std::size_t except) {
    for (std::size_t i = begin; i < near.kept.size(); ++i)
      if (near.kept[i] != except && norm2(position[near.kept[i]] - centre) < radius2) return true;
    return false;
  };
  for (std::size_t i = 0; i < inner; ++i) {
    const auto other = static_cast<std::size_t>(near.rows[i]);
    if (other == row || !marked[other]) continue;
    const double d2 = distance2(row, other);
    if (d2 > farthest2 || d2 < (kept[other] ? kept2 : dropped2) || !on_one_face(row, other)) continue;
    // Between two dropped points the ball stands in the middle; a kept one lies on it.
    const Vec3 centre = kept[other] ? position[other] + (position[row] - position[other]) * (radius / std::sqrt(d2))
                                    : (position[row] + position[other]) * 0.5;
    if (holds_kept(0, centre, other)) continue;
    if (!widened) {
      const std::size_t known = near.kept.size();
      near.wide.clear();
      reader.window(cloud.bins[row], 3, near.wide);
      for (const std::int32_t far : near.wide)
        if (kept[static_cast<std::size_t>(far)]) near.kept.push_back(static_cast<std::uint32_t>(far));
      widened = true;
      if (holds_kept(known, centre, other)) continue;
    }
    return true;
  }
  return false;
}

std::vector<std::uint8_t> Thinning::unsure(const States& kept) const {
  if (seen.empty()) return {};
  std::vector<std::uint8_t> is_unsure(cloud.size());
  BinIndex::Reader reader(cloud.index);
  std::vector<std::int32_t> around;
  for (std::size_t row = 0; row < cloud.size(); ++row) {
    is_unsure[row] |= seen[row] == 0;
    if (kept[row] != kOpen) continue;
    around.clear();
    reader.window(cloud.bins[row], kThinReach, around);
    for (const std::int32_t near : around) is_unsure[static_cast<std::size_t>(near)] = 1;
  }
  return is_unsure;
}

States Thinning::beside_voids(const States& marked, const States& kept, const std::vector<std::uint8_t>& close) const {
  const std::vector<std::uint8_t> is_unsure = unsure(kept);
  States beside(cloud.size(), kDropped);
  for_each_range(context, cloud.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    BinIndex::Reader reader(cloud.index);
    Scratch near;
    for (std::size_t row = begin; row < end; ++row) {
      if (!marked[row] || kept[row] == kKept || close[row] || cloud.residual[row] > kFlat) continue;
      if (!is_unsure.empty() && is_unsure[row])
        beside[row] = kOpen;
      else if (is_beside_void(row, marked, kept, reader, near))
        beside[row] = kKept;
    }
  });
  return beside;
}

Rows rows_of(const States& states, State state) {
  Rows rows;
  for (std::size_t row = 0; row < states.size(); ++row)
    if (states[row] == state) rows.push_back(static_cast<std::uint32_t>(row));
  return rows;
}

}  // namespace

std::vector<std::uint8_t> thin(ReducedCloud& cloud, const std::vector<double>& order, double distance_bins,
                               bool on_projected, const std::vector<std::uint8_t>& seen, const Context& context) {
  const double limit = distance_bins * cloud.lattice.edge_mm;
  Thinning thinning{cloud, order, on_projected ? cloud.projected : cloud.measured, limit * limit, context, seen};
  thinning.find_wide();
  States marked(cloud.size());
  for (std::size_t row = 0; row < cloud.size(); ++row) marked[row] = cloud.drop[row] == Drop::Kept ? kKept : kDropped;
  std::vector<std::uint8_t> close(on_projected ? cloud.size() : 0, 0);
  States kept = thinning.greedy(marked, rows_of(marked, kKept), on_projected ? &close : nullptr);
  if (on_projected) {
    const States beside = thinning.beside_voids(marked, kept, close);
    const States back = thinning.greedy(beside, rows_of(beside, kKept), nullptr);
    for (std::size_t row = 0; row < cloud.size(); ++row)
      if (kept[row] == kDropped) kept[row] = back[row];
  }
  std::vector<std::uint8_t> open(seen.empty() ? 0 : cloud.size(), 0);
  for (std::size_t row = 0; row < cloud.size(); ++row) {
    if (marked[row] && kept[row] == kDropped) cloud.drop[row] = Drop::NeighbourDistance;
    if (kept[row] == kOpen) open[row] = 1;
  }
  return open;
}

}  // namespace scanmill::reduce
