// SPDX-License-Identifier: Apache-2.0
#include "formats/view_reader.hpp"

#include "formats/probe.hpp"
#include "formats/readers.hpp"

namespace scanmill::formats {

Result<std::unique_ptr<ViewReader>> open_view(std::shared_ptr<const ByteSource> source) {
  TRY_ASSIGN(const Probe found, probe(*source));
  switch (found.kind) {
    case FileKind::Ply:
      return open_ply(std::move(source));
    case FileKind::Unsupported:
      return fail(Code::Unsupported,
                  "the file format " + found.format + " is not read by this version; convert the file to PLY or XYZ",
                  source->name());
    case FileKind::PoseMatrices:
      return fail(Code::BadInput, "the file holds 4x4 pose matrices, wanted points", source->name());
    case FileKind::Text:
    case FileKind::Other:
      break;
  }
  return open_text(std::move(source));
}

}  // namespace scanmill::formats
