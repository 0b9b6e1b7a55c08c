// SPDX-License-Identifier: Apache-2.0
// What one task of a scan hands to the next: rows of fixed size in one file, complete or not there, tied by an identity
// to inputs, keys and version. Same machine family only (little-endian, as the records are); never part of a result.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "base/bytes.hpp"
#include "base/digest.hpp"

namespace scanmill::pipeline {

/// What a reader insists on. `identity`: 64 hex digits.
struct PartKind {
  std::string identity;
  std::string name;  // "map 12"; at most 24 bytes
  std::uint64_t row_bytes = 0;
};

/// Rows one after the other, then a text of any length; both with checksums, of the rows block by block.
class PartWriter {
 public:
  /// errors  NoSpace, IoFailed naming the path
  static Result<PartWriter> create(const std::string& path, const PartKind& kind);
  /// Whole rows.
  Result<void> add(std::span<const char> rows);
  template <class Row>
  Result<void> add_rows(std::span<const Row> rows) {
    static_assert(std::is_trivially_copyable_v<Row>);
    return add({reinterpret_cast<const char*>(rows.data()), rows.size_bytes()});
  }
  /// Synced and under its name when this returns.
  Result<void> commit(std::string_view text = {});

 private:
  std::unique_ptr<ByteSink> sink_;
  Sha256 hash_;
  std::vector<std::uint32_t> sums_;
  std::uint64_t row_bytes_ = 1, bytes_ = 0;
};

class PartFile {
 public:
  /// Nothing when there is no such file, or it is another one's, cut or of another kind: then it is to be made. For one
  /// thread.
  static std::optional<PartFile> open(const std::string& path, const PartKind& kind);
  std::uint64_t rows() const { return rows_; }
  const std::string& text() const { return text_; }
  /// Rows [first, first + out.size() / row_bytes).
  /// errors  IoFailed naming the file; when they are not the bytes that were written it is removed
  Result<void> read(std::uint64_t first, std::span<char> out) const;
  template <class Row>
  Result<void> read_rows(std::uint64_t first, std::span<Row> out) const {
    return read(first, {reinterpret_cast<char*>(out.data()), out.size_bytes()});
  }

 private:
  std::shared_ptr<const ByteSource> source_;
  Error damaged(std::uint64_t at) const;

  std::uint64_t row_bytes_ = 1, rows_ = 0;
  std::string path_, text_;
  std::vector<std::uint32_t> sums_;
  mutable std::vector<std::uint8_t> seen_;  // blocks found to be what was written
};

}  // namespace scanmill::pipeline
