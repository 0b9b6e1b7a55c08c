// SPDX-License-Identifier: Apache-2.0
// Single stages on mesh files: the same code as run_scan, without archive and output tree.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/tools.hpp"

namespace scanmill::pipeline {

/// Whether a file is a mesh to these tools: STL, OBJ, OFF, or PLY with faces.
Result<bool> is_mesh_file(const std::string& path);

/// Edge swaps. Without a bin size no new edge is longer than the longest there is.
Result<ToolReport> optimise_file(const std::string& input, const What& what, const std::string& output,
                                 const Context& context, Progress& progress);
/// Planes through a mesh that is judged, as sections_from_words() reads them, and the folder for their files.
struct SectionChoice {
  std::vector<std::string> planes;
  std::string folder;
};
/// Quality of a mesh and, where clouds are given, the distances of all their points and sections as a job draws them
/// (sections.svg, sections.dxf, section-N.png). Without a bin size the unit of histogram and sums, and the thickness of
/// slabs, is the median edge.
Result<ToolReport> verify_file(const std::string& mesh, const std::vector<std::string>& clouds,
                               const SectionChoice& sections, const What& what, const Context& context,
                               Progress& progress);
Result<ToolReport> compare_files(const std::string& a, const std::string& b, const What& what, const Context& context,
                                 Progress& progress);
/// Format, size and quality of a mesh.
Result<ToolReport> mesh_info(const std::string& input, const What& what, const Context& context, Progress& progress);
/// How `convert` writes a mesh, beside the format that the suffix says.
struct MeshForm {
  bool ascii = false;  // STL
  std::string style;   // a word of styles_of(); empty: the first
};
/// Any format of mesh_suffixes() by the output's suffix; what is lost is told.
Result<ToolReport> convert_mesh(const std::string& input, const What& what, const MeshForm& form,
                                const std::string& output, const Context& context, Progress& progress);

struct PictureChoice {
  std::string as;            // a style word; empty: shaded for meshes, points for clouds
  std::string view = "iso";  // a view word
  std::int64_t width = 1280, height = 960;
  double error_range_mm = 0;
};
/// A PNG of a mesh or cloud.
Result<ToolReport> render_file(const std::string& input, const What& what, const PictureChoice& choice,
                               const std::string& output, const Context& context, Progress& progress);

}  // namespace scanmill::pipeline
