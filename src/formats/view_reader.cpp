// SPDX-License-Identifier: Apache-2.0
#include "formats/view_reader.hpp"

#include "formats/probe.hpp"
#include "formats/readers.hpp"

namespace scanmill::formats {
namespace {

constexpr std::string_view kFormats[] = {"auto", "ply", "text", "pts", "ptx", "pcd", "las", "png", "fringes"};
constexpr const char* kMeanings[] = {"vertex from 0", "line from 1", "point from 0", "pixel from 0"};

using Views = std::vector<std::unique_ptr<ViewReader>>;

Result<Format> format_of(const ByteSource& source) {
  TRY_ASSIGN(const Probe found, probe(source));
  switch (found.kind) {
    case FileKind::Ply:
      return Format::Ply;
    case FileKind::Pts:
      return Format::Pts;
    case FileKind::Ptx:
      return Format::Ptx;
    case FileKind::Pcd:
      return Format::Pcd;
    case FileKind::Las:
      return Format::Las;
    case FileKind::DepthMap:
      return Format::Png;
    case FileKind::Fringes:
      return Format::Fringes;
    case FileKind::Unsupported:
      return fail(Code::Unsupported,
                  "the file format " + found.format + " is not read by this version; convert the file to " +
                      (found.format == "LAZ" ? "LAS" : "PLY or XYZ"),
                  source.name());
    case FileKind::PoseMatrices:
      return fail(Code::BadInput, "the file holds 4x4 pose matrices, wanted points", source.name());
    case FileKind::Text:
    case FileKind::Other:
      break;
  }
  return Format::Text;
}

Result<Views> only(Result<std::unique_ptr<ViewReader>> reader) {
  if (!reader.ok()) return std::move(reader).error();
  Views views;
  views.push_back(std::move(reader).value());
  return views;
}

}  // namespace

const char* name_of(RowMeaning meaning) { return kMeanings[static_cast<std::size_t>(meaning)]; }

std::span<const std::string_view> format_words() { return kFormats; }

Result<Views> open_views(std::shared_ptr<const ByteSource> source, const OpenOptions& options) {
  Format format = options.format;
  if (format == Format::Auto) {
    TRY_ASSIGN(const Probe found, probe(*source));
    if (found.kind == FileKind::Unsupported && found.has_faces) return only(open_mesh_points(std::move(source)));
    TRY_ASSIGN(format, format_of(*source));
  }
  switch (format) {
    case Format::Ply:
      return only(open_ply(std::move(source)));
    case Format::Pts:
      return only(open_pts(std::move(source)));
    case Format::Ptx:
      return open_ptx(std::move(source));
    case Format::Pcd:
      return only(open_pcd(std::move(source)));
    case Format::Las:
      return only(open_las(std::move(source)));
    case Format::Png:
      if (!options.camera)
        return fail(Code::BadInput,
                    "a depth map needs the numbers of its camera: name it in views with intrinsics: [fx, fy, cx, cy]",
                    source->name());
      return only(open_depth_map(std::move(source), *options.camera));
    case Format::Fringes:
      return only(open_fringes(std::move(source), options));
    case Format::Auto:
    case Format::Text:
      break;
  }
  return only(open_text(std::move(source)));
}

Result<std::unique_ptr<ViewReader>> open_view(std::shared_ptr<const ByteSource> source, const OpenOptions& options) {
  const std::string name = source->name();
  TRY_ASSIGN(Views views, open_views(std::move(source), options));
  if (views.size() == 1) return std::move(views.front());
  return fail(Code::BadInput, "the file holds " + std::to_string(views.size()) + " scans, wanted one", name);
}

}  // namespace scanmill::formats
