// SPDX-License-Identifier: Apache-2.0
#include "pipeline/mesh_files.hpp"

#include <algorithm>
#include <filesystem>

#include "base/digest.hpp"
#include "base/text.hpp"
#include "export/dxf.hpp"
#include "export/iges.hpp"
#include "export/mesh_writers.hpp"
#include "export/threemf.hpp"
#include "export/writers.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

constexpr std::uint64_t kManyFaces = 50'000;  // CAD programs take minutes from here on

template <class Style>
Style word_of_style(const Output& output) {
  const auto styles = styles_of(output.format);
  const auto at = std::find(styles.begin(), styles.end(), output.style);
  return at == styles.end() ? Style{} : static_cast<Style>(at - styles.begin());
}

void add_iges_notes(const exporting::IgesCounts& counts, std::uint64_t triangles, const std::string& name,
                    std::vector<std::string>& notes) {
  if (triangles > kManyFaces)
    notes.push_back(name + " holds " + grouped(triangles) + " triangles in " + bytes_text(counts.bytes) +
                    ": CAD programs take minutes and gigabytes to open it; larger bins make it smaller");
  if (counts.left_out > 0)
    notes.push_back(name + " leaves out " + counted(counts.left_out, "triangle") + " without area");
  if (counts.inside_out > 0)
    notes.push_back(name + " holds " + counted(counts.inside_out, "closed component") +
                    " as closed shells, not as solids, since they are turned inside out (cavities)");
}

void add_3mf_notes(const exporting::ThreeMfCounts& counts, const std::string& name, std::vector<std::string>& notes) {
  if (counts.left_out > 0)
    notes.push_back(name + " leaves out " + counted(counts.left_out, "triangle") +
                    " with two equal corners, which the format forbids");
  if (!counts.closed)
    notes.push_back(name +
                    " holds an open surface (type surface): printing programs want closed ones and may refuse it");
}

}  // namespace

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
                                    const std::string& path, std::optional<double> bin_mm,
                                    const ScanSurfaces* surfaces) {
  static const std::string kComments[] = {"scanmill mesh, mm; error: signed fit error in the vertex's bin"};
  exporting::PlyMeshOptions ply;
  ply.error = errors.signed_mm;
  ply.error_rms = errors.rms_mm;
  if (!errors.signed_mm.empty()) ply.comments = kComments;
  exporting::IgesOptions iges{word_of_style<exporting::IgesStyle>(output), bin_mm};
  if (surfaces) iges.surfaces = &surfaces->fitted;
  const auto dxf = word_of_style<exporting::DxfStyle>(output);
  WrittenFile file;
  file.name = std::filesystem::path(path).filename().string();
  TRY_ASSIGN(auto sink, store::create_file(path));
  if (output.format == "ply") {
    TRY(exporting::write_ply_mesh(mesh, ply, *sink));
  } else if (output.format == "obj") {
    TRY(exporting::write_obj(mesh, *sink));
  } else if (output.format == "iges") {
    TRY_ASSIGN(const exporting::IgesCounts counts, exporting::write_iges(mesh, iges, *sink));
    if (iges.style == exporting::IgesStyle::Surfaces)
      file.notes.push_back(surfaces_note(*surfaces, file.name));
    else
      add_iges_notes(counts, mesh.triangles.size(), file.name, file.notes);
  } else if (output.format == "dxf") {
    TRY(exporting::write_dxf(mesh, dxf, *sink));
  } else if (output.format == "3mf") {
    TRY_ASSIGN(const exporting::ThreeMfCounts counts, exporting::write_3mf(mesh, *sink));
    add_3mf_notes(counts, file.name, file.notes);
  } else if (output.ascii) {
    TRY(exporting::write_stl_ascii(mesh, *sink));
  } else {
    TRY(exporting::write_stl(mesh, *sink));
  }
  TRY(sink->commit());
  TRY_ASSIGN(const auto source, store::open_file(path, path));
  if (output.format == "ply")
    TRY(exporting::compare_ply_mesh(mesh, ply, *source));
  else if (output.format == "obj")
    TRY(exporting::compare_obj(mesh, *source));
  else if (output.format == "iges")
    TRY(exporting::compare_iges(mesh, iges, *source));
  else if (output.format == "dxf")
    TRY(exporting::compare_dxf(mesh, dxf, *source));
  else if (output.format == "3mf")
    TRY(exporting::compare_3mf(mesh, *source));
  else if (output.ascii)
    TRY(exporting::compare_stl_ascii(mesh, *source));
  else
    TRY(exporting::compare_stl(mesh, *source));
  file.bytes = source->size();
  TRY_ASSIGN(file.sha256, sha256_of(*source));
  return file;
}

}  // namespace scanmill::pipeline
