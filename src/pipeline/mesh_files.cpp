// SPDX-License-Identifier: Apache-2.0
#include "pipeline/mesh_files.hpp"

#include <filesystem>

#include "base/digest.hpp"
#include "export/mesh_writers.hpp"
#include "export/writers.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {

VertexErrors vertex_errors(const verify::Report& fit) {
  VertexErrors errors;
  errors.signed_mm.reserve(fit.vertices.size());
  errors.rms_mm.reserve(fit.vertices.size());
  for (const verify::VertexError& error : fit.vertices) {
    errors.signed_mm.push_back(static_cast<float>(error.signed_mm));
    errors.rms_mm.push_back(static_cast<float>(error.rms_mm));
  }
  return errors;
}

Result<WrittenFile> write_mesh_file(const Mesh& mesh, const Output& output, const VertexErrors& errors,
                                    const std::string& path) {
  static const std::string kComments[] = {"scanmill mesh, mm; error: signed fit error in the vertex's bin"};
  exporting::PlyMeshOptions ply;
  ply.error = errors.signed_mm;
  ply.error_rms = errors.rms_mm;
  ply.comments = kComments;
  TRY_ASSIGN(auto sink, store::create_file(path));
  if (output.format == "ply")
    TRY(exporting::write_ply_mesh(mesh, ply, *sink));
  else if (output.format == "obj")
    TRY(exporting::write_obj(mesh, *sink));
  else if (output.ascii)
    TRY(exporting::write_stl_ascii(mesh, *sink));
  else
    TRY(exporting::write_stl(mesh, *sink));
  TRY(sink->commit());
  TRY_ASSIGN(const auto source, store::open_file(path, path));
  if (output.format == "ply")
    TRY(exporting::compare_ply_mesh(mesh, ply, *source));
  else if (output.format == "obj")
    TRY(exporting::compare_obj(mesh, *source));
  else if (output.ascii)
    TRY(exporting::compare_stl_ascii(mesh, *source));
  else
    TRY(exporting::compare_stl(mesh, *source));
  WrittenFile file;
  file.name = std::filesystem::path(path).filename().string();
  file.bytes = source->size();
  TRY_ASSIGN(file.sha256, sha256_of(*source));
  return file;
}

}  // namespace scanmill::pipeline
