// SPDX-License-Identifier: Apache-2.0
// What a conversion loses, told before or after it: a sentence per loss, so that nothing goes silently.
#pragma once
#include <string>
#include <vector>

#include "formats/mesh_reader.hpp"
#include "formats/view_reader.hpp"

namespace scanmill::pipeline {

enum class ConvertTarget { StlBinary, StlAscii, Obj, PlyMesh, PlyMeshDouble, PlyPoints, Iges, Dxf, ThreeMf };

/// Whether the format holds coordinates as float32.
bool is_float32(ConvertTarget to);

/// By the suffix of a path (mesh_suffixes()); `as_points` asks for a cloud, `ascii` for the text form of STL.
/// errors  BadUsage for a suffix that is not written, or a cloud in a format of meshes
Result<ConvertTarget> convert_target_of(const std::string& path, bool as_points, bool ascii);

/// Losses of writing a mesh that was read from a file: faces to a cloud, patch ids, vertex errors, properties and
/// comments, the offset, vertices that no face uses, doubles to float32 with the largest rounding in mm and the
/// triangles that collapse by it.
///
/// unit_mm  mm per unit of the file
/// returns  one sentence each, in a fixed order; empty when nothing is lost
std::vector<std::string> conversion_losses(const formats::MeshFile& mesh, ConvertTarget to, double unit_mm = 1);

/// Losses of writing the points of a file: faces, and what the reader skipped.
std::vector<std::string> conversion_losses(const formats::ViewHeader& cloud, ConvertTarget to);

}  // namespace scanmill::pipeline
