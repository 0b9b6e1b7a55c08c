// SPDX-License-Identifier: Apache-2.0
// Bins as OpenVDB grids, for programs that look at volumes.
#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "base/bytes.hpp"
#include "lattice/lattice.hpp"

namespace scanmill::store {

/// One whole number per occupied bin.
struct BinColumn {
  std::string name;  // of the grid
  std::string help;  // metadata "scanmill:meaning"
  std::span<const std::int32_t> values;
};

/// A .vdb file with an Int32 grid per column (class unknown, background -1, active where a bin is occupied). Voxel
/// (i, j, k) is the bin of that key and its centre in the grid's transform, in mm, is the bin's centre; metadata
/// `scanmill:bin_mm` and `scanmill:origin_mm`. The same bytes every time (one OpenVDB and zlib): the identifier that
/// the library draws by lot is replaced by one made from the content. errors  Unsupported when a key needs more than 31
/// bits; Internal when a column does not fit, or the library fails;
///         those of the sink
Result<void> write_bin_grids(const Lattice& lattice, std::span<const BinKey> bins, std::span<const BinColumn> columns,
                             ByteSink& sink);

}  // namespace scanmill::store
