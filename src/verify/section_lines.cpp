// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "verify/sections.hpp"

namespace scanmill::verify {
namespace {

using EdgeKey = std::uint64_t;

EdgeKey edge_key(std::uint32_t a, std::uint32_t b) { return (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b); }

/// What a triangle has in common with the plane, from the edge that leads down to the one that leads up: so the
/// material lies on the left.
struct Piece {
  EdgeKey from, to;
};

Uv crossing(const Mesh& mesh, const std::vector<double>& height, const SectionFrame& frame, EdgeKey edge) {
  const auto low = static_cast<std::uint32_t>(edge >> 32), high = static_cast<std::uint32_t>(edge);
  const double share = height[low] / (height[low] - height[high]);
  return frame.at(mesh.positions[low] + mesh.offset + (mesh.positions[high] - mesh.positions[low]) * share);
}

std::vector<Piece> pieces_of(const Mesh& mesh, const std::vector<double>& height) {
  std::vector<Piece> pieces;
  for (const Triangle& t : mesh.triangles) {
    Piece piece{};
    int found = 0;
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t a = t[e], b = t[(e + 1) % 3];
      if ((height[a] >= 0) == (height[b] >= 0)) continue;
      (height[a] >= 0 ? piece.from : piece.to) = edge_key(a, b);
      ++found;
    }
    if (found == 2) pieces.push_back(piece);
  }
  std::sort(pieces.begin(), pieces.end(),
            [](const Piece& a, const Piece& b) { return a.from != b.from ? a.from < b.from : a.to < b.to; });
  return pieces;
}

/// Follows pieces that begin where another ends.
class Chains {
 public:
  explicit Chains(const std::vector<Piece>& pieces) : pieces_(pieces), used_(pieces.size(), 0) {}
  /// The edges of the chain that holds `first`, from its beginning.
  std::vector<EdgeKey> next_from(std::size_t first, bool& closed) {
    std::vector<EdgeKey> edges{pieces_[first].from};
    for (std::size_t at = first; at < pieces_.size(); at = following(edges.back())) {
      used_[at] = 1;
      edges.push_back(pieces_[at].to);
    }
    closed = edges.size() > 2 && edges.back() == edges.front();
    if (closed) edges.pop_back();
    return edges;
  }
  bool is_used(std::size_t piece) const { return used_[piece] != 0; }

 private:
  std::size_t following(EdgeKey edge) const {
    auto at = std::lower_bound(pieces_.begin(), pieces_.end(), edge,
                               [](const Piece& piece, EdgeKey key) { return piece.from < key; });
    for (; at != pieces_.end() && at->from == edge; ++at)
      if (!used_[static_cast<std::size_t>(at - pieces_.begin())]) return static_cast<std::size_t>(at - pieces_.begin());
    return pieces_.size();
  }
  const std::vector<Piece>& pieces_;
  std::vector<std::uint8_t> used_;
};

/// Pieces that no other leads to come first: open lines begin at their ends.
std::vector<std::size_t> beginnings(const std::vector<Piece>& pieces) {
  std::vector<EdgeKey> ends;
  for (const Piece& piece : pieces) ends.push_back(piece.to);
  std::sort(ends.begin(), ends.end());
  std::vector<std::size_t> order;
  for (const bool open : {true, false})
    for (std::size_t n = 0; n < pieces.size(); ++n)
      if (std::binary_search(ends.begin(), ends.end(), pieces[n].from) != open) order.push_back(n);
  return order;
}

std::string axis_text(Vec3 axis, double at) {
  const char* name = axis == Vec3{1, 0, 0} ? "x" : axis == Vec3{0, 1, 0} ? "y" : axis == Vec3{0, 0, 1} ? "z" : nullptr;
  const double shown = std::floor(at * 1000 + 0.5) / 1000;
  auto rounded = [](double v) { return number_text(std::floor(v * 1000 + 0.5) / 1000); };
  return (name ? std::string(name) : "(" + rounded(axis.x) + " " + rounded(axis.y) + " " + rounded(axis.z) + ")") +
         " = " + number_text(shown == 0 ? 0 : shown) + " mm";
}

SectionFrame frame_at(Vec3 normal, double at, Vec3 near) {
  SectionFrame frame;
  frame.normal = normal;
  frame.origin = near + normal * (at - dot(near, normal));
  const Vec3 upward = std::abs(normal.z) < 0.999 ? Vec3{0, 0, 1} : Vec3{0, 1, 0};
  frame.up = unit(upward - normal * dot(upward, normal));
  frame.right = cross(frame.up, normal);
  frame.name = axis_text(normal, at);
  return frame;
}

}  // namespace

std::vector<SectionLine> cut(const Mesh& mesh, const SectionFrame& frame) {
  std::vector<double> height;
  height.reserve(mesh.positions.size());
  for (const Vec3& p : mesh.positions) height.push_back(dot(p + mesh.offset - frame.origin, frame.normal));
  const std::vector<Piece> pieces = pieces_of(mesh, height);
  Chains chains(pieces);
  std::vector<SectionLine> lines;
  for (const std::size_t first : beginnings(pieces)) {
    if (chains.is_used(first)) continue;
    SectionLine& line = lines.emplace_back();
    for (const EdgeKey edge : chains.next_from(first, line.closed))
      line.points.push_back(crossing(mesh, height, frame, edge));
  }
  return lines;
}

Result<std::vector<SectionFrame>> section_frames(const Mesh& mesh, std::span<const SectionRule> rules, double bin_mm,
                                                 const SectionFeatures& features, std::vector<double>& magnify) {
  std::vector<SectionFrame> frames;
  Bounds bounds;
  for (const Vec3& p : mesh.positions) bounds.add(p + mesh.offset);
  const Vec3 middle = bounds.empty() ? Vec3{} : (bounds.low + bounds.high) * 0.5;
  for (const SectionRule& rule : rules) {
    if (!(norm2(rule.axis) > 0))
      return fail(Code::BadParameter, "found a zero axis; allowed a direction", "verify.sections");
    const Vec3 normal = rule.axis * (1 / norm(rule.axis));
    std::vector<double> places;
    switch (rule.where) {
      case SectionRule::Where::At:
        places.push_back(rule.at_mm);
        break;
      case SectionRule::Where::Point:
        places.push_back(dot(rule.point, normal));
        break;
      case SectionRule::Where::Worst:
        if (features.worst) places.push_back(dot(*features.worst, normal));
        break;
      case SectionRule::Where::Loop:
        if (features.longest_loop) places.push_back(dot(*features.longest_loop, normal));
        break;
      case SectionRule::Where::Count: {
        double low = 0, high = 0;
        for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
          const double at = dot(mesh.positions[v] + mesh.offset, normal);
          low = v == 0 ? at : std::min(low, at);
          high = v == 0 ? at : std::max(high, at);
        }
        for (std::int64_t n = 1; n <= rule.count; ++n)
          places.push_back(low + (high - low) * static_cast<double>(n) / static_cast<double>(rule.count + 1));
      }
    }
    for (const double at : places) {
      SectionFrame frame = frame_at(normal, at, middle);
      if (!rule.name.empty()) frame.name = rule.name + (places.size() > 1 ? ", " : ": ") + frame.name;
      frame.slab_mm = rule.slab_mm.value_or(bin_mm);
      frames.push_back(std::move(frame));
      magnify.push_back(rule.magnify.value_or(0));
    }
    if (frames.size() > kMostSections)
      return fail(Code::BadParameter, "found more than " + std::to_string(kMostSections) + " planes; ask for fewer",
                  "verify.sections");
  }
  return frames;
}

}  // namespace scanmill::verify
