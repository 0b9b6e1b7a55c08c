// SPDX-License-Identifier: Apache-2.0
// How work tells that it goes on.
#pragma once
#include <cstdint>
#include <string_view>

namespace scanmill {

/// Called from any thread, as often as convenient; cheap, never blocks for long, never decides anything.
class Progress {
 public:
  virtual ~Progress() = default;
  /// total 0: not known.
  virtual void stage(std::string_view name, std::uint64_t done, std::uint64_t total) = 0;
};

/// For callers that do not watch.
class NoProgress final : public Progress {
 public:
  void stage(std::string_view, std::uint64_t, std::uint64_t) override {}
};

}  // namespace scanmill
