// SPDX-License-Identifier: Apache-2.0
// The readers behind open_view, one per family of formats.
#pragma once
#include "formats/view_reader.hpp"

namespace scanmill::formats {

Result<std::unique_ptr<ViewReader>> open_ply(std::shared_ptr<const ByteSource> source);
Result<std::unique_ptr<ViewReader>> open_text(std::shared_ptr<const ByteSource> source);

}  // namespace scanmill::formats
