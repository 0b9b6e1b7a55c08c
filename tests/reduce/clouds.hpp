// SPDX-License-Identifier: Apache-2.0
// Seeded clouds, and sources that cut one cloud into blocks in many ways.
#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/random.hpp"
#include "cloud/cloud.hpp"

namespace scanmill::reduce {

/// A point with its place of origin; the view decides the eye.
struct Sample {
  Vec3 position;
  SourceKey source;
};

struct TestCloud {
  std::string name;
  std::vector<Sample> samples;
  std::vector<ViewPoint> views;  // by view id
  double bin_mm = 1;
};

/// Serves blocks as they are; rows of a block must ascend.
class BlockSource final : public PointSource {
 public:
  explicit BlockSource(std::vector<PointBlock> blocks) : blocks_(std::move(blocks)) {}
  std::size_t block_count() const override { return blocks_.size(); }
  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    out = blocks_[number];
    return {};
  }
  std::uint64_t expected_points() const override { return 0; }

 private:
  std::vector<PointBlock> blocks_;
};

/// Blocks of one view each, in file order.
inline BlockSource in_order(const TestCloud& cloud, std::size_t block_size) {
  std::vector<PointBlock> blocks;
  for (const Sample& s : cloud.samples) {
    if (blocks.empty() || blocks.back().view != s.source.view || blocks.back().positions.size() == block_size) {
      blocks.emplace_back();
      blocks.back().view = s.source.view;
      blocks.back().view_point = cloud.views[index_of(s.source.view)];
    }
    blocks.back().positions.push_back(s.position);
    blocks.back().rows.push_back(s.source.row);
    ++blocks.back().points_read;
  }
  return BlockSource(std::move(blocks));
}

/// The same points dealt into blocks at random, and the blocks in random order.
inline BlockSource dealt(const TestCloud& cloud, std::uint64_t seed, std::size_t blocks_per_view) {
  Random random(seed, cloud.samples.size(), 7);
  std::vector<PointBlock> blocks(cloud.views.size() * blocks_per_view);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    blocks[b].view = ViewId{static_cast<std::uint32_t>(b / blocks_per_view)};
    blocks[b].view_point = cloud.views[b / blocks_per_view];
  }
  for (const Sample& s : cloud.samples) {
    PointBlock& block = blocks[index_of(s.source.view) * blocks_per_view + random.next() % blocks_per_view];
    block.positions.push_back(s.position);
    block.rows.push_back(s.source.row);
    ++block.points_read;
  }
  for (std::size_t b = blocks.size(); b > 1; --b) std::swap(blocks[b - 1], blocks[random.next() % b]);
  return BlockSource(std::move(blocks));
}

namespace clouds {

inline Vec3 direction(Random& random) {
  for (;;) {
    const Vec3 d{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    if (norm2(d) > 0.01 && norm2(d) <= 1) return unit(d);
  }
}

/// Points of `place(random)`, split over two views: one with an eye, one with nothing known.
template <class Place>
TestCloud of(std::string name, std::uint64_t seed, std::size_t count, double bin_mm, Place place) {
  TestCloud cloud;
  cloud.name = std::move(name);
  cloud.bin_mm = bin_mm;
  cloud.views = {ViewPoint{Vec3{20, 30, 100}, std::nullopt}, ViewPoint{}};
  Random random(seed, count, 1);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t view = i < count / 2 ? 0 : 1;
    cloud.samples.push_back({place(random), {ViewId{view}, view == 0 ? i : i - count / 2 + 5}});
  }
  return cloud;
}

inline TestCloud sphere(std::uint64_t seed) {
  return of("sphere", seed, 6000, 1.3, [](Random& r) { return direction(r) * (10 + 0.05 * r.gauss()); });
}
inline TestCloud box(std::uint64_t seed) {
  return of("box", seed, 6000, 1, [](Random& r) {
    double c[3] = {r.uniform(-6, 6), r.uniform(-6, 6), r.uniform(-6, 6)};
    c[r.next() % 3] = r.next() % 2 ? 6 : -6;  // faces lie exactly on planes between bins
    return Vec3{c[0], c[1], c[2]};
  });
}
inline TestCloud torus(std::uint64_t seed) {
  return of("torus", seed, 6000, 0.9, [](Random& r) {
    const Vec3 round = unit({r.uniform(-1, 1), r.uniform(-1, 1), 0}), tube = direction(r);
    return round * 9 + (round * tube.x + Vec3{0, 0, tube.y}) * 3;
  });
}
inline TestCloud sheet(std::uint64_t seed) {
  return of("thin wall", seed, 6000, 1, [](Random& r) {
    const double x = r.uniform(0, 20), y = r.uniform(-10, 10);
    return Vec3{x, y, 0.1 * x + (r.next() % 2 ? 0.8 : 0) + 0.1 * r.gauss()};
  });
}
inline TestCloud noise(std::uint64_t seed) {
  return of("noise", seed, 3000, 1.7, [](Random& r) {
    return Vec3{r.uniform(-9, 9), r.uniform(-9, 9), r.uniform(-9, 9)};
  });
}
/// Few places, all of them halves of a bin: corners, edges, faces and centres of bins, each hit again and again.
inline TestCloud on_bin_planes(std::uint64_t seed) {
  return of("halves of bins", seed, 4000, 0.5, [](Random& r) {
    auto half = [&] { return 0.25 * (static_cast<double>(r.next() % 25) - 12); };
    const double x = half(), y = half();
    return Vec3{x, y, 0.25 * (static_cast<double>(r.next() % 3) - 1)};
  });
}
inline TestCloud far_away(std::uint64_t seed) {
  return of("sphere, far away", seed, 4000, 1.1, [](Random& r) {
    return direction(r) * 9 + Vec3{5.4e9, -5.4e9, 5.4e9};
  });
}

inline std::vector<TestCloud> all(std::uint64_t seed) {
  return {sphere(seed),    box(seed + 1),           torus(seed + 2),   sheet(seed + 3),
          noise(seed + 4), on_bin_planes(seed + 5), far_away(seed + 6)};
}

}  // namespace clouds
}  // namespace scanmill::reduce
