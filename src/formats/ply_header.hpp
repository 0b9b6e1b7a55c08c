// SPDX-License-Identifier: Apache-2.0
// The header of a PLY file (Turk 1994): elements, their properties, where the data begins.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/bytes.hpp"

namespace scanmill::formats {

enum class PlyType : std::uint8_t { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };
std::size_t size_of(PlyType type);
/// One value at `p`, its bytes reversed when `swap`.
double load_value(PlyType type, bool swap, const char* p);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::Float32;  // of the value, or of the list's items
  bool is_list = false;
  PlyType count_type = PlyType::UInt8;  // of the list's length
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
  bool has_lists = false;
  std::uint64_t stride = 0;  // bytes of a binary row; meaningless with lists
  /// Index of the scalar property of this name, or -1.
  int find_scalar(std::string_view property) const;
};

enum class PlyEncoding { Ascii, LittleEndian, BigEndian };

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::Ascii;
  std::vector<PlyElement> elements;
  std::vector<std::string> comments;  // without the word `comment`
  std::vector<std::string> notes;     // what was skipped
  std::uint64_t data_offset = 0;      // first byte behind end_header's line
  std::uint64_t data_line = 0;        // number from 1 of the first line there
  bool swaps_bytes() const;
  const char* format_name() const;
  /// Index of the element of this name, or -1.
  int find(std::string_view element) const;
};

/// errors  BadInput with "file:line": unknown encoding, type or form of an element or property line, counts that are no
///         numbers, names given twice, no end_header within the first MiB. Unknown other lines become notes.
Result<PlyHeader> read_ply_header(const ByteSource& source);

/// Whether the bytes begin like a PLY file.
bool looks_like_ply(std::string_view first_bytes);

}  // namespace scanmill::formats
