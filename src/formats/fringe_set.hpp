// SPDX-License-Identifier: Apache-2.0
// The text that names pictures of shifted fringes and the optics they were taken with (docs/formats.md).
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/bytes.hpp"
#include "fringe/phase.hpp"

namespace scanmill::formats {

/// Names are relative to the folder of the text.
struct FringeGrating {
  double period_mm = 0;
  std::vector<std::string> object, plate;
};

struct FringeSet {
  fringe::Optics optics;
  fringe::Quality quality;
  std::vector<FringeGrating> gratings;
  std::vector<std::pair<std::string, std::string>> sha256;  // of pictures, by name
};

using OpenBeside = std::function<Result<std::shared_ptr<const ByteSource>>(const std::string& name)>;

/// errors  BadInput with "name:line:column", a line per problem
Result<FringeSet> read_fringe_set(const ByteSource& source);
/// The text that reads back to the same set.
std::string fringe_set_text(const FringeSet& set);

/// Width and height of the pictures, from the head of the first.
/// errors  those of the picture
Result<std::pair<std::int64_t, std::int64_t>> fringe_size(const FringeSet& set, const OpenBeside& open);
/// Reads all pictures and decodes them.
/// errors  those of the pictures; BadInput for one whose SHA-256 is not that of the text, or of another size; those of
///         fringe::range_map
Result<fringe::RangeMap> decode_fringes(const FringeSet& set, const OpenBeside& open, const std::string& place);

}  // namespace scanmill::formats
