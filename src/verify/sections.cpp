// SPDX-License-Identifier: Apache-2.0
#include "verify/sections.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/digest.hpp"
#include "cloud/over_blocks.hpp"
#include "verify/sides.hpp"
#include "verify/triangle_index.hpp"

namespace scanmill::verify {
namespace {

__extension__ using UInt128 = unsigned __int128;

constexpr double kUnitsPerBin = 1 << 20;
constexpr double kDeviationShare = 0.15;  // of the section's size that the greatest deviation is drawn as

std::uint64_t hash_of(SourceKey source) { return mix64(source.row ^ mix64(index_of(source.view) + 0x5ec7)); }

struct Candidate {
  std::uint64_t hash = 0;
  SectionPoint point;
  bool operator<(const Candidate& other) const {
    return hash != other.hash ? hash < other.hash : point.source < other.point.source;
  }
};

/// The greater deviation; of equal ones the lesser source.
bool is_worse(const SectionPoint& a, const SectionPoint& b) {
  const double x = std::abs(a.signed_mm), y = std::abs(b.signed_mm);
  return x != y ? x > y : a.source < b.source;
}

/// What one worker has seen of one section.
struct Seen {
  std::uint64_t points = 0, at_open_border = 0;
  UInt128 squares = 0;  // of whole 2^-20 bins
  std::optional<SectionPoint> worst;
  std::vector<Candidate> sample;  // a heap, the greatest hash first

  void add(const SectionPoint& point, bool open_border, double units_per_mm) {
    ++points;
    keep({hash_of(point.source), point});
    if (open_border) {
      ++at_open_border;
      return;
    }
    const auto units = static_cast<std::uint64_t>(std::min(std::abs(point.signed_mm) * units_per_mm + 0.5, 0x1p62));
    squares += static_cast<UInt128>(units) * units;
    if (!worst || is_worse(point, *worst)) worst = point;
  }
  void keep(Candidate candidate) {
    if (sample.size() == kSectionPoints) {
      if (!(candidate < sample.front())) return;
      std::pop_heap(sample.begin(), sample.end());
      sample.pop_back();
    }
    sample.push_back(std::move(candidate));
    std::push_heap(sample.begin(), sample.end());
  }
  void add(const Seen& other) {
    points += other.points;
    at_open_border += other.at_open_border;
    squares += other.squares;
    if (other.worst && (!worst || is_worse(*other.worst, *worst))) worst = other.worst;
    for (const Candidate& candidate : other.sample) keep(candidate);
  }
};

/// Nearest place of the section's lines.
void find_foot(const Section& section, SectionPoint& point) {
  double least = 0;
  bool found = false;
  // Beyond the end of an open line nothing tells which way the deviation points: such a point has no foot.
  auto measure = [&](Uv a, Uv b, bool begins, bool ends) {
    const double du = b.u - a.u, dv = b.v - a.v, length2 = du * du + dv * dv;
    if (!(length2 > 0)) return;
    const double along = std::clamp(((point.at.u - a.u) * du + (point.at.v - a.v) * dv) / length2, 0.0, 1.0);
    const Uv foot{a.u + along * du, a.v + along * dv};
    const double u = point.at.u - foot.u, v = point.at.v - foot.v, distance2 = u * u + v * v;
    if (found && !(distance2 < least)) return;
    found = true;
    const double length = std::sqrt(length2);
    least = distance2;
    point.foot = foot;
    point.outward = {dv / length, -du / length};  // right of the line
    point.has_foot = !(begins && along == 0) && !(ends && along == 1);
  };
  for (const SectionLine& line : section.lines) {
    for (std::size_t n = 0; n + 1 < line.points.size(); ++n)
      measure(line.points[n], line.points[n + 1], !line.closed && n == 0, !line.closed && n + 2 == line.points.size());
    if (line.closed && line.points.size() > 1) measure(line.points.back(), line.points.front(), false, false);
  }
  // Where the surface lies flat in the slab, its line says nothing about the points on it.
  if (std::sqrt(least) > std::abs(point.signed_mm) + section.frame.slab_mm / 2) point.has_foot = false;
}

/// The greatest of 1, 2, 5 times a power of ten at which the greatest deviation takes its share of the section.
double chosen_magnify(const Section& section) {
  Uv low{1e300, 1e300}, high{-1e300, -1e300};
  for (const SectionLine& line : section.lines)
    for (const Uv& p : line.points) {
      low = {std::min(low.u, p.u), std::min(low.v, p.v)};
      high = {std::max(high.u, p.u), std::max(high.v, p.v)};
    }
  const double size = std::max(high.u - low.u, high.v - low.v);
  if (!(section.max_mm > 0) || !(size > 0)) return 1;
  const double wanted = kDeviationShare * size / section.max_mm;
  double magnify = 1;
  for (double power = 1; power <= 1e5; power *= 10)
    for (const double digit : {1.0, 2.0, 5.0})
      if (digit * power <= wanted) magnify = digit * power;
  return magnify;
}

void finish(Section& section, const Seen& seen, double units_per_mm, double magnify) {
  for (const SectionLine& line : section.lines) {
    auto add = [&](Uv a, Uv b) {
      section.length_mm += std::sqrt((b.u - a.u) * (b.u - a.u) + (b.v - a.v) * (b.v - a.v));
    };
    for (std::size_t n = 0; n + 1 < line.points.size(); ++n) add(line.points[n], line.points[n + 1]);
    if (line.closed && line.points.size() > 1) add(line.points.back(), line.points.front());
  }
  section.points_in_slab = seen.points;
  section.points_at_open_border = seen.at_open_border;
  section.worst = seen.worst;
  for (const Candidate& candidate : seen.sample) section.points.push_back(candidate.point);
  std::sort(section.points.begin(), section.points.end(),
            [](const SectionPoint& a, const SectionPoint& b) { return a.source < b.source; });
  for (SectionPoint& point : section.points) find_foot(section, point);
  if (section.worst) {
    find_foot(section, *section.worst);
    section.max_mm = std::abs(section.worst->signed_mm);
    section.rms_mm =
        std::sqrt(static_cast<double>(seen.squares) / static_cast<double>(seen.points - seen.at_open_border)) /
        units_per_mm;
  }
  section.magnify = magnify > 0 ? magnify : chosen_magnify(section);
}

class Worker {
 public:
  Worker(const TriangleIndex& index, const Sides& sides, std::span<const SectionFrame> frames, double units_per_mm)
      : seen(frames.size()),
        sides_(sides),
        frames_(frames),
        offset_(index.mesh().offset),
        search_(index),
        units_per_mm_(units_per_mm) {}

  void take(const PointBlock& block) {
    for (std::size_t n = 0; n < block.positions.size(); ++n) {
      SectionPoint point;
      bool measured = false, open_border = false;
      for (std::size_t s = 0; s < frames_.size(); ++s) {
        const Vec3 p = block.positions[n];
        if (!(std::abs(dot(p - frames_[s].origin, frames_[s].normal)) <= frames_[s].slab_mm / 2)) continue;
        if (!measured) {
          const Hit hit = search_.nearest(p - offset_);
          const double distance = std::sqrt(hit.distance2);
          point.place = p;
          point.source = {block.view, block.rows[n]};
          open_border = sides_.at_open_border(hit);
          point.signed_mm = sides_.is_above(hit, p - offset_) ? distance : -distance;
          measured = true;
        }
        point.at = frames_[s].at(p);
        seen[s].add(point, open_border, units_per_mm_);
      }
    }
  }

  std::vector<Seen> seen;

 private:
  const Sides& sides_;
  std::span<const SectionFrame> frames_;
  Vec3 offset_;
  TriangleIndex::Search search_;
  double units_per_mm_;
};

}  // namespace

Result<std::vector<Section>> sections_of(const Mesh& mesh, const PointSource& points,
                                         std::span<const SectionFrame> frames, std::span<const double> magnify,
                                         double bin_mm, const Context& context) {
  std::vector<Section> sections;
  if (frames.empty()) return sections;
  const TriangleIndex index(mesh);
  if (index.empty())
    return fail(Code::BadInput, "no triangle of the mesh has an area; nothing can be measured against it");
  const Sides sides(mesh);
  const double units_per_mm = kUnitsPerBin / bin_mm;
  std::vector<std::unique_ptr<Worker>> workers(static_cast<std::size_t>(context.loop.threads()));
  TRY(over_blocks(points, context, [&](int worker, const PointBlock& block) -> Result<void> {
    auto& mine = workers[static_cast<std::size_t>(worker)];
    if (!mine) mine = std::make_unique<Worker>(index, sides, frames, units_per_mm);
    mine->take(block);
    return {};
  }));
  for (std::size_t s = 0; s < frames.size(); ++s) {
    Seen all;
    for (const auto& worker : workers)
      if (worker) all.add(worker->seen[s]);
    Section& section = sections.emplace_back();
    section.frame = frames[s];
    section.lines = cut(mesh, frames[s]);
    finish(section, all, units_per_mm, magnify[s]);
  }
  return sections;
}

}  // namespace scanmill::verify
