// SPDX-License-Identifier: Apache-2.0
#include "store/bin_grids.hpp"

#include <openvdb/Grid.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include <exception>
#include <limits>
#include <sstream>

#include "base/digest.hpp"
#include "base/text.hpp"

// Both are in OpenVDB's library; without the lines they are compiled here once more, half of the time this file takes.
extern template class openvdb::tree::Tree<openvdb::Int32Tree::RootNodeType>;
extern template class openvdb::Grid<openvdb::Int32Tree>;

namespace scanmill::store {
namespace {

// magic number, file version, library version (two), flag for offsets; then the identifier as text.
constexpr std::size_t kIdentifierAt = 21, kIdentifierBytes = 36;
constexpr std::int32_t kBackground = -1;

bool fits(const BinKey& key) {
  constexpr std::int64_t kLow = std::numeric_limits<std::int32_t>::min() / 2, kHigh = -kLow;
  for (const std::int64_t n : {key.i, key.j, key.k})
    if (n < kLow || n > kHigh) return false;
  return true;
}

openvdb::Int32Grid::Ptr grid_of(const Lattice& lattice, std::span<const BinKey> bins, const BinColumn& column) {
  auto grid = openvdb::Int32Grid::create(kBackground);
  auto writer = grid->getAccessor();
  for (std::size_t n = 0; n < bins.size(); ++n)
    writer.setValue({static_cast<int>(bins[n].i), static_cast<int>(bins[n].j), static_cast<int>(bins[n].k)},
                    column.values[n]);
  const Vec3 centre = centre_of(lattice, {0, 0, 0});
  auto transform = openvdb::math::Transform::createLinearTransform(lattice.edge_mm);
  transform->postTranslate({centre.x, centre.y, centre.z});
  grid->setTransform(transform);
  grid->setName(column.name);
  grid->setGridClass(openvdb::GRID_UNKNOWN);
  grid->setCreator("scanmill");
  grid->insertMeta("scanmill:meaning", openvdb::StringMetadata(column.help));
  grid->insertMeta("scanmill:units", openvdb::StringMetadata("mm"));
  grid->insertMeta("scanmill:bin_mm", openvdb::DoubleMetadata(lattice.edge_mm));
  grid->insertMeta("scanmill:origin_mm",
                   openvdb::Vec3DMetadata({lattice.origin.x, lattice.origin.y, lattice.origin.z}));
  return grid;
}

std::string bytes_of(const Lattice& lattice, std::span<const BinKey> bins, std::span<const BinColumn> columns) {
  openvdb::initialize();
  openvdb::GridPtrVec grids;
  for (const BinColumn& column : columns) grids.push_back(grid_of(lattice, bins, column));
  std::ostringstream out(std::ios::binary);
  openvdb::io::Stream archive(out);
  archive.setCompression(openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK);
  archive.write(grids);
  return out.str();
}

/// The first 32 digits of the content's digest in groups of 8, 4, 4, 4, 12.
std::string identifier_of(std::string_view content) {
  std::string digits = sha256_hex(content).substr(0, 32);
  for (const std::size_t at : {8, 13, 18, 23}) digits.insert(at, "-");
  return digits;
}

}  // namespace

Result<void> write_bin_grids(const Lattice& lattice, std::span<const BinKey> bins, std::span<const BinColumn> columns,
                             ByteSink& sink) {
  for (const BinKey& key : bins)
    if (!fits(key))
      return fail(Code::Unsupported,
                  "bin (" + std::to_string(key.i) + ", " + std::to_string(key.j) + ", " + std::to_string(key.k) +
                      ") lies farther from the lattice's origin than OpenVDB numbers voxels; choose lattice.origin: "
                      "bounds or a larger bin",
                  sink.name());
  for (const BinColumn& column : columns)
    if (column.values.size() != bins.size())
      return fail(Code::Internal,
                  grouped(bins.size()) + " bins have " + grouped(column.values.size()) + " values of " + column.name,
                  sink.name());
  try {
    std::string bytes = bytes_of(lattice, bins, columns);
    if (bytes.size() < kIdentifierAt + kIdentifierBytes || bytes[kIdentifierAt + 8] != '-')
      return fail(Code::Internal, "OpenVDB wrote a header that this version does not know", sink.name());
    bytes.replace(kIdentifierAt, kIdentifierBytes, std::string(kIdentifierBytes, '0'));
    bytes.replace(kIdentifierAt, kIdentifierBytes, identifier_of(bytes));
    return sink.write(std::string_view(bytes));
  } catch (const std::exception& error) {
    return fail(Code::Internal, std::string("OpenVDB: ") + error.what(), sink.name());
  }
}

}  // namespace scanmill::store
