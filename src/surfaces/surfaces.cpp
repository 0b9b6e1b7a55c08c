// SPDX-License-Identifier: Apache-2.0
#include "surfaces/surfaces.hpp"

#include <algorithm>
#include <cmath>

#include "surfaces/charts.hpp"
#include "surfaces/judge.hpp"
#include "surfaces/meeting.hpp"

namespace scanmill::surfaces {
namespace {

constexpr double kCrease = 0.96;       // cosine between a triangle and its vertex's mean normal
constexpr double kMoved = 0.3;         // of the tolerance: nearer samples keep their chart
constexpr double kSimplerBins = 0.02;  // what a polyline may leave of its border
constexpr int kSmooth = 12, kJudgements = 8, kStaleRings = 4;
constexpr double kLeastBins = 3;     // area of a chart, bin faces
constexpr std::size_t kEnough = 12;  // samples
constexpr std::uint32_t kPerTriangle = 12;

/// Samples by chart.
struct Members {
  std::vector<std::size_t> first;
  std::vector<std::uint32_t> samples;
  std::span<const std::uint32_t> of(std::size_t chart) const {
    return std::span(samples).subspan(first[chart], first[chart + 1] - first[chart]);
  }
};

Members members_of(const std::vector<std::uint32_t>& chart_of_sample, std::size_t charts) {
  Members members;
  members.first.assign(charts + 1, 0);
  for (const std::uint32_t c : chart_of_sample)
    if (c != kNoChart) ++members.first[c + 1];
  for (std::size_t c = 0; c < charts; ++c) members.first[c + 1] += members.first[c];
  members.samples.resize(members.first.back());
  std::vector<std::size_t> next(members.first.begin(), members.first.end() - 1);
  for (std::uint32_t s = 0; s < chart_of_sample.size(); ++s)
    if (chart_of_sample[s] != kNoChart) members.samples[next[chart_of_sample[s]]++] = s;
  return members;
}

class Fitter {
 public:
  Fitter(const Mesh& mesh, Samples samples, const FitTerms& terms, const Context& context)
      : mesh_(mesh),
        samples_(std::move(samples)),
        terms_(terms),
        context_(context),
        neighbours_(opposite_triangles(mesh)),
        normals_(area_normals(mesh)) {}

  Result<FittedSurfaces> run() {
    fill_empty_triangles();
    thin();
    charts_ = cut_into_charts(mesh_, neighbours_, terms_.bin_mm);
    drop_small();
    renumber_charts(normals_, charts_);
    around_ = charts_around(mesh_, charts_.chart);
    find_creases();
    sample_chart_.assign(samples_.places.size(), kNoChart);
    for (std::size_t s = 0; s < sample_chart_.size(); ++s) sample_chart_[s] = charts_.chart[samples_.triangle[s]];
    held_.assign(mesh_.positions.size(), 0);

    TRY(fit_all(true, false));
    hand_over();
    TRY(fit_all(false, false));
    hand_over();
    borders_ = borders_of(mesh_, neighbours_, charts_);
    places_ = meet(mesh_, borders_, around_, fits_, held_, kSmooth, terms_);
    TRY(fit_all(false, true));
    hand_over();
    return settle();
  }

 private:
  void fill_empty_triangles() {
    std::vector<std::uint8_t> has(mesh_.triangles.size(), 0);
    for (const std::uint32_t t : samples_.triangle) has[t] = 1;
    for (std::uint32_t t = 0; t < has.size(); ++t) {
      if (has[t]) continue;
      const Triangle& c = mesh_.triangles[t];
      samples_.places.push_back((mesh_.positions[c[0]] + mesh_.positions[c[1]] + mesh_.positions[c[2]]) * (1.0 / 3));
      samples_.triangle.push_back(t);
    }
  }

  /// Fits and first judgements use a few samples per triangle, evenly among its own; the last judgement all.
  void thin() {
    std::vector<std::uint32_t> count(mesh_.triangles.size(), 0), seen(mesh_.triangles.size(), 0);
    for (const std::uint32_t t : samples_.triangle) ++count[t];
    Samples few;
    few.left_out = samples_.left_out;
    for (std::size_t s = 0; s < samples_.places.size(); ++s) {
      const std::uint32_t t = samples_.triangle[s], step = (count[t] + kPerTriangle - 1) / kPerTriangle;
      if (seen[t]++ % step != 0) continue;
      few.places.push_back(samples_.places[s]);
      few.triangle.push_back(t);
    }
    all_ = std::move(samples_);
    samples_ = std::move(few);
  }
  void judge_all() {
    samples_ = std::move(all_);
    sample_chart_.resize(samples_.places.size());
    for (std::size_t s = 0; s < sample_chart_.size(); ++s) sample_chart_[s] = charts_.chart[samples_.triangle[s]];
    hand_over();
    distance_.clear();
  }

  /// Charts too small to be worth a surface become facets.
  void drop_small() {
    std::vector<double> area(charts_.axis.size(), 0);
    for (std::size_t t = 0; t < charts_.chart.size(); ++t)
      if (charts_.chart[t] != kNoChart) area[charts_.chart[t]] += norm(normals_[t]) / 2;
    for (std::uint32_t& c : charts_.chart)
      if (c != kNoChart && area[c] < kLeastBins * terms_.bin_mm * terms_.bin_mm) c = kNoChart;
  }

  /// Triangles at a chart's border whose corner bends sharply: their samples may belong to the other side.
  void find_creases() {
    std::vector<Vec3> mean(mesh_.positions.size());
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
      for (const std::uint32_t v : mesh_.triangles[t]) mean[v] += normals_[t];
    for (Vec3& n : mean) n = unit(n);
    std::vector<std::uint8_t> sharp(mesh_.positions.size(), 0);
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
      for (const std::uint32_t v : mesh_.triangles[t])
        if (dot(unit(normals_[t]), mean[v]) < kCrease && around_.of(v).size() > 1) sharp[v] = 1;
    crease_.assign(mesh_.triangles.size(), 0);
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
      for (const std::uint32_t v : mesh_.triangles[t]) crease_[t] |= sharp[v];
  }

  Result<void> fit_all(bool first, bool anchored) {
    const Members members = members_of(sample_chart_, charts_.axis.size());
    std::vector<std::vector<std::uint32_t>> corners(charts_.axis.size());
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
      if (charts_.chart[t] != kNoChart)
        for (const std::uint32_t v : mesh_.triangles[t]) corners[charts_.chart[t]].push_back(v);
    fits_.resize(charts_.axis.size());
    for_each_range(context_, fits_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t c = begin; c < end; ++c) fit_one(c, members.of(c), corners[c], first, anchored);
    });
    if (context_.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
    return {};
  }

  void fit_one(std::size_t c, std::span<const std::uint32_t> members, std::vector<std::uint32_t>& corners, bool first,
               bool anchored) {
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    std::vector<Vec3> outline, samples, anchors;
    for (const std::uint32_t v : corners) outline.push_back(mesh_.positions[v]);
    if (anchored)
      for (const std::uint32_t v : corners)
        if (around_.of(v).size() > 1) outline.push_back(places_[v]), anchors.push_back(places_[v]);
    for (const std::uint32_t s : members)
      if (!first || !crease_[samples_.triangle[s]]) samples.push_back(samples_.places[s]);
    if (samples.size() < kEnough)
      for (const std::uint32_t s : members)
        if (first && crease_[samples_.triangle[s]]) samples.push_back(samples_.places[s]);
    fits_[c] = fit_chart(charts_.axis[c], {outline, samples, anchors}, terms_);
  }

  /// Samples near borders go to the surface they lie on.
  void hand_over() {
    const double kept = kMoved * terms_.tolerance_mm;
    for_each_range(context_, sample_chart_.size(), 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t s = begin; s < end; ++s) {
        const std::uint32_t t = samples_.triangle[s];
        const std::uint32_t own = sample_chart_[s];
        if (own == kNoChart) continue;
        const Candidates near = candidates_of(mesh_, around_, t);
        if (near.count < 2) continue;
        double least = fits_[own].foot(samples_.places[s]).distance;
        if (least <= kept) continue;
        for (std::size_t k = 0; k < near.count; ++k) {
          if (near.charts[k] == own || !fits_[near.charts[k]].covers(samples_.places[s])) continue;
          const double distance = fits_[near.charts[k]].foot(samples_.places[s]).distance;
          if (distance < least) least = distance, sample_chart_[s] = near.charts[k];
        }
      }
    });
  }

  /// Trims, judges, and turns into facets what is not good enough, until nothing changes.
  Result<FittedSurfaces> settle() {
    bool all = false;
    for (int round = 0;; ++round) {
      if (context_.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
      around_ = charts_around(mesh_, charts_.chart);
      borders_ = borders_of(mesh_, neighbours_, charts_);
      std::vector<std::vector<TrimLoop>> loops = trim();
      const std::vector<std::uint8_t> fresh = changed_triangles();
      const Judgement found = judge_charts(
          {mesh_, charts_, around_, borders_, fits_, samples_, sample_chart_, places_, keep_, loops, terms_}, fresh,
          distance_, context_);
      std::vector<std::uint8_t> cut = found.cut;
      if (round + 1 >= kJudgements)  // what still has a fault goes whole
        for (std::size_t t = 0; t < cut.size(); ++t)
          if (charts_.chart[t] != kNoChart && found.faulty[charts_.chart[t]]) cut[t] = 1;
      if (std::find(cut.begin(), cut.end(), 1) != cut.end()) {
        take_out(cut);
      } else {
        if (all) return result(found, std::move(loops));
        all = true;
        judge_all();
        round = -1;
      }
    }
  }

  /// Loops of all charts; charts whose loops are not simple get stiffer borders, and none at last.
  std::vector<std::vector<TrimLoop>> trim() {
    for (int level = 0;; ++level) {
      places_ = meet(mesh_, borders_, around_, fits_, held_, kSmooth, terms_);
      for (Vec3& p : places_) p = rounded(p, terms_.quantum_mm);
      keep_ = needed_vertices(borders_, around_, places_, kSimplerBins * terms_.bin_mm);
      std::vector<std::vector<TrimLoop>> loops(charts_.axis.size());
      bool again = false;
      for (std::uint32_t c = 0; c < loops.size(); ++c) {
        for (const auto& walk : borders_.loops[c]) loops[c].push_back(loop_of(c, walk));
        if (sort_simple_loops(loops[c]) && within_domain(c, loops[c])) continue;
        loops[c].clear();
        for (const auto& walk : borders_.loops[c])
          for (const std::uint32_t v : walk) {
            if (held_[v] < 2) ++held_[v], again = true;
          }
      }
      if (!again || level >= 4) return loops;
    }
  }

  TrimLoop loop_of(std::uint32_t chart, const std::vector<std::uint32_t>& walk) const {
    TrimLoop loop;
    for (const std::uint32_t v : walk) {
      if (!keep_[v]) continue;
      loop.places.push_back(places_[v]);
      const Vec3 q = fits_[chart].frame.local(places_[v]);
      loop.parameters.push_back({rounded(q.x, terms_.quantum_mm), rounded(q.y, terms_.quantum_mm)});
    }
    return loop;
  }

  bool within_domain(std::uint32_t chart, const std::vector<TrimLoop>& loops) const {
    for (const TrimLoop& loop : loops)
      for (const Uv& p : loop.parameters)
        if (p.u < 0 || p.v < 0 || p.u > fits_[chart].field.u.end() || p.v > fits_[chart].field.v.end()) return false;
    return true;
  }

  /// Around all borders that are not what they were when this was last asked; at first every triangle.
  std::vector<std::uint8_t> changed_triangles() {
    const bool first = distance_.size() != samples_.places.size();
    distance_.resize(samples_.places.size());
    std::vector<std::uint8_t> vertex(mesh_.positions.size(), 0);
    for (std::size_t t = 0; t < mesh_.triangles.size() && !first; ++t)
      if (charts_.chart[t] == kNoChart && judged_chart_[t] != kNoChart)
        for (const std::uint32_t v : mesh_.triangles[t]) vertex[v] = 1;
    for (const Arc& arc : borders_.arcs) {
      if (first) break;
      if (std::any_of(arc.vertices.begin(), arc.vertices.end(), [&](std::uint32_t v) {
            return !(places_[v] == judged_places_[v]) || keep_[v] != judged_keep_[v];
          }))
        for (const std::uint32_t v : arc.vertices) vertex[v] = 1;
    }
    judged_chart_ = charts_.chart;
    judged_places_ = places_;
    judged_keep_ = keep_;
    if (first) return std::vector<std::uint8_t>(mesh_.triangles.size(), 1);
    return triangles_around(mesh_, std::move(vertex), kStaleRings);
  }

  /// Takes triangles out of their charts; what comes apart keeps the surface it had.
  void take_out(const std::vector<std::uint8_t>& cut) {
    const std::vector<std::uint32_t> before = charts_.chart;
    for (std::size_t t = 0; t < cut.size(); ++t)
      if (cut[t]) charts_.chart[t] = kNoChart;
    drop_fans(mesh_, neighbours_, charts_.chart);
    renumber_charts(normals_, charts_);
    drop_small();
    renumber_charts(normals_, charts_);
    std::vector<ChartFit> fits(charts_.axis.size());
    std::vector<std::uint32_t> now(fits_.size(), kNoChart);
    for (std::size_t t = 0; t < cut.size(); ++t)
      if (charts_.chart[t] != kNoChart) fits[charts_.chart[t]] = fits_[before[t]], now[before[t]] = charts_.chart[t];
    fits_ = std::move(fits);
    for (std::size_t s = 0; s < sample_chart_.size(); ++s) {
      const std::uint32_t own = charts_.chart[samples_.triangle[s]];
      if (own == kNoChart)
        sample_chart_[s] = kNoChart;
      else if (sample_chart_[s] == kNoChart || sample_chart_[s] == before[samples_.triangle[s]])
        sample_chart_[s] = own;
      else
        sample_chart_[s] = now[sample_chart_[s]] != kNoChart ? now[sample_chart_[s]] : own;
    }
  }

  void add_facet(std::uint32_t t, FittedSurfaces& out) const {
    const Triangle& v = mesh_.triangles[t];
    const std::array<Vec3, 3> corners{places_[v[0]], places_[v[1]], places_[v[2]]};
    if (!(norm2(cross(corners[1] - corners[0], corners[2] - corners[0])) > 0)) return;
    out.facets.push_back(t);
    out.corners.push_back(corners);
  }

  FittedSurfaces result(const Judgement& found, std::vector<std::vector<TrimLoop>> loops) const {
    FittedSurfaces out;
    out.tolerance_mm = terms_.tolerance_mm;
    out.quantum_mm = terms_.quantum_mm;
    out.samples_left_out = samples_.left_out;
    out.gap_mm = found.gap_mm;
    out.charts.resize(charts_.axis.size());
    for (std::uint32_t t = 0; t < charts_.chart.size(); ++t) {
      const double area = norm(normals_[t]) / 2;
      out.area_mm2 += area;
      if (charts_.chart[t] == kNoChart) {
        add_facet(t, out);
        continue;
      }
      FittedChart& chart = out.charts[charts_.chart[t]];
      chart.triangles.push_back(t);
      chart.area_mm2 += area;
      out.fitted_area_mm2 += area;
    }
    double sum = 0;
    for (std::size_t c = 0; c < out.charts.size(); ++c) {
      FittedChart& chart = out.charts[c];
      chart.surface = spline_of(fits_[c], terms_.quantum_mm);
      chart.loops = std::move(loops[c]);
      chart.samples = found.samples[c];
      chart.max_mm = found.max_mm[c];
      chart.rms_mm = chart.samples > 0 ? std::sqrt(found.sum2[c] / static_cast<double>(chart.samples)) : 0;
      out.samples += chart.samples;
      out.max_mm = std::max(out.max_mm, chart.max_mm);
      sum += found.sum2[c];
    }
    out.rms_mm = out.samples > 0 ? std::sqrt(sum / static_cast<double>(out.samples)) : 0;
    return out;
  }

  const Mesh& mesh_;
  Samples samples_, all_;
  FitTerms terms_;
  const Context& context_;
  std::vector<std::uint32_t> neighbours_;
  std::vector<Vec3> normals_;
  Charts charts_;
  VertexCharts around_;
  Borders borders_;
  std::vector<std::uint8_t> crease_, held_, keep_;
  std::vector<std::uint32_t> sample_chart_;
  std::vector<ChartFit> fits_;
  std::vector<Vec3> places_, judged_places_;
  std::vector<std::uint32_t> judged_chart_;
  std::vector<std::uint8_t> judged_keep_;
  std::vector<double> distance_;
};

/// The greatest power of ten up to a thousandth of the bin.
double quantum_of(double bin_mm) {
  double quantum = 1;
  for (int k = 0; k < 12 && quantum > bin_mm * 1.0001e-3; ++k) quantum = 1 / (std::floor(1 / quantum + 0.5) * 10);
  return quantum;
}

}  // namespace

Samples samples_of(const Mesh& mesh) {
  Samples samples;
  std::vector<std::uint8_t> seen(mesh.positions.size(), 0);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) {
      if (seen[v]) continue;
      seen[v] = 1;
      samples.places.push_back(mesh.positions[v]);
      samples.triangle.push_back(t);
    }
  return samples;
}

Result<FittedSurfaces> fit_surfaces(const Mesh& mesh, Samples samples, const Params& params, double bin_mm,
                                    const Context& context) {
  if (!(bin_mm > 0) || !std::isfinite(bin_mm))
    return fail(Code::BadParameter, "fitted surfaces want a bin edge above 0 mm");
  if (!(params.tolerance_bins > 0) || !std::isfinite(params.tolerance_bins))
    return fail(Code::BadParameter, "fitted surfaces want a tolerance above 0 bins");
  const FitTerms terms{bin_mm, params.tolerance_bins * bin_mm, quantum_of(bin_mm)};
  return Fitter(mesh, std::move(samples), terms, context).run();
}

}  // namespace scanmill::surfaces
