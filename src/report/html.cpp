// SPDX-License-Identifier: Apache-2.0
#include "report/html.hpp"

#include "base/utf8.hpp"

namespace scanmill::report {
namespace {

constexpr std::string_view kDiv = "<div class=\"scroll\">";
constexpr std::size_t kShortTable = 14;  // rows

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : printable(text)) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (c == '\'')
      out += "&#39;";
    else
      out += c;
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
