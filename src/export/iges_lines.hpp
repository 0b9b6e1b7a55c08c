// SPDX-License-Identifier: Apache-2.0
// The fixed columns of IGES: 80-column lines, records of parameters broken behind a delimiter, directory entries.
#pragma once
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

#include "export/text_buffer.hpp"

namespace scanmill::exporting {

inline constexpr std::size_t kIgesColumns = 64;  // of a parameter line; 72 of a start or global line

/// A number as IGES text, kept to be written several times.
struct IgesReal {
  std::array<char, 27> text;
  std::uint8_t size = 0;
  std::string_view view() const { return {text.data(), size}; }
};
/// The shortest text that reads back to the same double: with a point, and D before an exponent (double precision).
IgesReal iges_real(double value);
/// `decimals` digits behind the point, trailing zeros cut: for components of unit vectors.
IgesReal iges_fixed(double value, int decimals);

/// What a directory entry says beside pointers and counts.
struct IgesEntry {
  int type = 0, form = 0;
  std::string_view status = "00000000";  // blank, subordinate, use, hierarchy: two digits each
  std::int64_t level = 0, colour = 0;    // colour: minus the directory number of a 314
  std::string_view label = {};           // up to 8 characters
  std::int64_t subscript = 0;
};

/// Directory number of the n-th entity, counted from 0.
inline std::uint64_t iges_directory_number(std::uint64_t entity) { return 2 * entity + 1; }

/// Records as they fall into lines. Derived: `put(text)` and `line_end()`.
template <class Derived>
class IgesRecord {
 public:
  void integer(std::int64_t value) {
    std::array<char, 20> digits;
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    text({digits.data(), static_cast<std::size_t>(end - digits.data())});
  }
  void pointer(std::uint64_t entity) { integer(static_cast<std::int64_t>(iges_directory_number(entity))); }
  void real(const IgesReal& value) { text(value.view()); }
  /// One parameter; what precedes it gets its delimiter.
  void text(std::string_view parameter) {
    if (started_) self().put(",");
    if (column_ + parameter.size() + 1 > width_) {
      self().line_end(column_);
      column_ = 0;
    }
    self().put(parameter);
    column_ += parameter.size() + 1;
    started_ = true;
  }

 protected:
  explicit IgesRecord(std::size_t width) : width_(width) {}
  void start() {
    column_ = 0;
    started_ = false;
  }
  void finish() {
    self().put(";");
    self().line_end(column_);
  }

 private:
  Derived& self() { return static_cast<Derived&>(*this); }
  std::size_t width_, column_ = 0;
  bool started_ = false;
};

/// First pass: lines of every record.
class IgesCounter : public IgesRecord<IgesCounter> {
 public:
  IgesCounter() : IgesRecord(kIgesColumns) {}
  template <class Body>
  void entity(const IgesEntry&, Body&& body) {
    lines_.push_back(0);
    start();
    body(*this);
    finish();
    total_ += lines_.back();
  }
  void put(std::string_view) {}
  void line_end(std::size_t) { ++lines_.back(); }
  const std::vector<std::uint32_t>& lines() const { return lines_; }
  std::uint64_t total() const { return total_; }
  Result<void> flush_when_full() { return {}; }

 private:
  std::vector<std::uint32_t> lines_;
  std::uint64_t total_ = 0;
};

/// Second pass: two lines per entity.
class IgesDirectory {
 public:
  IgesDirectory(TextBuffer& out, const std::vector<std::uint32_t>& lines) : out_(out), lines_(lines) {}
  template <class Body>
  void entity(const IgesEntry& entry, Body&&) {
    write(entry);
  }
  void write(const IgesEntry& entry);
  Result<void> flush_when_full() { return out_.flush_when_full(); }

 private:
  TextBuffer& out_;
  const std::vector<std::uint32_t>& lines_;
  std::uint64_t entity_ = 0, first_line_ = 1;
};

/// Last pass: the records.
class IgesParameters : public IgesRecord<IgesParameters> {
 public:
  explicit IgesParameters(TextBuffer& out) : IgesRecord(kIgesColumns), out_(out) {}
  template <class Body>
  void entity(const IgesEntry&, Body&& body) {
    start();
    body(*this);
    finish();
    ++entity_;
  }
  void put(std::string_view text) { out_.text(text); }
  void line_end(std::size_t used);
  /// May be asked between two parameters of a long record.
  Result<void> flush_when_full() { return out_.flush_when_full(); }

 private:
  TextBuffer& out_;
  std::uint64_t entity_ = 0, line_ = 0;
};

/// Lines of the start and global section: 72 columns, `letter` and number behind them.
class IgesHeader : public IgesRecord<IgesHeader> {
 public:
  IgesHeader(TextBuffer& out, char letter) : IgesRecord(72), out_(out), letter_(letter) {}
  /// A line of free text, at most 72 bytes of it.
  void free_text(std::string_view text);
  template <class Body>
  void record(Body&& body) {
    start();
    body(*this);
    finish();
  }
  /// `nH...`
  void hollerith(std::string_view text);
  void put(std::string_view text) { out_.text(text); }
  void line_end(std::size_t used);
  std::uint64_t lines() const { return line_; }

 private:
  TextBuffer& out_;
  char letter_;
  std::uint64_t line_ = 0;
};

/// The global section: mm, IGES 5.3, a fixed date; `what` is the product and the file's name ("mesh": mesh.igs).
void put_iges_global(IgesHeader& global, std::string_view what, double resolution_mm, double largest_mm);
/// `nH...` of a parameter.
std::string iges_hollerith(std::string_view text);
/// The one line of the terminate section.
void put_iges_terminate(TextBuffer& out, std::uint64_t start, std::uint64_t global, std::uint64_t directory,
                        std::uint64_t parameters);

}  // namespace scanmill::exporting
