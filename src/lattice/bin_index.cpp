// SPDX-License-Identifier: Apache-2.0
// The wall around OpenVDB. One Int32 tree maps local bins to slots; trees of structs would cost 1 kB per bin.
#include "lattice/bin_index.hpp"

#include <openvdb/tree/LeafNode.h>
#include <openvdb/tree/RootNode.h>
#include <openvdb/tree/Tree.h>
#include <openvdb/tree/ValueAccessor.h>

#include <algorithm>
#include <limits>

// OpenVDB's library holds this tree; without the line its input and output are compiled here once more, half of the
// time this file takes.
extern template class openvdb::tree::Tree<openvdb::tree::Tree4<std::int32_t, 5, 4, 3>::Type::RootNodeType>;

namespace scanmill {
namespace {

using Tree = openvdb::tree::Tree4<std::int32_t, 5, 4, 3>::Type;
using Leaf = Tree::LeafNodeType;
using openvdb::Coord;

static_assert(Leaf::DIM == 8);

constexpr std::size_t leaf_offset(const LocalBin& bin) {
  return static_cast<std::size_t>(((bin[0] & 7) << 6) | ((bin[1] & 7) << 3) | (bin[2] & 7));
}
bool same_leaf(const LocalBin& a, const LocalBin& b) {
  return (((a[0] ^ b[0]) | (a[1] ^ b[1]) | (a[2] ^ b[2])) & ~7) == 0;
}
Coord leaf_origin(const LocalBin& bin) { return {bin[0] & ~7, bin[1] & ~7, bin[2] & ~7}; }

constexpr std::int32_t kNowhere = std::numeric_limits<std::int32_t>::min();  // local bins lie within 2^30
/// Place of a bin's leaf among those met lately.
constexpr std::size_t kMostMet = 512;
constexpr std::size_t place_among_met(const LocalBin& bin) {
  return static_cast<std::size_t>((bin[0] >> 3 & 7) << 6 | (bin[1] >> 3 & 7) << 3 | (bin[2] >> 3 & 7));
}

/// Offsets of a leaf's 512 voxels along the Z-order curve (k most significant).
const std::array<std::uint16_t, 512>& curve_in_leaf() {
  static const std::array<std::uint16_t, 512> kTable = [] {
    std::array<std::uint16_t, 512> table{};
    for (unsigned code = 0; code < 512; ++code) {
      int i = 0, j = 0, k = 0;
      for (int bit = 0; bit < 3; ++bit) {
        i |= static_cast<int>((code >> (3 * bit)) & 1) << bit;
        j |= static_cast<int>((code >> (3 * bit + 1)) & 1) << bit;
        k |= static_cast<int>((code >> (3 * bit + 2)) & 1) << bit;
      }
      table[code] = static_cast<std::uint16_t>((i << 6) | (j << 3) | k);
    }
    return table;
  }();
  return kTable;
}

}  // namespace

struct BinTree::Impl {
  Tree tree{kNoSlot};
  openvdb::tree::ValueAccessor<Tree> accessor{tree};
  std::int32_t next = 0;
  // Leaves met lately, each at the place its coordinates tell: the next line of a scan crosses the same ones.
  struct Met {
    Leaf* leaf = nullptr;
    std::int32_t* values = nullptr;
    LocalBin bin{kNowhere, kNowhere, kNowhere};
  };
  std::array<Met, kMostMet> met;

  const Met& leaf_of(const LocalBin& bin) {
    Met& found = met[place_among_met(bin)];
    if (!same_leaf(bin, found.bin)) [[unlikely]]
      meet(bin, found);
    return found;
  }
  // What happens rarely stays out of the loop over the bins, which has registers for the rest.
  [[gnu::noinline]] void meet(const LocalBin& bin, Met& found) {
    Leaf* leaf = accessor.touchLeaf(leaf_origin(bin));
    found = {leaf, leaf->buffer().data(), bin};
  }
  [[gnu::noinline]] std::int32_t take_slot(const LocalBin& bin) {
    leaf_of(bin).leaf->setValueOn(static_cast<openvdb::Index>(leaf_offset(bin)), next);
    return next++;
  }
};

BinTree::BinTree() : impl_(new Impl) {}
BinTree::~BinTree() = default;
BinTree::BinTree(BinTree&&) noexcept = default;
BinTree& BinTree::operator=(BinTree&&) noexcept = default;

void BinTree::slots_of(std::span<const LocalBin> bins, std::span<std::int32_t> slots) {
  // First where the slots stand, asking the memory for them, then what they hold: a line of scanned points crosses a
  // leaf every few bins, and leaves are rarely in the first cache.
  constexpr std::size_t kAtOnce = 64;
  std::array<std::int32_t*, kAtOnce> at;
  Impl& impl = *impl_;
  for (std::size_t first = 0; first < bins.size(); first += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, bins.size() - first);
    for (std::size_t n = 0; n < count; ++n) {
      at[n] = impl.leaf_of(bins[first + n]).values + leaf_offset(bins[first + n]);
      __builtin_prefetch(at[n]);
    }
    for (std::size_t n = 0; n < count; ++n) {
      std::int32_t slot = *at[n];
      if (slot == kNoSlot) [[unlikely]]
        slot = impl.take_slot(bins[first + n]);
      slots[first + n] = slot;
    }
  }
}

std::int32_t BinTree::size() const { return impl_->next; }
std::size_t BinTree::memory_bytes() const { return impl_->tree.memUsage(); }

std::vector<BinTree::Entry> BinTree::sorted(const BinKey& base) const {
  std::vector<const Leaf*> leaves;
  impl_->tree.getNodes(leaves);
  auto key_of = [&](const Leaf* leaf) {
    const Coord o = leaf->origin();
    return BinKey{base.i + o.x(), base.j + o.y(), base.k + o.z()};
  };
  std::sort(leaves.begin(), leaves.end(), [&](const Leaf* a, const Leaf* b) { return before(key_of(a), key_of(b)); });
  std::vector<Entry> entries;
  entries.reserve(static_cast<std::size_t>(impl_->next));
  for (const Leaf* leaf : leaves) {
    const Coord o = leaf->origin();
    const std::int32_t* values = leaf->buffer().data();
    for (const std::uint16_t offset : curve_in_leaf())
      if (values[offset] != kNoSlot)
        entries.push_back({{o.x() + (offset >> 6), o.y() + ((offset >> 3) & 7), o.z() + (offset & 7)}, values[offset]});
  }
  return entries;
}

struct BinIndex::Impl {
  Tree tree{kNoSlot};
};

BinIndex::BinIndex() : impl_(new Impl) {}
BinIndex::~BinIndex() = default;
BinIndex::BinIndex(BinIndex&&) noexcept = default;
BinIndex& BinIndex::operator=(BinIndex&&) noexcept = default;

BinIndex BinIndex::over(std::span<const LocalBin> bins) {
  BinIndex index;
  openvdb::tree::ValueAccessor<Tree> accessor(index.impl_->tree);
  for (std::size_t row = 0; row < bins.size(); ++row)
    accessor.setValueOn({bins[row][0], bins[row][1], bins[row][2]}, static_cast<std::int32_t>(row));
  return index;
}

std::size_t BinIndex::memory_bytes() const { return impl_->tree.memUsage(); }

struct BinIndex::Reader::Impl {
  explicit Impl(const Tree& tree) : accessor(tree) {}
  openvdb::tree::ValueAccessor<const Tree> accessor;
  // The 27 leaves around the last centre; null where there is none.
  std::array<const std::int32_t*, 27> around{};
  LocalBin centre{};
  bool filled = false;

  // Leaves met lately by questions about single bins, as BinTree has them; null where there is none.
  struct Met {
    const std::int32_t* values = nullptr;
    LocalBin bin{kNowhere, kNowhere, kNowhere};
  };
  std::vector<Met> met;

  const std::int32_t* place_of(const LocalBin& bin) {
    static constexpr std::int32_t kNone = kNoSlot;
    Met& found = met[place_among_met(bin)];
    if (!same_leaf(bin, found.bin)) [[unlikely]]
      meet(bin, found);
    return found.values != nullptr ? found.values + leaf_offset(bin) : &kNone;
  }
  [[gnu::noinline]] void meet(const LocalBin& bin, Met& found) { found = {leaf_at(leaf_origin(bin)), bin}; }

  const std::int32_t* leaf_at(const Coord& origin) {
    const Leaf* leaf = accessor.probeConstLeaf(origin);
    return leaf != nullptr ? leaf->buffer().data() : nullptr;
  }
  void move_to(const LocalBin& bin) {
    if (filled && same_leaf(bin, centre)) return;
    const Coord o = leaf_origin(bin);
    for (int n = 0; n < 27; ++n)
      around[static_cast<std::size_t>(n)] =
          leaf_at({o.x() + 8 * (n / 9 - 1), o.y() + 8 * (n / 3 % 3 - 1), o.z() + 8 * (n % 3 - 1)});
    centre = bin;
    filled = true;
    padded_filled = false;
  }

  // The leaf of `centre` with the two bins around it, k running fastest: windows up to radius 2 without a question.
  static constexpr int kPad = 2, kSide = 8 + 2 * kPad;
  std::array<std::int32_t, kSide * kSide * kSide> padded;
  bool padded_filled = false;

  void fill_padded() {
    if (padded_filled) return;
    std::int32_t* out = padded.data();
    for (int x = -kPad; x < 8 + kPad; ++x)
      for (int y = -kPad; y < 8 + kPad; ++y, out += kSide) {
        const std::int32_t* const* row = &around[static_cast<std::size_t>(((x >> 3) + 1) * 9 + ((y >> 3) + 1) * 3)];
        const int offset = (x & 7) << 6 | (y & 7) << 3;
        std::fill(out, out + kSide, kNoSlot);
        if (row[0] != nullptr) std::copy_n(row[0] + offset + 8 - kPad, kPad, out);
        if (row[1] != nullptr) std::copy_n(row[1] + offset, 8, out + kPad);
        if (row[2] != nullptr) std::copy_n(row[2] + offset, kPad, out + kPad + 8);
      }
    padded_filled = true;
  }
  /// put(position, row, dx, dy, dz) writes the entry at a position, which holds when the bin is occupied: no branch, as
  /// nobody can guess which bins are. Returns the number of entries.
  template <int radius, class Put>
  std::size_t visit_near(const LocalBin& bin, Put put) {
    move_to(bin);
    fill_padded();
    const int x = (bin[0] & 7) + kPad, y = (bin[1] & 7) + kPad, z = (bin[2] & 7) + kPad;
    const std::int32_t* middle = padded.data() + (x * kSide + y) * kSide + z;
    std::size_t count = 0;
    for (int dx = -radius; dx <= radius; ++dx)
      for (int dy = -radius; dy <= radius; ++dy)
        for (int dz = -radius; dz <= radius; ++dz) {
          const std::int32_t slot = middle[(dx * kSide + dy) * kSide + dz];
          put(count, slot, dx, dy, dz);
          count += slot != kNoSlot ? 1 : 0;
        }
    return count;
  }
  template <class Body>
  void visit_box(const LocalBin& low, const LocalBin& high, Body body) {
    move_to(low);
    const int x = low[0] & 7, y = low[1] & 7, z = low[2] & 7;
    for (int dx = 0; dx <= high[0] - low[0]; ++dx)
      for (int dy = 0; dy <= high[1] - low[1]; ++dy) {
        const std::int32_t* const* row =
            &around[static_cast<std::size_t>((((x + dx) >> 3) + 1) * 9 + (((y + dy) >> 3) + 1) * 3)];
        const int offset = ((x + dx) & 7) << 6 | ((y + dy) & 7) << 3;
        for (int dz = 0; dz <= high[2] - low[2]; ++dz) {
          const std::int32_t* values = row[((z + dz) >> 3) + 1];
          if (values == nullptr) continue;
          const std::int32_t slot = values[offset | ((z + dz) & 7)];
          if (slot != kNoSlot) body(slot);
        }
      }
  }
  template <class Body>
  void visit(const LocalBin& bin, int radius, Body body) {
    move_to(bin);
    const int x = bin[0] & 7, y = bin[1] & 7, z = bin[2] & 7;
    for (int dx = -radius; dx <= radius; ++dx) {
      const int lx = ((x + dx) >> 3) + 1, vx = (x + dx) & 7;
      for (int dy = -radius; dy <= radius; ++dy) {
        const int ly = ((y + dy) >> 3) + 1, vy = (y + dy) & 7;
        const std::int32_t* const* row = &around[static_cast<std::size_t>(lx * 9 + ly * 3)];
        const int offset = vx << 6 | vy << 3;
        for (int dz = -radius; dz <= radius; ++dz) {
          const std::int32_t* values = row[((z + dz) >> 3) + 1];
          if (values == nullptr) continue;
          const std::int32_t slot = values[offset | ((z + dz) & 7)];
          if (slot != kNoSlot) body(slot, dx, dy, dz);
        }
      }
    }
  }
};

BinIndex::Reader::Reader(const BinIndex& index) : impl_(new Impl(index.impl_->tree)) {}
BinIndex::Reader::~Reader() = default;
BinIndex::Reader::Reader(Reader&&) noexcept = default;

std::int32_t BinIndex::Reader::row_at(const LocalBin& bin) {
  return impl_->accessor.getValue({bin[0], bin[1], bin[2]});
}

void BinIndex::Reader::rows_of(std::span<const LocalBin> bins, std::span<std::int32_t> rows) {
  Impl& impl = *impl_;
  if (impl.met.empty()) impl.met.resize(kMostMet);
  // As in BinTree::slots_of.
  constexpr std::size_t kAtOnce = 64;
  std::array<const std::int32_t*, kAtOnce> at;
  for (std::size_t first = 0; first < bins.size(); first += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, bins.size() - first);
    for (std::size_t n = 0; n < count; ++n) {
      at[n] = impl.place_of(bins[first + n]);
      __builtin_prefetch(at[n]);
    }
    for (std::size_t n = 0; n < count; ++n) rows[first + n] = *at[n];
  }
}

namespace {

constexpr std::size_t kMostNear = 125;  // bins of a window of radius 2

/// Entries appended to `out`; those of small windows by way of a place of their own, as `near` also writes where it
/// does not count.
template <class Entry, class Near, class Far>
void append_window(int radius, std::vector<Entry>& out, Near near, Far far) {
  if (radius > 2) return far();
  Entry found[kMostNear];
  out.insert(out.end(), found, found + near(found));
}

}  // namespace

void BinIndex::Reader::window(const LocalBin& centre, int radius, std::vector<std::int32_t>& rows) {
  append_window(
      radius, rows,
      [&](std::int32_t* out) {
        const auto put = [out](std::size_t n, std::int32_t row, int, int, int) { out[n] = row; };
        return radius == 2   ? impl_->visit_near<2>(centre, put)
               : radius == 1 ? impl_->visit_near<1>(centre, put)
                             : impl_->visit_near<0>(centre, put);
      },
      [&] { impl_->visit(centre, radius, [&](std::int32_t row, int, int, int) { rows.push_back(row); }); });
}

void BinIndex::Reader::window(const LocalBin& centre, int radius, std::vector<Neighbour>& out) {
  auto entry = [](std::int32_t row, int dx, int dy, int dz) {
    return Neighbour{row, static_cast<std::int8_t>(dx), static_cast<std::int8_t>(dy), static_cast<std::int8_t>(dz)};
  };
  append_window(
      radius, out,
      [&](Neighbour* at) {
        const auto put = [&](std::size_t n, std::int32_t row, int dx, int dy, int dz) {
          at[n] = entry(row, dx, dy, dz);
        };
        return radius == 2   ? impl_->visit_near<2>(centre, put)
               : radius == 1 ? impl_->visit_near<1>(centre, put)
                             : impl_->visit_near<0>(centre, put);
      },
      [&] {
        impl_->visit(centre, radius,
                     [&](std::int32_t row, int dx, int dy, int dz) { out.push_back(entry(row, dx, dy, dz)); });
      });
}

void BinIndex::Reader::box(const LocalBin& low, const LocalBin& high, std::vector<std::int32_t>& rows) {
  impl_->visit_box(low, high, [&](std::int32_t row) { rows.push_back(row); });
}

}  // namespace scanmill
