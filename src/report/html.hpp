// SPDX-License-Identifier: Apache-2.0
// Text to safe HTML.
#pragma once
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill::report {

/// For text and for attributes in double quotes. File names are hostile: markup becomes entities; control characters,
/// bytes that are no UTF-8 and direction marks become \xNN or \u{NNNN}.
std::string escaped(std::string_view text);
std::string base64(std::string_view bytes);

/// How a column stands: text left, numbers right, places on one line, digests breakable anywhere.
enum class Column { Text, Number, Place, Digest };

/// Rows of a table are given cell by cell; cells are escaped. A short table is not cut between two sheets of paper.
class Table {
 public:
  struct Head {
    std::string_view name;
    Column column = Column::Text;
  };
  /// `caption` may be empty. The first column holds row headings.
  Table(std::string& out, std::string_view caption, std::vector<Head> heads);
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;
  ~Table();
  /// `mark` becomes the class of the row.
  void row(std::initializer_list<std::string> cells, std::string_view mark = {});

 private:
  std::string& out_;
  std::size_t start_;
  std::vector<Head> heads_;
  std::size_t rows_ = 0;
};

}  // namespace scanmill::report
