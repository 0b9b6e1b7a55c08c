// SPDX-License-Identifier: Apache-2.0
#include "formats/table.hpp"

#include <numeric>

#include "formats/cursor.hpp"
#include "formats/ply_layout.hpp"
#include "formats/ply_rows.hpp"

namespace scanmill::formats {

const std::vector<double>* Table::find(std::string_view name) const {
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == name) return &columns[i];
  return nullptr;
}

namespace {

/// Rows of one element, appended to the columns; the layout has shown that all of them are there.
class Filler {
 public:
  Filler(const ByteSource& source, const PlyHeader& header, const PlyElement& element, Table& table)
      : source_(source),
        header_(header),
        element_(element),
        table_(table),
        wanted_(element.properties.size()),
        values_(element.properties.size()) {
    std::iota(wanted_.begin(), wanted_.end(), 0);
  }

  Result<void> fill(const PlyRun& begin) {
    Cursor cursor(source_, begin.offset);
    std::uint64_t line_number = begin.line;
    for (std::uint64_t row = 0; row < element_.count;) {
      if (header_.encoding == PlyEncoding::Ascii) {
        TRY_ASSIGN(const std::string_view line, cursor.line());
        ++line_number;
        if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
        TRY(read_ascii_row(line, element_, wanted_, values_, source_.name(), line_number - 1));
      } else {
        TRY(read_binary_row(cursor, source_, header_, element_, wanted_, values_, row));
      }
      for (std::size_t i = 0; i < values_.size(); ++i) table_.columns[i].push_back(values_[i]);
      ++row;
    }
    return {};
  }

 private:
  const ByteSource& source_;
  const PlyHeader& header_;
  const PlyElement& element_;
  Table& table_;
  std::vector<int> wanted_;
  std::vector<double> values_;
};

}  // namespace

Result<Table> read_ply_table(const ByteSource& source, std::string_view name) {
  TRY_ASSIGN(const PlyHeader header, read_ply_header(source));
  const int number = header.find(name);
  if (number < 0) return fail(Code::BadInput, "the header declares no element " + quoted(name), source.name());
  const PlyElement& element = header.elements[static_cast<std::size_t>(number)];
  if (element.has_lists)
    return fail(Code::BadInput, "element " + quoted(name) + " has a list property, wanted plain numbers only",
                source.name());
  TRY_ASSIGN(const PlyLayout layout, find_rows(source, header, static_cast<std::size_t>(number)));
  Table table;
  table.comments = header.comments;
  for (const PlyProperty& property : element.properties) {
    table.names.push_back(property.name);
    table.columns.emplace_back().reserve(element.count);
  }
  TRY(Filler(source, header, element, table).fill(layout.runs.front()));
  return table;
}

}  // namespace scanmill::formats
