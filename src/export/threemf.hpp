// SPDX-License-Identifier: Apache-2.0
// 3MF core specification 1.2: one object in millimetres, a material (name and colour) per patch.
#pragma once
#include <cstdint>

#include "base/bytes.hpp"
#include "export/mesh_stream.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::exporting {

struct ThreeMfCounts {
  std::uint64_t triangles = 0;
  std::uint64_t left_out = 0;  // triangles that name a vertex twice, which the format forbids
  bool closed = false;         // object of type model; else of type surface
};

/// Positions to the last bit, triangles in the order of the mesh; an offset that is not zero stands in the metadata
/// `scanmill:offset_mm`. The same bytes every time (one zlib). A model of
/// more than 4 GiB is a ZIP64 part.
/// errors  BadInput without triangles; Internal when patch ids do not fit the mesh;
///         those of the sink
Result<ThreeMfCounts> write_3mf(const Mesh& mesh, ByteSink& sink);
Result<ThreeMfCounts> stream_3mf(const MeshStream& mesh, ByteSink& sink);

/// Byte for byte comparison of a file, read again, with what the mesh it was written from gives.
/// errors  Internal naming the first byte that differs; those of the source
Result<void> compare_3mf(const Mesh& mesh, const ByteSource& source);

}  // namespace scanmill::exporting
