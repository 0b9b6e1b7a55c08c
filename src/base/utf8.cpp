// SPDX-License-Identifier: Apache-2.0
#include "base/utf8.hpp"

namespace scanmill {
namespace {

constexpr char kHex[] = "0123456789abcdef";

/// Would hide or turn around what stands next to it.
bool is_treacherous(std::uint32_t c) {
  return c < 0x20 || (c >= 0x7f && c < 0xa0) || (c >= 0x200b && c <= 0x200f) || (c >= 0x2028 && c <= 0x202e) ||
         (c >= 0x2060 && c <= 0x206f) || c == 0x61c || c == 0xfeff || (c >= 0xfdd0 && c <= 0xfdef) ||
         (c & 0xfffe) == 0xfffe;
}

}  // namespace

std::size_t utf8_sequence(std::string_view text, std::size_t at, std::uint32_t& value) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::uint32_t lead = byte(at);
  const std::size_t size = lead < 0x80                   ? 1
                           : lead >= 0xc2 && lead < 0xe0 ? 2
                           : lead >= 0xe0 && lead < 0xf0 ? 3
                           : lead >= 0xf0 && lead < 0xf5 ? 4
                                                         : 0;
  if (size == 0 || at + size > text.size()) return 0;
  value = size == 1 ? lead : lead & (0x7fu >> size);
  for (std::size_t k = 1; k < size; ++k) {
    if ((byte(at + k) & 0xc0) != 0x80) return 0;
    value = value << 6 | (byte(at + k) & 0x3fu);
  }
  const bool overlong = (size == 3 && value < 0x800) || (size == 4 && value < 0x10000);
  return overlong || value > 0x10ffff || (value >= 0xd800 && value < 0xe000) ? 0 : size;
}

std::string printable(std::string_view text, bool keep_lines) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    std::uint32_t value = 0;
    const std::size_t size = utf8_sequence(text, at, value);
    if (size == 0 || value < 0x20 || value == 0x7f) {
      const auto byte = static_cast<unsigned char>(text[at++]);
      if (keep_lines && (byte == '\n' || byte == '\t'))
        out += static_cast<char>(byte);
      else
        out += {'\\', 'x', kHex[byte >> 4], kHex[byte & 15]};
      continue;
    }
    if (is_treacherous(value)) {
      out += "\\u{";
      for (int shift = value > 0xffff ? 20 : 12; shift >= 0; shift -= 4) out += kHex[value >> shift & 15];
      out += '}';
    } else {
      out += text.substr(at, size);
    }
    at += size;
  }
  return out;
}

}  // namespace scanmill
