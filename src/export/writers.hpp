// SPDX-License-Identifier: Apache-2.0
// Meshes and clouds as files, in key order, the same bytes every time.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "cloud/cloud.hpp"
#include "export/mesh_stream.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::exporting {

/// Binary STL: 80-byte header beginning "scanmill" (never "solid", no time), attribute bytes zero, normals from the
/// float32 corners, no -0. Positions are written as Mesh holds them (offset not added).
/// errors  what the sink reports; Unsupported above 2^32-1 triangles
Result<void> write_stl(const Mesh& mesh, ByteSink& sink);
Result<void> stream_stl(const MeshStream& mesh, ByteSink& sink);

/// The 80 header bytes that write_stl writes; an offset that is not zero stands in them as `offset_mm x y z`, as far as
/// there is room.
std::string stl_header(const Vec3& offset);

/// What a binary STL holds, for reading back.
/// errors  BadInput when the size is not 84 + 50 n
Result<std::vector<std::array<float, 9>>> read_stl(const ByteSource& source);

/// Corner for corner comparison of a file with the mesh it was written from; Internal naming the first difference.
Result<void> compare_stl(const Mesh& mesh, const ByteSource& source);

/// One view as the sensor gave it: binary little-endian PLY, float x y z, in the order given; cells with a NaN are left
/// out. Points whose coordinates are float32 values are read back to the same bits.
Result<void> write_view_ply(std::span<const Vec3> points, std::span<const std::string> comments, ByteSink& sink);

/// Binary little-endian PLY points in a stream: double x y z, uint view, double row. The count must be known before.
/// `comments` become header comments, one line each.
class PlyPointWriter {
 public:
  static Result<PlyPointWriter> begin(ByteSink& sink, std::uint64_t count, std::span<const std::string> comments);
  /// errors  Internal when more points come than were announced
  Result<void> add(const PointBlock& block);
  /// errors  Internal when fewer points came than were announced; does not commit the sink
  Result<void> finish();

 private:
  explicit PlyPointWriter(ByteSink& sink, std::uint64_t count) : sink_(&sink), announced_(count) {}
  ByteSink* sink_;
  std::uint64_t announced_;
  std::uint64_t written_ = 0;
  std::vector<char> buffer_;
};

}  // namespace scanmill::exporting
