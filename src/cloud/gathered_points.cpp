// SPDX-License-Identifier: Apache-2.0
#include "cloud/gathered_points.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <numeric>

#include "cloud/over_blocks.hpp"
#include "cloud/z_order.hpp"

namespace scanmill {
namespace {

constexpr std::size_t kFirstPieceBytes = 4 << 10, kPieceBytes = 64 << 10;
constexpr std::uint64_t kRowsOfPiece = 1ull << 32;
constexpr std::size_t kBlockPoints = 1 << 16;
constexpr std::size_t kSampledBlocks = 32;

struct Narrow {
  float x, y, z;
  std::uint32_t row;  // from the piece's first
};
struct Wide {
  double x, y, z;
  std::uint64_t row;
};
static_assert(sizeof(Narrow) == 16 && sizeof(Wide) == 32);

bool is_narrow(Vec3 p) {
  return static_cast<double>(static_cast<float>(p.x)) == p.x && static_cast<double>(static_cast<float>(p.y)) == p.y &&
         static_cast<double>(static_cast<float>(p.z)) == p.z;
}

/// Cubes over a box.
class CubeGrid {
 public:
  explicit CubeGrid(const Bounds& bounds) : low_(bounds.low) {
    const Vec3 size = bounds.size();
    const double longest = std::max({size.x, size.y, size.z});
    if (!(longest > 0)) return;
    per_mm_ = GatheredPoints::kCubesAcross / longest;
    for (std::size_t k = 0; k < 3; ++k) {
      const double side = k == 0 ? size.x : k == 1 ? size.y : size.z;
      across_[k] = std::min(static_cast<std::uint32_t>(side * per_mm_) + 1, GatheredPoints::kCubesAcross);
    }
  }
  std::size_t size() const { return std::size_t{across_[0]} * across_[1] * across_[2]; }
  std::uint32_t cube_of(Vec3 p) const {
    return (step(p.z - low_.z, 2) * across_[1] + step(p.y - low_.y, 1)) * across_[0] + step(p.x - low_.x, 0);
  }
  /// All cubes, neighbours near each other.
  std::vector<std::uint32_t> in_z_order() const {
    std::vector<std::uint32_t> cubes(size());
    std::iota(cubes.begin(), cubes.end(), 0u);
    auto key = [&](std::uint32_t cube) {
      return z_order(cube % across_[0], cube / across_[0] % across_[1], cube / across_[0] / across_[1]);
    };
    std::sort(cubes.begin(), cubes.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    return cubes;
  }

 private:
  std::uint32_t step(double off, std::size_t axis) const {
    const double at = off * per_mm_;
    return at > 0 ? static_cast<std::uint32_t>(std::min(at, static_cast<double>(across_[axis] - 1))) : 0;
  }
  Vec3 low_;
  double per_mm_ = 0;
  std::array<std::uint32_t, 3> across_{1, 1, 1};
};

/// The points of a block by cube.
struct Sorting {
  PointBlock block;
  std::vector<std::uint32_t> cube, count, which, touched;
};

}  // namespace

struct GatheredPoints::Gatherer {
  explicit Gatherer(GatheredPoints& gathered, const Bounds& bounds) : to(gathered), grid(bounds), locks(grid.size()) {
    to.cubes_.resize(grid.size());
  }
  Result<void> take(Sorting& work);
  void add(std::vector<Run>& cube, const PointBlock& block, std::span<const std::uint32_t> which);

  GatheredPoints& to;
  CubeGrid grid;
  std::vector<std::mutex> locks;  // of the cubes
  std::mutex lock;                // of what all have in common
  std::atomic<std::size_t> runs{0};
};

void GatheredPoints::Gatherer::add(std::vector<Run>& cube, const PointBlock& block,
                                   std::span<const std::uint32_t> which) {
  auto found = std::find_if(cube.rbegin(), cube.rend(), [&](const Run& run) { return run.view == block.view; });
  if (found == cube.rend()) {
    runs.fetch_add(1, std::memory_order_relaxed);
    cube.push_back({block.view, {}});
    found = cube.rbegin();
  }
  std::vector<Piece>& pieces = found->pieces;
  for (const std::uint32_t n : which) {
    const Vec3 p = block.positions[n];
    const std::uint64_t row = block.rows[n], first = row / kRowsOfPiece * kRowsOfPiece;
    const bool is_wide = !is_narrow(p);
    if (pieces.empty() || pieces.back().count == pieces.back().room || pieces.back().is_wide != is_wide ||
        pieces.back().first_row != first) {
      const std::size_t bytes = pieces.empty() ? kFirstPieceBytes : kPieceBytes;
      const std::size_t room = bytes / (is_wide ? sizeof(Wide) : sizeof(Narrow));
      pieces.push_back(
          {std::make_unique_for_overwrite<std::byte[]>(bytes), first, 0, static_cast<std::uint32_t>(room), is_wide});
    }
    Piece& piece = pieces.back();
    if (is_wide)
      reinterpret_cast<Wide*>(piece.bytes.get())[piece.count++] = {p.x, p.y, p.z, row - first};
    else
      reinterpret_cast<Narrow*>(piece.bytes.get())[piece.count++] = {static_cast<float>(p.x), static_cast<float>(p.y),
                                                                     static_cast<float>(p.z),
                                                                     static_cast<std::uint32_t>(row - first)};
  }
}

Result<void> GatheredPoints::Gatherer::take(Sorting& work) {
  const PointBlock& block = work.block;
  const std::size_t points = block.positions.size();
  work.cube.resize(points);
  work.which.resize(points);
  work.count.resize(grid.size(), 0);
  work.touched.clear();
  for (std::size_t n = 0; n < points; ++n) {
    const std::uint32_t cube = work.cube[n] = grid.cube_of(block.positions[n]);
    if (work.count[cube]++ == 0) work.touched.push_back(cube);
  }
  std::uint32_t end = 0;
  for (const std::uint32_t cube : work.touched) end = work.count[cube] += end;
  for (std::size_t n = points; n-- > 0;) work.which[--work.count[work.cube[n]]] = static_cast<std::uint32_t>(n);
  for (std::size_t k = 0; k < work.touched.size(); ++k) {
    const std::uint32_t cube = work.touched[k], begin = work.count[cube];
    const std::uint32_t behind =
        k + 1 < work.touched.size() ? work.count[work.touched[k + 1]] : static_cast<std::uint32_t>(points);
    const std::lock_guard<std::mutex> guard(locks[cube]);
    add(to.cubes_[cube], block, std::span(work.which).subspan(begin, behind - begin));
  }
  for (const std::uint32_t cube : work.touched) work.count[cube] = 0;
  if (runs.load(std::memory_order_relaxed) > kMostRuns)
    return fail(Code::Unsupported, "many views see many places in no order");
  const std::lock_guard<std::mutex> guard(lock);
  if (to.view_points_.size() <= index_of(block.view)) to.view_points_.resize(index_of(block.view) + 1);
  to.view_points_[index_of(block.view)] = block.view_point;
  to.dropped_.points_read += block.points_read - points;
  to.dropped_.not_finite += block.not_finite;
  to.dropped_.sensor_invalid += block.sensor_invalid;
  return {};
}

Result<double> GatheredPoints::scatter_of(const PointSource& points) {
  const std::size_t blocks = std::min(kSampledBlocks, points.block_count());
  std::vector<PointBlock> sample(blocks);
  Bounds bounds;
  for (std::size_t n = 0; n < blocks; ++n) {
    TRY(points.read_block(points.block_count() * n / blocks, sample[n]));
    for (const Vec3 p : sample[n].positions) bounds.add(p);
  }
  if (bounds.empty()) return 0.0;
  const CubeGrid grid(bounds);
  std::vector<std::size_t> seen(grid.size(), 0);  // number of the last block, from 1
  std::size_t cubes = 0, touched = 0, filled = 0;
  for (std::size_t n = 0; n < blocks; ++n) {
    filled += !sample[n].positions.empty();
    for (const Vec3 p : sample[n].positions) {
      std::size_t& last = seen[grid.cube_of(p)];
      cubes += last == 0;
      touched += last != n + 1;
      last = n + 1;
    }
  }
  return static_cast<double>(touched) / static_cast<double>(filled * cubes);
}

std::size_t GatheredPoints::bytes_of(Vec3 position) { return is_narrow(position) ? sizeof(Narrow) : sizeof(Wide); }

Result<std::unique_ptr<GatheredPoints>> GatheredPoints::gather(const PointSource& points, const Bounds& bounds,
                                                               const Context& context) {
  std::unique_ptr<GatheredPoints> gathered(new GatheredPoints);
  gathered->expected_points_ = points.expected_points();
  PointBlock& start = gathered->first_;
  std::size_t starts = 0;  // in which block
  for (; starts < points.block_count(); ++starts) {
    TRY(points.read_block(starts, start));
    if (!start.positions.empty()) break;
  }
  start.positions.resize(std::min<std::size_t>(1, start.positions.size()));
  start.rows.resize(start.positions.size());
  start.points_read = start.positions.size();
  start.not_finite = start.sensor_invalid = 0;
  Gatherer gatherer(*gathered, bounds);
  FirstBlockError first;
  std::vector<Sorting> work(static_cast<std::size_t>(context.loop.threads()));
  context.loop.run(points.block_count(), [&](std::size_t number, int worker) {
    if (context.cancel.is_set() || first.is_before(number)) return;
    Sorting& own = work[static_cast<std::size_t>(worker)];
    auto read = points.read_block(number, own.block);
    if (read.ok() && number == starts) {
      own.block.positions.erase(own.block.positions.begin());
      own.block.rows.erase(own.block.rows.begin());
      --own.block.points_read;
    }
    if (read.ok()) read = gatherer.take(own);
    if (!read.ok()) first.report(number, std::move(read).error());
  });
  TRY(first.take(context));
  for (const std::uint32_t cube : gatherer.grid.in_z_order())
    for (const Run& run : gathered->cubes_[cube]) {
      const std::span<const Piece> pieces(run.pieces);
      for (std::size_t begin = 0; begin < pieces.size();) {
        std::size_t end = begin, count = 0;
        while (end < pieces.size() && (end == begin || count + pieces[end].count <= kBlockPoints))
          count += pieces[end++].count;
        gathered->blocks_.push_back({run.view, pieces.subspan(begin, end - begin)});
        begin = end;
      }
    }
  return gathered;
}

Result<void> GatheredPoints::read_block(std::size_t number, PointBlock& out) const {
  if (number < 2) {
    out = number == 0 ? first_ : dropped_;
    return {};
  }
  const Block& block = blocks_[number - 2];
  out.clear();
  out.view = block.view;
  out.view_point = view_points_[index_of(block.view)];
  for (const Piece& piece : block.pieces) {
    if (piece.is_wide) {
      for (const Wide& p : std::span(reinterpret_cast<const Wide*>(piece.bytes.get()), piece.count)) {
        out.positions.push_back({p.x, p.y, p.z});
        out.rows.push_back(piece.first_row + p.row);
      }
    } else {
      for (const Narrow& p : std::span(reinterpret_cast<const Narrow*>(piece.bytes.get()), piece.count)) {
        out.positions.push_back({p.x, p.y, p.z});
        out.rows.push_back(piece.first_row + p.row);
      }
    }
  }
  out.points_read = out.positions.size();
  return {};
}

}  // namespace scanmill
