// SPDX-License-Identifier: Apache-2.0
// Every round matches patches and solves once for small motions of all views (Gauss-Newton): least squares of the gaps
// along the mean normal, each by what its pieces' noise and bend leave of it and by Geman and McClure's rational
// function, plus the machine's word as a prior: the most probable poses. Where surfaces say nothing, the machine does.
// A view that would leave its accuracy is held at the limit; the others answer in the next round.
#include "refine/refine.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "geom/envelope.hpp"
#include "refine/matches.hpp"

namespace scanmill::refine {
namespace {

constexpr double kSettled = 1e-4;     // mm; no patch moved farther
constexpr double kSigmas = 3;         // the accuracy is so many standard deviations of the machine
constexpr double kFlat = 1.5;         // times the noise's square: pieces within are flat
constexpr double kBend = 0.3;         // of a piece's departure from a plane: how far its mean may lie off the surface
constexpr double kLeastSigma = 1e-4;  // mm; no piece's height is known better
constexpr double kGain = 0.9;         // gaps that do not shrink below so much of what they were are noise
constexpr double kOpen = 0.5;         // of the machine's sigma: what a datum does not tell better stays open
constexpr double kRadian = 57.29577951308232;
constexpr double kFaceCosine = 0.95;

using Six = std::array<double, 6>;

/// A patch that moves with its view and a plane that does not, or moves with another.
struct Row {
  std::uint32_t view = 0;
  std::uint32_t other = 0;  // the same: the plane stands still
  Six mine{}, others{};     // derivative of the gap by the six of each
  double gap = 0, weight = 0;
  double variance = 0;  // of the gap, mm^2, from what its pieces are
  double share = 1;     // of what is told here: k pieces at one place tell k - 1 gaps, not k (k - 1)
};

double median_of(std::vector<double> sizes) {
  if (sizes.empty()) return 0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return *middle;
}
double spread_of(std::vector<double> sizes) { return 1.4826 * median_of(std::move(sizes)); }

/// The machine's word as information about a turn and a shift.
struct Springs {
  double turn = 0, shift = 0;  // standard deviations: radians, mm
  double weight(std::size_t i) const { return i < 3 ? 1 / (turn * turn) : 1 / (shift * shift); }
};

/// Turn about `axis` by its length in radians.
Pose turned(Vec3 axis) { return pose_turned(axis, norm(axis) * kRadian); }

/// The turn between two poses as axis times radians, for small ones.
Vec3 turn_between(const Pose& from, const Pose& to) {
  Pose back = from.inverse();
  back.translation = {};
  Pose forth = to;
  forth.translation = {};
  const auto r = forth.after(back).rotation;
  return {0.5 * (r[7] - r[5]), 0.5 * (r[2] - r[6]), 0.5 * (r[3] - r[1])};
}

Six derivative(Vec3 at, Vec3 pivot, Vec3 normal, double sign) {
  const Vec3 r = cross(at - pivot, normal);
  return {sign * r.x, sign * r.y, sign * r.z, sign * normal.x, sign * normal.y, sign * normal.z};
}

class Refiner {
 public:
  Refiner(Patches patches, std::span<const Pose> poses, const Accuracy& accuracy, std::span<const Datum> datums)
      : patches_(std::move(patches)),
        first_(patches_.list),
        told_(poses.begin(), poses.end()),
        poses_(told_),
        accuracy_(accuracy),
        datums_(datums) {}

  Result<Refinement> run(const Params& params, const Context& context) {
    Report report;
    judge(report);
    report.patch_mm = patches_.edge_mm;
    report.patches = first_.size();
    report.views.resize(told_.size());
    for (const Patch& patch : first_) ++report.views[patch.view].patches;
    std::vector<Match> matches = matches_of(patches_, context);
    std::vector<PairReport> before = pairs_of(matches);
    report.before_mm = spread(matches);
    report.datum_before_mm = spread(datum_rows());
    for (report.rounds = 0; report.rounds < params.rounds && !report.settled; ++report.rounds) {
      if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped while poses were refined");
      step(matches);
      report.settled = place() < kSettled;
      matches = matches_of(patches_, context);
    }
    if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped while poses were refined");
    report.matches = matches.size();
    report.after_mm = report.fitted_mm = spread(matches);
    std::vector<Row> on_bodies = datum_rows();
    report.datum_matches = on_bodies.size();
    report.datum_after_mm = spread(on_bodies);
    if (report.left = fits_as_told(report); report.left) {
      poses_ = told_;
      place();
      matches = matches_of(patches_, context);
      if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped while poses were refined");
      on_bodies = datum_rows();
      report.matches = matches.size();
      report.datum_matches = on_bodies.size();
      report.after_mm = report.before_mm;
      report.datum_after_mm = report.datum_before_mm;
    }
    if (!datums_.empty()) report.datum_open = left_open(on_bodies);
    report.pairs = joined(std::move(before), pairs_of(matches));
    for (std::size_t v = 0; v < told_.size(); ++v) {
      if (report.views[v].patches == 0) continue;
      const PoseGap gap = gap_between(poses_[v], told_[v]);
      report.views[v].shift_mm = gap.mm;
      report.views[v].turn_deg = gap.degrees;
      report.views[v].at_limit = at_limit(v);
    }
    return Refinement{poses_, std::move(report)};
  }

 private:
  /// How well every piece's height is known: noise, and the bend of the surface, which pieces of other views cut
  /// elsewhere. The flattest tenth of the pieces tells the noise.
  void judge(Report& report) {
    std::vector<double> sizes, bends, means;
    for (const Patch& patch : first_) sizes.push_back(patch.rms);
    const auto tenth = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 10);
    std::nth_element(sizes.begin(), tenth, sizes.end());
    const double noise2 = kFlat * *tenth * *tenth;
    for (const Patch& patch : first_) {
      const double all2 = patch.rms * patch.rms, flat2 = std::min(all2, noise2), bend2 = all2 - flat2;
      variance_.push_back(flat2 / patch.points + kBend * kBend * bend2 + kLeastSigma * kLeastSigma);
      bends.push_back(kBend * std::sqrt(bend2));
      means.push_back(std::sqrt(flat2 / patch.points));
    }
    report.bend_mm = median_of(std::move(bends));
    report.noise_mm = median_of(std::move(means));
  }

  bool at_limit(std::size_t v) const {
    const PoseGap gap = gap_between(poses_[v], told_[v]);
    return gap.mm >= accuracy_.shift_mm * (1 - 1e-9) || gap.degrees >= accuracy_.turn_deg * (1 - 1e-9);
  }

  /// Views that fit as well where the machine says as where they were moved to: the move follows noise.
  bool fits_as_told(const Report& report) const {
    for (std::size_t v = 0; v < poses_.size(); ++v)
      if (report.views[v].patches > 0 && at_limit(v)) return false;
    return report.after_mm > kGain * report.before_mm &&
           (report.datum_matches == 0 || report.datum_after_mm > kGain * report.datum_before_mm);
  }

  /// Motions of the whole about the middle of its pieces that these rows do not tell better than the machine does.
  std::array<bool, 6> left_open(std::vector<Row> rows) const {
    weigh(rows);
    Vec3 middle;
    for (const Patch& patch : patches_.list) middle += patch.centre * (1 / static_cast<double>(patches_.list.size()));
    std::array<bool, 6> open{};
    for (std::size_t k = 0; k < 6; ++k) {
      Envelope system(std::vector<std::size_t>(6, 0));
      std::vector<double> column(6, 0.0);
      const Springs springs = this->springs();
      for (std::size_t i = 0; i < 6; ++i) system.at(i, i) = springs.weight(i);
      for (const Row& row : rows) {
        // About the middle instead of the view's pivot.
        const Vec3 turn = Vec3{row.mine[0], row.mine[1], row.mine[2]} +
                          cross(poses_[row.view].translation - middle, {row.mine[3], row.mine[4], row.mine[5]});
        const Six six{turn.x, turn.y, turn.z, row.mine[3], row.mine[4], row.mine[5]};
        for (std::size_t i = 0; i < 6; ++i)
          for (std::size_t j = 0; j <= i; ++j) system.at(i, j) += row.weight * six[i] * six[j];
      }
      column[k] = 1;
      if (!system.factor()) continue;
      system.solve(column);
      open[k] = column[k] * springs.weight(k) > kOpen * kOpen;
    }
    return open;
  }

  static double spread(const std::vector<Match>& matches) {
    std::vector<double> sizes;
    for (const Match& match : matches) sizes.push_back(std::abs(match.gap));
    return spread_of(std::move(sizes));
  }
  static double spread(const std::vector<Row>& rows) {
    std::vector<double> sizes;
    for (const Row& row : rows) sizes.push_back(std::abs(row.gap));
    return spread_of(std::move(sizes));
  }

  /// Gap of every pair of views, ascending; only `before_mm` is set.
  std::vector<PairReport> pairs_of(const std::vector<Match>& matches) const {
    struct Entry {
      std::uint32_t a, b;
      double size;
    };
    std::vector<Entry> entries;
    for (const Match& match : matches) {
      const std::uint32_t v = patches_.list[match.a].view, w = patches_.list[match.b].view;
      entries.push_back({std::min(v, w), std::max(v, w), std::abs(match.gap)});
    }
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& s, const Entry& t) { return s.a != t.a ? s.a < t.a : s.b < t.b; });
    std::vector<PairReport> pairs;
    for (std::size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
      std::vector<double> sizes;
      for (; end < entries.size() && entries[end].a == entries[begin].a && entries[end].b == entries[begin].b; ++end)
        sizes.push_back(entries[end].size);
      pairs.push_back({entries[begin].a, entries[begin].b, sizes.size(), spread_of(std::move(sizes)), 0});
    }
    return pairs;
  }

  /// Pairs of the end, with what they were at the beginning (0 when they did not meet then).
  static std::vector<PairReport> joined(std::vector<PairReport> before, std::vector<PairReport> after) {
    auto less = [](const PairReport& s, const PairReport& t) { return s.a != t.a ? s.a < t.a : s.b < t.b; };
    for (PairReport& pair : after) {
      pair.after_mm = pair.before_mm;
      const auto was = std::lower_bound(before.begin(), before.end(), pair, less);
      const bool met = was != before.end() && was->a == pair.a && was->b == pair.b;
      pair.before_mm = met ? was->before_mm : 0;
    }
    return after;
  }

  /// Patches that lie on a face of a body, away from its edges.
  std::vector<Row> datum_rows() const {
    std::vector<Row> rows;
    for (const Datum& datum : datums_) {
      const Pose to_body = datum.frame.inverse();
      const double low[3] = {datum.box.low.x, datum.box.low.y, datum.box.low.z};
      const double high[3] = {datum.box.high.x, datum.box.high.y, datum.box.high.z};
      const double edge = patches_.edge_mm;
      for (std::size_t own = 0; own < patches_.list.size(); ++own) {
        const Patch& patch = patches_.list[own];
        const Vec3 p = to_body.apply(patch.centre), n = to_body.turn(patch.normal);
        const double at[3] = {p.x, p.y, p.z}, up[3] = {n.x, n.y, n.z};
        for (int k = 0; k < 3; ++k) {
          const int i = (k + 1) % 3, j = (k + 2) % 3;
          if (at[i] < low[i] + edge || at[i] > high[i] - edge || at[j] < low[j] + edge || at[j] > high[j] - edge)
            continue;
          for (const double sign : {-1.0, 1.0}) {
            const double gap = sign * (at[k] - (sign > 0 ? high[k] : low[k]));
            const double cosine = patches_.sided ? sign * up[k] : std::abs(up[k]);
            if (std::abs(gap) > edge || cosine < kFaceCosine) continue;
            const Vec3 normal = datum.frame.turn({k == 0 ? sign : 0, k == 1 ? sign : 0, k == 2 ? sign : 0});
            Row row;
            row.view = row.other = patch.view;
            row.mine = derivative(patch.centre, poses_[patch.view].translation, normal, 1);
            row.gap = gap;
            row.variance = variance_[own];
            rows.push_back(row);
          }
        }
      }
    }
    return rows;
  }

  std::vector<Row> match_rows(const std::vector<Match>& matches) const {
    std::vector<Row> rows;
    rows.reserve(matches.size());
    std::vector<std::uint32_t> met(patches_.list.size(), 1);
    for (const Match& match : matches) ++met[match.a];
    for (const Match& match : matches) {
      const Patch &a = patches_.list[match.a], &b = patches_.list[match.b];
      Row row;
      row.view = a.view;
      row.other = b.view;
      row.mine = derivative(a.centre, poses_[a.view].translation, match.normal, 1);
      row.others = derivative(b.centre, poses_[b.view].translation, match.normal, -1);
      row.gap = match.gap;
      row.variance = variance_[match.a] + variance_[match.b];
      row.share = 1.0 / met[match.a];
      // The mean normal turns with both: without this, turning everything would seem to change gaps.
      const Vec3 other = dot(a.normal, b.normal) < 0 ? -b.normal : b.normal;
      const Vec3 between = a.centre - b.centre, beside = between - match.normal * dot(between, match.normal);
      const double share = 1 / norm(a.normal + other);
      add_turn(row.mine, cross(a.normal, beside) * share);
      add_turn(row.others, cross(other, beside) * share);
      rows.push_back(row);
    }
    return rows;
  }

  static void add_turn(Six& six, Vec3 turn) {
    six[0] += turn.x;
    six[1] += turn.y;
    six[2] += turn.z;
  }

  /// By what each gap's pieces are worth; Geman and McClure's function of the gap in the spread that is left.
  static void weigh(std::vector<Row>& rows) {
    std::vector<double> sizes;
    for (const Row& row : rows) sizes.push_back(std::abs(row.gap) / std::sqrt(row.variance));
    const double scale = std::max(spread_of(std::move(sizes)), 1.0);
    for (Row& row : rows) {
      const double sigma2 = scale * scale * row.variance, fall = 1 / (1 + row.gap * row.gap / (4 * sigma2));
      row.weight = row.share * fall * fall / sigma2;
    }
  }

  /// Normal equations of all rows and springs, solved; poses_ move.
  void step(const std::vector<Match>& matches) {
    std::vector<Row> rows = match_rows(matches), fixed = datum_rows();
    weigh(rows);
    weigh(fixed);
    rows.insert(rows.end(), fixed.begin(), fixed.end());
    const std::size_t views = poses_.size();
    std::vector<std::size_t> least(views);
    for (std::size_t v = 0; v < views; ++v) least[v] = v;
    for (const Row& row : rows) {
      const std::size_t high = std::max(row.view, row.other);
      least[high] = std::min<std::size_t>(least[high], std::min(row.view, row.other));
    }
    std::vector<std::size_t> first;
    for (std::size_t v = 0; v < views; ++v) first.insert(first.end(), 6, 6 * least[v]);
    Envelope system(std::move(first));
    std::vector<double> right(6 * views, 0.0);
    for (const Row& row : rows) add(row, system, right);
    add_springs(system, right);
    if (!system.factor()) return;  // springs make it definite
    system.solve(right);
    for (std::size_t v = 0; v < views; ++v) move(v, right.data() + 6 * v);
  }

  static void add(const Row& row, Envelope& system, std::vector<double>& right) {
    auto block = [&](std::size_t v, const Six& s, std::size_t w, const Six& t) {
      for (std::size_t i = 0; i < 6; ++i)
        for (std::size_t j = 0; j < 6; ++j)
          if (6 * w + j <= 6 * v + i) system.at(6 * v + i, 6 * w + j) += row.weight * s[i] * t[j];
    };
    auto side = [&](std::size_t v, const Six& s) {
      for (std::size_t i = 0; i < 6; ++i) right[6 * v + i] -= row.weight * s[i] * row.gap;
    };
    block(row.view, row.mine, row.view, row.mine);
    side(row.view, row.mine);
    if (row.other == row.view) return;
    block(row.other, row.others, row.other, row.others);
    side(row.other, row.others);
    if (row.view > row.other)
      block(row.view, row.mine, row.other, row.others);
    else
      block(row.other, row.others, row.view, row.mine);
  }

  Springs springs() const {
    return {std::max(accuracy_.turn_deg / kRadian / kSigmas, 1e-9), std::max(accuracy_.shift_mm / kSigmas, 1e-6)};
  }

  void add_springs(Envelope& system, std::vector<double>& right) const {
    const Springs springs = this->springs();
    for (std::size_t v = 0; v < poses_.size(); ++v) {
      const Vec3 r = turn_between(told_[v], poses_[v]), t = poses_[v].translation - told_[v].translation;
      const double off[6] = {r.x, r.y, r.z, t.x, t.y, t.z};
      for (std::size_t i = 0; i < 6; ++i) {
        const double weight = springs.weight(i);
        system.at(6 * v + i, 6 * v + i) += weight;
        right[6 * v + i] -= weight * off[i];
      }
    }
  }

  /// Moves a view by the six of the solution, and back to its limit where it would leave it.
  void move(std::size_t v, const double* six) {
    const Pose was = poses_[v];
    Pose turn = turned({six[0], six[1], six[2]}).after(was);
    Vec3 shift = was.translation + Vec3{six[3], six[4], six[5]} - told_[v].translation;
    if (const double length = norm(shift); length > accuracy_.shift_mm) shift = shift * (accuracy_.shift_mm / length);
    turn.translation = told_[v].translation;
    if (const double degrees = gap_between(turn, told_[v]).degrees; degrees > accuracy_.turn_deg) {
      const Vec3 axis = turn_between(told_[v], turn);
      turn = pose_turned(axis, accuracy_.turn_deg).after(told_[v]);
    }
    turn.translation = told_[v].translation + shift;
    poses_[v] = turn;
  }

  /// Patches to where their views are now; the farthest way of one.
  double place() {
    std::vector<Pose> moves(poses_.size());
    for (std::size_t v = 0; v < poses_.size(); ++v) moves[v] = poses_[v].after(told_[v].inverse());
    double farthest = 0;
    for (std::size_t i = 0; i < first_.size(); ++i) {
      Patch& patch = patches_.list[i];
      const Vec3 to = moves[patch.view].apply(first_[i].centre);
      farthest = std::max(farthest, norm(to - patch.centre));
      patch.centre = to;
      patch.normal = moves[patch.view].turn(first_[i].normal);
    }
    return farthest;
  }

  Patches patches_;
  std::vector<Patch> first_;  // as the machine places them
  std::vector<Pose> told_, poses_;
  std::vector<double> variance_;  // of every patch's height, mm^2
  Accuracy accuracy_;
  std::span<const Datum> datums_;
};

}  // namespace

Result<Refinement> refine_poses(const PointSource& points, std::span<const Pose> poses, const Accuracy& accuracy,
                                std::span<const Datum> datums, const Params& params, const Context& context) {
  if (const auto problems = problems_of(Params::fields(), &params); !problems.empty())
    return fail(Code::BadParameter, "refine." + problems.front());
  TRY_ASSIGN(Patches patches, patches_of(points, params.patch_mm, context));
  for (const Patch& patch : patches.list)
    if (patch.view >= poses.size()) return fail(Code::Internal, "a block of a view that has no pose");
  return Refiner(std::move(patches), poses, accuracy, datums).run(params, context);
}

}  // namespace scanmill::refine
