// SPDX-License-Identifier: Apache-2.0
// LZF (as in PCD files): tokens that copy up to 32 bytes of the input or up to 264 bytes of the last 8 KiB of the
// output. Decoding can begin at marks, so any part can be read by any thread without the whole in memory.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/bytes.hpp"

namespace scanmill::formats {

/// A token boundary and the output before it that later tokens may copy.
struct LzfMark {
  std::uint64_t in = 0;  // place in the source
  std::uint64_t out = 0;
  std::string history;  // at most 8 KiB
};

struct LzfStream {
  std::uint64_t begin = 0, end = 0;  // of the tokens in the source
  std::uint64_t size = 0;            // of what they decode to
  std::vector<LzfMark> marks;        // one per 256 KiB of output
};

/// Decodes all of it once and keeps the marks: about 3 % of `size`, and never more than the tokens can give.
/// errors  BadInput naming the byte: a token that reads past the end or before the beginning, another length than
/// `size`
Result<LzfStream> index_lzf(const ByteSource& source, std::uint64_t begin, std::uint64_t compressed,
                            std::uint64_t size);
/// The output from `from` on, as many bytes as `out` has; from + out.size() <= stream.size.
/// errors  as above, when the source has changed
Result<void> read_lzf(const ByteSource& source, const LzfStream& stream, std::uint64_t from, std::span<char> out);

}  // namespace scanmill::formats
