// SPDX-License-Identifier: Apache-2.0
// Where bytes come from and go to. Readers and writers see these, never paths; `store` has the files.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "base/result.hpp"

namespace scanmill {

/// Bytes at any offset; safe to call from several threads at once.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  /// For messages: the path as the user knows it.
  virtual const std::string& name() const = 0;
  virtual std::uint64_t size() const = 0;
  /// Fill `out` from `offset`; returns the bytes read, fewer than asked only at the end of the source.
  virtual Result<std::size_t> read_at(std::uint64_t offset, std::span<char> out) const = 0;
};

/// Bytes in order. Nothing is final before `commit` returned: a sink that is dropped leaves no trace.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  virtual const std::string& name() const = 0;
  virtual Result<void> write(std::span<const char> bytes) = 0;
  virtual Result<void> commit() = 0;
  Result<void> write(std::string_view text) { return write(std::span<const char>(text.data(), text.size())); }
};

/// A source over bytes in memory (tests, embedded documents).
std::unique_ptr<ByteSource> memory_source(std::string name, std::string bytes);
/// A sink that puts what was written in the place of `bytes` on commit (tests, reading back).
std::unique_ptr<ByteSink> memory_sink(std::string name, std::string& bytes);
/// The whole source as a string; BadInput naming `limit` when it is larger, IoFailed when it
/// gives fewer bytes than its size.
Result<std::string> read_all(const ByteSource& source, std::uint64_t limit);

}  // namespace scanmill
