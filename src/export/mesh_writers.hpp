// SPDX-License-Identifier: Apache-2.0
// Meshes as PLY, ASCII STL and OBJ: in key order, the same bytes every time, streamed. An offset that is not zero
// stands in the file as `offset_mm x y z` (add it for the global frame).
#pragma once
#include <span>
#include <string>

#include "base/bytes.hpp"
#include "export/mesh_stream.hpp"
#include "mesh/mesh.hpp"

namespace scanmill::exporting {

struct PlyMeshOptions {
  bool double_positions = false;            // x y z as double instead of float32
  std::span<const float> error = {};        // per vertex, mm, signed; empty: no such property
  std::span<const float> error_rms = {};    // per vertex, mm; empty: no such property
  std::span<const std::string> comments{};  // header lines, made printable
};

/// Binary little-endian PLY: vertex x y z [error] [error_rms], face uchar/int vertex_indices, uint patch where the mesh
/// has patches.
/// errors  what the sink reports; Unsupported from 2^31 vertices on; Internal when a length does not fit the mesh
Result<void> write_ply_mesh(const Mesh& mesh, const PlyMeshOptions& options, ByteSink& sink);
Result<void> stream_ply_mesh(const MeshStream& mesh, const PlyMeshOptions& options, ByteSink& sink);

/// ASCII STL: shortest decimal text of the float32 coordinates, normals as in the binary file.
Result<void> write_stl_ascii(const Mesh& mesh, ByteSink& sink);
Result<void> stream_stl_ascii(const MeshStream& mesh, ByteSink& sink);

/// OBJ: v lines with the shortest text that reads back to the same double (so readers in double and in float32 get the
/// position as the mesh holds it), one `g patch_N` per patch in ascending N, faces in the order of the mesh, numbered
/// from 1. A mesh without patches has no groups.
/// errors  what the sink reports; Internal when the patch ids do not fit the mesh
Result<void> write_obj(const Mesh& mesh, ByteSink& sink);
/// Faces in the order of the stream, a `g` line wherever the patch changes.
Result<void> stream_obj(const MeshStream& mesh, ByteSink& sink);

/// Byte for byte comparison of a file, read again, with what the mesh it was written from gives.
/// errors  Internal naming the first byte that differs; those of the source
Result<void> compare_ply_mesh(const Mesh& mesh, const PlyMeshOptions& options, const ByteSource& source);
Result<void> compare_stl_ascii(const Mesh& mesh, const ByteSource& source);
Result<void> compare_obj(const Mesh& mesh, const ByteSource& source);

/// Whether float32 holds every coordinate exactly, as Mesh promises for meshes of the pipeline.
bool fits_float32(std::span<const Vec3> positions);

}  // namespace scanmill::exporting
