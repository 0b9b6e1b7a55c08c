// SPDX-License-Identifier: Apache-2.0
#include "report/html.hpp"

namespace scanmill::report {
namespace {

constexpr std::string_view kDiv = "<div class=\"scroll\">";
constexpr std::size_t kShortTable = 14;  // rows
constexpr char kHex[] = "0123456789abcdef";

/// Length of the well-formed UTF-8 sequence at `at`, 0 when there is none; its value in `value`.
std::size_t sequence(std::string_view text, std::size_t at, std::uint32_t& value) {
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

/// Would hide or turn around what stands next to it.
bool is_treacherous(std::uint32_t c) {
  return c < 0x20 || (c >= 0x7f && c < 0xa0) || (c >= 0x200b && c <= 0x200f) || (c >= 0x2028 && c <= 0x202e) ||
         (c >= 0x2060 && c <= 0x206f) || c == 0x61c || c == 0xfeff || (c & 0xfffe) == 0xfffe;
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    std::uint32_t value = 0;
    const std::size_t size = sequence(text, at, value);
    if (size == 0 || value < 0x20 || value == 0x7f) {
      const auto byte = static_cast<unsigned char>(text[at++]);
      out += {'\\', 'x', kHex[byte >> 4], kHex[byte & 15]};
      continue;
    }
    if (is_treacherous(value)) {
      out += "\\u{";
      for (int shift = value > 0xffff ? 20 : 12; shift >= 0; shift -= 4) out += kHex[value >> shift & 15];
      out += '}';
    } else if (value == '&') {
      out += "&amp;";
    } else if (value == '<') {
      out += "&lt;";
    } else if (value == '>') {
      out += "&gt;";
    } else if (value == '"') {
      out += "&quot;";
    } else if (value == '\'') {
      out += "&#39;";
    } else {
      out += text.substr(at, size);
    }
    at += size;
  }
  return out;
}

std::string base64(std::string_view bytes) {
  static constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (at + k < bytes.size() ? static_cast<unsigned char>(bytes[at + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += k <= bytes.size() - at ? kLetters[group >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

Table::Table(std::string& out, std::string_view caption, std::vector<Head> heads)
    : out_(out), start_(out.size()), heads_(std::move(heads)) {
  out_ += kDiv;
  out_ += "<table>\n";
  if (!caption.empty()) out_ += "<caption>" + escaped(caption) + "</caption>\n";
  out_ += "<thead><tr>";
  for (const Head& head : heads_)
    out_ += (head.column == Column::Number ? "<th scope=\"col\" class=\"n\">" : "<th scope=\"col\">") +
            escaped(head.name) + "</th>";
  out_ += "</tr></thead>\n<tbody>\n";
}

Table::~Table() {
  if (rows_ <= kShortTable) out_.insert(start_ + kDiv.size() - 2, " short");
  out_ += "</tbody></table></div>\n";
}

void Table::row(std::initializer_list<std::string> cells, std::string_view mark) {
  out_ += mark.empty() ? "<tr>" : "<tr class=\"" + escaped(mark) + "\">";
  ++rows_;
  std::size_t k = 0;
  for (const std::string& cell : cells) {
    const Column column = k < heads_.size() ? heads_[k].column : Column::Text;
    const char* tag = k == 0 ? "th" : "td";
    out_ += std::string("<") + tag + (k == 0 ? " scope=\"row\"" : "");
    out_ += column == Column::Number   ? " class=\"n\">"
            : column == Column::Place  ? " class=\"p\">"
            : column == Column::Digest ? " class=\"d\">"
                                       : ">";
    out_ += escaped(cell) + "</" + tag + ">";
    ++k;
  }
  out_ += "</tr>\n";
}

}  // namespace scanmill::report
