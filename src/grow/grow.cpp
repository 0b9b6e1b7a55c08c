// SPDX-License-Identifier: Apache-2.0
// The paper grows one patch after another and stops a patch at g1, g2 and g3. Here the triangles are there already
// (they all satisfy g1 and g2); g3 closes edges between triangles whose normals differ too much, and a patch is what
// its seed reaches over open edges. The outcome does not depend on the order of growth; the order survives as each
// triangle's rank.
#include "grow/grow.hpp"

#include <algorithm>
#include <numeric>

#include "base/text.hpp"
#include "grow/runs.hpp"

namespace scanmill::grow {
namespace {

constexpr double kFarthestSeed = 10;  // bins
constexpr float kLeastPeak = 0.005f;  // variation below which a place is flat
constexpr double kLeastInner = 0.2;   // share of triangles away from closed edges; a face of 3 x 3 bins has a third
constexpr int kInnerRings = 4;        // about three bins into the patch
constexpr int kTrimmedLayers = 3;     // a rounded edge is no wider
constexpr int kSettleRounds = 3;
constexpr std::uint32_t kFree = kNoTriangle;

struct Seed {
  Vec3 at;  // frame of the positions
  std::uint32_t triangle;
  SeedOrigin origin;
};

class Grower {
 public:
  Grower(const Input& input, const SeedParams& params) : in_(input), params_(params) {}

  Result<Patches> run(const Context& context) {
    if (!params_.cover && params_.points.empty())
      return fail(Code::BadParameter, "seeds.cover is false but no seeds are given; list them under seeds.points");
    measure();
    close_edges();
    find_components();
    TRY(place_given());
    if (params_.points.empty()) place_automatic();
    if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
    label_components();
    keep_connected_to_seed();
    trim_creases();
    join_cut_off();
    if (params_.cover) {
      seed_components();
      join_rest();
    }
    return finish();
  }

 private:
  std::size_t faces() const { return in_.triangles.size(); }

  /// Where the triangles of each group begin when they are listed group by group; those of group kFree are left out.
  static std::vector<std::uint32_t> firsts(const std::vector<std::uint32_t>& group, std::uint32_t groups) {
    std::vector<std::uint32_t> first(std::size_t{groups} + 1, 0);
    for (const std::uint32_t g : group)
      if (g != kFree) ++first[g + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    return first;
  }
  static std::vector<std::uint32_t> grouped(const std::vector<std::uint32_t>& group,
                                            const std::vector<std::uint32_t>& first) {
    std::vector<std::uint32_t> list(first.back()), next(first.begin(), first.end() - 1);
    for (std::uint32_t t = 0; t < group.size(); ++t)
      if (group[t] != kFree) list[next[group[t]]++] = t;
    return list;
  }

  void measure() {
    across_ = edge_neighbours(in_.positions.size(), in_.triangles);
    normal_.resize(faces());
    centroid_.resize(faces());
    for (std::size_t t = 0; t < faces(); ++t) {
      const Vec3 a = in_.positions[in_.triangles[t][0]], b = in_.positions[in_.triangles[t][1]],
                 c = in_.positions[in_.triangles[t][2]];
      normal_[t] = unit(cross(b - a, c - a));
      centroid_[t] = (a + b + c) * (1.0 / 3);
    }
  }

  /// Triangles at each vertex, ascending.
  void list_fans() {
    first_.assign(in_.positions.size() + 1, 0);
    for (const Triangle& t : in_.triangles)
      for (const std::uint32_t v : t) ++first_[v + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    fan_.resize(faces() * 3);
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t t = 0; t < faces(); ++t)
      for (const std::uint32_t v : in_.triangles[t]) fan_[next[v]++] = t;
  }

  /// The patch's normal at an edge, seen from the triangle that stands before it (the paper's local normal): the mean
  /// of the triangles that touch the edge's ends on this side of it and agree with that triangle. One triangle of a
  /// chamfer cannot turn it, so a patch does not creep round a rounded edge in small steps.
  Vec3 normal_before(std::size_t corner) const {
    const Triangle& t = in_.triangles[corner / 3];
    const std::uint32_t a = t[corner % 3], b = t[(corner % 3 + 1) % 3];
    const Vec3 middle = (in_.positions[a] + in_.positions[b]) * 0.5,
               inward = centroid_[corner / 3] - centroid_[across_[corner]];
    Vec3 sum = normal_[corner / 3];
    for (const std::uint32_t v : {a, b})
      for (std::uint32_t k = first_[v]; k < first_[v + 1]; ++k) {
        const std::uint32_t n = fan_[k];
        if (n == corner / 3 || n == across_[corner] || dot(centroid_[n] - middle, inward) <= 0) continue;
        if (normals_agree(normal_[n], normal_[corner / 3], in_.min_normal_dot)) sum += normal_[n];
      }
    return unit(sum);
  }

  /// Per vertex: the normals of its fan lie so close together that no edge at it can be refused (each pair's product is
  /// at least g3, so that of one with a mean of others is too). Decides speed, never the outcome.
  std::vector<std::uint8_t> flat_vertices() const {
    const double pair = std::max(in_.min_normal_dot, 0.0), cone = std::sqrt((1 + pair) / 2) + 1e-9;
    std::vector<std::uint8_t> flat(in_.positions.size());
    for (std::size_t v = 0; v < flat.size(); ++v) {
      Vec3 sum;
      for (std::uint32_t k = first_[v]; k < first_[v + 1]; ++k) sum += normal_[fan_[k]];
      const Vec3 axis = unit(sum);
      bool within = true;
      for (std::uint32_t k = first_[v]; k < first_[v + 1]; ++k) within = within && dot(normal_[fan_[k]], axis) >= cone;
      flat[v] = within;
    }
    return flat;
  }

  /// g3 from either side: a triangle is refused where its normal differs too much from the patch's before the edge.
  void close_edges() {
    list_fans();
    closed_.assign(faces() * 3, 0);
    std::vector<std::uint8_t> refused(faces() * 3, 0);
    const std::vector<std::uint8_t> flat = flat_vertices();
    for (std::size_t c = 0; c < closed_.size(); ++c) {
      const Triangle& t = in_.triangles[c / 3];
      if (across_[c] == kNoTriangle || (flat[t[c % 3]] && flat[t[(c % 3 + 1) % 3]])) continue;
      refused[c] = !normals_agree(normal_[across_[c]], normal_before(c), in_.min_normal_dot);
    }
    for (std::size_t c = 0; c < closed_.size(); ++c) {
      if (across_[c] == kNoTriangle) continue;
      std::size_t back = 3 * std::size_t{across_[c]};
      while (across_[back] != c / 3) ++back;
      closed_[c] = refused[c] || refused[back];
      out_.refused_normal += closed_[c] && across_[c] > c / 3;
    }
  }

  template <class Accept, class Visit>
  void flood(std::uint32_t start, Accept accept, Visit visit) {
    queue_.assign(1, start);
    visit(start);
    for (std::size_t at = 0; at < queue_.size(); ++at)
      for (std::size_t e = 0; e < 3; ++e) {
        const std::size_t c = 3 * std::size_t{queue_[at]} + e;
        const std::uint32_t next = across_[c];
        if (next == kNoTriangle || closed_[c] || !accept(next)) continue;
        visit(next);
        queue_.push_back(next);
      }
  }

  void find_components() {
    component_.assign(faces(), kFree);
    components_ = 0;
    for (std::uint32_t t = 0; t < faces(); ++t) {
      if (component_[t] != kFree) continue;
      flood(
          t, [&](std::uint32_t n) { return component_[n] == kFree; },
          [&](std::uint32_t n) { component_[n] = components_; });
      ++components_;
    }
  }

  Result<void> place_given() {
    if (params_.points.empty()) return {};
    const Runs runs(centroid_);
    for (std::size_t s = 0; s < params_.points.size(); ++s) {
      const Vec3 at = params_.points[s] - in_.offset;
      const std::uint32_t nearest = nearest_point(runs, centroid_, at);
      const double best = nearest == kNoPoint ? 1e300 : norm2(centroid_[nearest] - at);
      if (nearest == kNoPoint || std::sqrt(best) > kFarthestSeed * in_.edge_mm)
        return fail(Code::BadParameter,
                    "seed " + std::to_string(s + 1) + " lies " + number_text(std::floor(std::sqrt(best) * 100) / 100) +
                        " mm from the nearest triangle (allowed 10 bins, " + number_text(kFarthestSeed * in_.edge_mm) +
                        " mm); give it in the global frame, mm, and where it is right, see what grow.range_bins and "
                        "grow.min_angle_deg leave of the surface there");
      seeds_.push_back({at, nearest, SeedOrigin::Given});
    }
    return {};
  }

  /// Peaks of the curvature proxy, highest first, at least `spacing_bins` apart.
  void place_automatic() {
    std::vector<std::uint8_t> is_peak(in_.positions.size(), 1);
    std::vector<std::uint64_t> extent(components_, 0);
    for (const std::uint32_t c : component_) ++extent[c];
    // A peak's triangle lies in the largest component around it: at the sharpest places single triangles are folded off
    // from the surface, and a seed on one would reach nothing else.
    const auto starts_better = [&](std::uint32_t t, std::uint32_t u, std::uint32_t vertex) {
      if (u == kFree) return true;
      const std::uint64_t mine = extent[component_[t]], other = extent[component_[u]];
      if (mine != other) return mine > other;
      return norm2(centroid_[t] - in_.positions[vertex]) < norm2(centroid_[u] - in_.positions[vertex]);
    };
    std::vector<std::uint32_t> triangle_at(in_.positions.size(), kFree);
    for (std::uint32_t t = 0; t < faces(); ++t)
      for (std::size_t e = 0; e < 3; ++e) {
        const std::uint32_t a = in_.triangles[t][e], b = in_.triangles[t][(e + 1) % 3];
        if (in_.variation[a] < in_.variation[b])
          is_peak[a] = 0;
        else if (in_.variation[b] < in_.variation[a])
          is_peak[b] = 0;
        if (starts_better(t, triangle_at[a], a)) triangle_at[a] = t;
      }
    std::vector<std::uint32_t> peaks;
    for (std::uint32_t v = 0; v < in_.positions.size(); ++v)
      if (is_peak[v] && triangle_at[v] != kFree && in_.variation[v] > kLeastPeak) peaks.push_back(v);
    std::vector<Vec3> at;
    for (const std::uint32_t v : peaks) at.push_back(in_.positions[v]);
    std::vector<std::uint32_t> order(peaks.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      const float x = in_.variation[peaks[a]], y = in_.variation[peaks[b]];
      return x != y ? x > y : a < b;
    });
    const double spacing2 = params_.spacing_bins * in_.edge_mm * params_.spacing_bins * in_.edge_mm;
    for (const std::uint32_t k : spaced_apart(at, order, spacing2))
      seeds_.push_back({at[k], triangle_at[peaks[k]], SeedOrigin::Automatic});
  }

  /// Each triangle of a component with seeds goes to the nearest of that component's seeds.
  void label_components() {
    label_.assign(faces(), kFree);
    std::vector<std::vector<std::uint32_t>> of(components_);
    for (std::uint32_t s = 0; s < seeds_.size(); ++s) of[component_[seeds_[s].triangle]].push_back(s);
    const std::vector<std::uint32_t> first = firsts(component_, components_), list = grouped(component_, first);
    std::vector<Vec3> points, sites;
    for (std::uint32_t c = 0; c < components_; ++c) {
      if (of[c].empty()) continue;
      const std::span<const std::uint32_t> own(list.data() + first[c], first[c + 1] - first[c]);
      points.clear();
      for (const std::uint32_t t : own) points.push_back(centroid_[t]);
      sites.clear();
      for (const std::uint32_t s : of[c]) sites.push_back(seeds_[s].at);
      const std::vector<std::uint32_t> nearest = nearest_sites(points, sites);
      for (std::size_t k = 0; k < own.size(); ++k) label_[own[k]] = of[c][nearest[k]];
    }
  }

  /// What a label's seed does not reach inside its own label is free again. A seed whose triangle another seed took
  /// starts from its nearest triangle of its own label, if it has one.
  void keep_connected_to_seed() {
    std::vector<std::uint32_t> start(seeds_.size(), kFree);
    std::vector<double> distance(seeds_.size(), 1e300);
    for (std::uint32_t t = 0; t < faces(); ++t) {
      const std::uint32_t s = label_[t];
      if (s == kFree) continue;
      const double d = norm2(centroid_[t] - seeds_[s].at);
      if (d < distance[s]) {
        distance[s] = d;
        start[s] = t;
      }
    }
    std::vector<std::uint32_t> reached(faces(), kFree);
    for (std::uint32_t s = 0; s < seeds_.size(); ++s)
      if (start[s] != kFree)
        flood(
            start[s], [&](std::uint32_t n) { return label_[n] == s && reached[n] == kFree; },
            [&](std::uint32_t n) { reached[n] = s; });
    cut_off_.assign(faces(), 0);
    for (std::size_t t = 0; t < faces(); ++t) cut_off_[t] = label_[t] != kFree && reached[t] == kFree;
    label_.swap(reached);
  }

  /// The normal of a patch a few triangles in from t, whose own neighbours may already lie on a rounded edge: mean over
  /// the rings of the label around t, the inner rings counting more.
  Vec3 inner_normal(std::uint32_t t, std::uint32_t label) {
    stamp_.resize(faces(), 0);
    const std::uint32_t stamp = ++last_stamp_;
    stamp_[t] = stamp;
    ring_.assign(1, t);
    Vec3 sum;
    for (int depth = 1; depth <= kInnerRings; ++depth) {
      next_ring_.clear();
      for (const std::uint32_t from : ring_)
        for (std::size_t c = 3 * std::size_t{from}; c < 3 * std::size_t{from} + 3; ++c) {
          const std::uint32_t n = across_[c];
          if (n == kNoTriangle || label_[n] != label || stamp_[n] == stamp) continue;
          stamp_[n] = stamp;
          next_ring_.push_back(n);
          sum += normal_[n] * depth;
        }
      ring_.swap(next_ring_);
    }
    return norm2(sum) > 0 ? unit(sum) : normal_[t];
  }

  /// A patch gives back what has crept onto a rounded edge: triangles at closed edges that do not agree with the
  /// patch's inner normal. Layer by layer, so that a chamfer of a few triangles goes and a curved face loses at most
  /// its rim.
  void trim_creases() {
    trimmed_.assign(faces(), 0);
    if (in_.min_normal_dot <= 0) return;
    for (int layer = 0; layer < kTrimmedLayers; ++layer) {
      std::vector<std::uint32_t> gone;
      for (std::uint32_t t = 0; t < faces(); ++t) {
        const std::uint32_t s = label_[t];
        if (s == kFree || seeds_[s].triangle == t) continue;
        bool at_crease = false;
        for (std::size_t c = 3 * std::size_t{t}; c < 3 * std::size_t{t} + 3; ++c)
          at_crease = at_crease || closed_[c] || (across_[c] != kNoTriangle && trimmed_[across_[c]]);
        if (at_crease && !normals_agree(normal_[t], inner_normal(t, s), in_.min_normal_dot)) gone.push_back(t);
      }
      if (gone.empty()) return;
      for (const std::uint32_t t : gone) {
        label_[t] = kFree;
        trimmed_[t] = cut_off_[t] = 1;
      }
    }
  }

  /// Triangles that joined over closed edges move to the neighbouring patch whose inner normal they agree with more, so
  /// that borders run along the edge.
  void settle_borders(const std::vector<std::uint8_t>& joined) {
    for (int round = 0; round < kSettleRounds; ++round) {
      std::vector<std::pair<std::uint32_t, std::uint32_t>> moves;
      for (std::uint32_t t = 0; t < faces(); ++t) {
        if (!joined[t]) continue;
        std::uint32_t best = label_[t];
        bool at_border = false;
        for (std::size_t c = 3 * std::size_t{t}; c < 3 * std::size_t{t} + 3; ++c)
          at_border = at_border || (across_[c] != kNoTriangle && label_[across_[c]] != best);
        if (!at_border) continue;
        double agreement = dot(normal_[t], inner_normal(t, best));
        for (std::size_t c = 3 * std::size_t{t}; c < 3 * std::size_t{t} + 3; ++c) {
          const std::uint32_t other = across_[c] == kNoTriangle ? kFree : label_[across_[c]];
          if (other == kFree || other == best) continue;
          const double d = dot(normal_[t], inner_normal(t, other));
          if (d <= agreement) continue;
          agreement = d;
          best = other;
        }
        if (best != label_[t]) moves.push_back({t, best});
      }
      if (moves.empty()) return;
      for (const auto& [t, label] : moves) label_[t] = label;
    }
  }

  /// Components without a seed get one, unless they are small or crease strips (nearly every triangle touches a closed
  /// edge).
  void seed_components() {
    std::vector<std::uint8_t> met(faces(), 0);
    for (std::uint32_t t = 0; t < faces(); ++t) {
      if (label_[t] != kFree || met[t] || cut_off_[t]) continue;
      flood(
          t, [&](std::uint32_t n) { return !met[n]; }, [&](std::uint32_t n) { met[n] = 1; });
      std::size_t inner = 0;
      std::uint32_t peak = t;
      for (const std::uint32_t n : queue_) {
        inner += !(closed_[3 * std::size_t{n}] || closed_[3 * std::size_t{n} + 1] || closed_[3 * std::size_t{n} + 2]);
        if (in_.variation[in_.triangles[n][0]] > in_.variation[in_.triangles[peak][0]]) peak = n;
      }
      const bool strip = static_cast<double>(inner) < kLeastInner * static_cast<double>(queue_.size());
      if (strip || queue_.size() < static_cast<std::size_t>(in_.min_patch_triangles)) continue;
      const auto s = static_cast<std::uint32_t>(seeds_.size());
      seeds_.push_back({centroid_[peak], peak, SeedOrigin::Component});
      for (const std::uint32_t n : queue_) label_[n] = s;
    }
  }

  /// Free triangles join in rounds, each over its flattest edge to a triangle that was labelled before the round, among
  /// the edges that `may_cross` allows.
  template <class MayCross>
  void join_over(const std::vector<std::uint32_t>& starts, MayCross may_cross) {
    std::vector<std::uint32_t> border, next, chosen;
    auto list_neighbours = [&](std::uint32_t t, std::vector<std::uint32_t>& out) {
      for (std::size_t c = 3 * std::size_t{t}; c < 3 * std::size_t{t} + 3; ++c) {
        const std::uint32_t n = across_[c];
        if (n != kNoTriangle && label_[n] == kFree && may_cross(c)) out.push_back(n);
      }
    };
    auto flattest_label = [&](std::uint32_t t) {
      double flattest = -2;
      std::uint32_t label = kFree;
      for (std::size_t c = 3 * std::size_t{t}; c < 3 * std::size_t{t} + 3; ++c) {
        const std::uint32_t n = across_[c];
        if (n == kNoTriangle || label_[n] == kFree || !may_cross(c)) continue;
        const double d = dot(normal_[t], normal_[n]);
        if (d > flattest || (d == flattest && label_[n] < label)) {
          flattest = d;
          label = label_[n];
        }
      }
      return label;
    };
    for (const std::uint32_t t : starts) list_neighbours(t, border);
    while (!border.empty()) {
      std::sort(border.begin(), border.end());
      border.erase(std::unique(border.begin(), border.end()), border.end());
      chosen.clear();
      for (const std::uint32_t t : border) chosen.push_back(flattest_label(t));
      for (std::size_t k = 0; k < border.size(); ++k) label_[border[k]] = chosen[k];
      next.clear();
      for (const std::uint32_t t : border) list_neighbours(t, next);
      border.swap(next);
    }
  }

  std::vector<std::uint32_t> labelled() const {
    std::vector<std::uint32_t> list;
    for (std::uint32_t t = 0; t < faces(); ++t)
      if (label_[t] != kFree) list.push_back(t);
    return list;
  }

  /// What is cut off from its own seed is still reached from its component's other seeds.
  void join_cut_off() {
    join_over(labelled(), [&](std::size_t c) { return !closed_[c] && !trimmed_[c / 3] && !trimmed_[across_[c]]; });
  }

  /// The rest joins over closed edges too; islands become patches of their own.
  void join_rest() {
    std::vector<std::uint32_t> starts = labelled();
    std::vector<std::uint8_t> joined(faces(), 1);
    for (const std::uint32_t t : starts) joined[t] = 0;
    for (std::uint32_t island = 0;;) {
      join_over(starts, [](std::size_t) { return true; });
      while (island < faces() && label_[island] != kFree) ++island;
      if (island == faces()) break;
      label_[island] = static_cast<std::uint32_t>(seeds_.size());
      seeds_.push_back({centroid_[island], island, SeedOrigin::Component});
      joined[island] = 0;
      starts.assign(1, island);
    }
    if (in_.min_normal_dot > 0) settle_borders(joined);
  }

  Patches finish() {
    // Seeds that own no triangle (a better one stood nearer everywhere) do not become patches.
    std::vector<std::uint64_t> count(seeds_.size(), 0);
    for (const std::uint32_t s : label_)
      if (s != kFree) ++count[s];
    std::vector<std::uint32_t> number(seeds_.size(), kFree);
    for (std::size_t s = 0; s < seeds_.size(); ++s) {
      if (count[s] == 0) continue;
      number[s] = static_cast<std::uint32_t>(out_.patches.size());
      out_.patches.push_back({seeds_[s].at + in_.offset, seeds_[s].origin, count[s], 0, 0});
    }
    rank();
    out_.patch.resize(faces());
    for (std::size_t t = 0; t < faces(); ++t) out_.patch[t] = label_[t] == kFree ? kNoTriangle : number[label_[t]];
    for (std::size_t c = 0; c < faces() * 3; ++c) {
      const std::uint32_t mine = out_.patch[c / 3];
      if (mine == kNoTriangle) continue;
      const Triangle& t = in_.triangles[c / 3];
      const Vec3 a = in_.positions[t[c % 3]], b = in_.positions[t[(c % 3 + 1) % 3]];
      if (across_[c] == kNoTriangle || out_.patch[across_[c]] != mine) out_.patches[mine].border_mm += norm(b - a);
      if (c % 3 == 0) out_.patches[mine].area_mm2 += norm(cross(b - a, in_.positions[t[2]] - a)) / 2;
    }
    return std::move(out_);
  }

  void rank() {
    struct Place {
      double distance;
      std::uint32_t triangle;
    };
    const std::vector<std::uint32_t> first = firsts(label_, static_cast<std::uint32_t>(seeds_.size())),
                                     list = grouped(label_, first);
    out_.rank.assign(faces(), 0);
    std::vector<Place> places;
    for (std::size_t s = 0; s < seeds_.size(); ++s) {
      places.clear();
      for (std::uint32_t k = first[s]; k < first[s + 1]; ++k)
        places.push_back({norm2(centroid_[list[k]] - seeds_[s].at), list[k]});
      std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
        return a.distance != b.distance ? a.distance < b.distance : a.triangle < b.triangle;
      });
      for (std::uint32_t k = 0; k < places.size(); ++k) out_.rank[places[k].triangle] = k;
    }
  }

  const Input& in_;
  const SeedParams& params_;
  Patches out_;
  std::vector<std::uint32_t> across_, component_, label_, queue_;
  std::vector<std::uint32_t> first_, fan_, stamp_, ring_, next_ring_;
  std::uint32_t last_stamp_ = 0;
  std::vector<std::uint8_t> trimmed_;
  std::vector<Vec3> normal_, centroid_;
  std::vector<std::uint8_t> closed_, cut_off_;
  std::vector<Seed> seeds_;
  std::uint32_t components_ = 0;
};

}  // namespace

const char* name_of(SeedOrigin origin) {
  switch (origin) {
    case SeedOrigin::Given:
      return "given";
    case SeedOrigin::Automatic:
      return "automatic";
    case SeedOrigin::Component:
      return "component";
  }
  return "";
}

Result<Patches> grow_patches(const Input& input, const SeedParams& seeds, const Context& context) {
  return Grower(input, seeds).run(context);
}

}  // namespace scanmill::grow
