// SPDX-License-Identifier: Apache-2.0
// Texts that many scans share (names of counts and of files), and counts by them: a run over many scans holds each text
// once.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "document/document.hpp"

namespace scanmill::runner {

/// A text of which the process keeps one copy for good. Only for the few that a program itself makes up.
class Word {
 public:
  explicit Word(std::string_view text);
  const std::string& text() const { return *text_; }
  friend bool operator==(Word a, Word b) { return a.text_ == b.text_; }

 private:
  const std::string* text_;
};

/// Numbers by name, in the order in which they were set; 24 bytes each, where a document takes 120.
class Counts {
 public:
  /// Not known; Counts(Node::map()) is known to be empty.
  Counts() = default;
  /// The numbers of a map; not known when it is none.
  Counts(const document::Node& map);  // NOLINT: by intent

  bool is_known() const { return known_; }
  bool empty() const { return rows_.empty(); }
  /// An integer or a number.
  std::optional<document::Node> find(std::string_view name) const;
  /// Replaces or appends; what is no number is left out.
  void set(std::string_view name, const document::Node& number);
  document::Node document() const;

 private:
  struct Row {
    Word name;
    bool whole = false;
    union {
      std::int64_t integer;
      double number;
    };
    document::Node value() const { return whole ? document::Node(integer) : document::Node(number); }
  };
  std::vector<Row> rows_;
  bool known_ = false;
};

}  // namespace scanmill::runner
