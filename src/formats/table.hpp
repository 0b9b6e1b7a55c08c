// SPDX-License-Identifier: Apache-2.0
// One element of a PLY file as columns of numbers, in memory.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"

namespace scanmill::formats {

struct Table {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;  // one per name, all of the same length; values as they are, NaN too
  std::vector<std::string> comments;         // of the file's header
  /// The column of this name, or nullptr.
  const std::vector<double>* find(std::string_view name) const;
};

/// errors  BadInput: the element is not there, has a list property, or the file is cut or lies (as open_view)
Result<Table> read_ply_table(const ByteSource& source, std::string_view element);

}  // namespace scanmill::formats
