// SPDX-License-Identifier: Apache-2.0
// The job's `outputs`: which mesh files, in which form. One table feeds reading, schema, file names and `convert`.
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "document/document.hpp"
#include "document/read_fields.hpp"

namespace scanmill::pipeline {

/// Bins that a fitted surface may be off a point, unless the job says otherwise.
inline constexpr double kSurfaceTolerance = 0.25;

/// A file to write.
struct Output {
  std::string format;                         // a word of output_words()
  bool ascii = false;                         // stl only
  std::string style{};                        // of formats that have styles; empty for the others
  double tolerance_bins = kSurfaceTolerance;  // iges, style surfaces only
  friend bool operator==(const Output&, const Output&) = default;
};

std::span<const std::string_view> output_words();
/// Styles of a format, the default first; empty when it has none.
std::span<const std::string_view> styles_of(std::string_view format);
/// "mesh.igs" for iges: the name in a scan's folder.
std::string file_name_of(const Output& output);
/// The format that a suffix ("igs", "iges", "stl") stands for; empty when none is written.
std::string_view format_of_suffix(std::string_view suffix);
/// Suffixes that mesh files may have, in the order of the formats.
std::span<const std::string_view> mesh_suffixes();

/// Problems go to `problems`; what could be read comes back.
std::vector<Output> read_outputs(const document::Node& value, document::Problems& problems);
document::Node outputs_to_document(const std::vector<Output>& outputs);
document::Node outputs_schema();

/// The job's `previews`: pictures of the report, preview-WORD.png each; in the order of the report, one at least.
std::span<const std::string_view> preview_words();
std::vector<std::string> read_previews(const document::Node& value, document::Problems& problems);
document::Node previews_schema();

}  // namespace scanmill::pipeline
