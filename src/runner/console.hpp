// SPDX-License-Identifier: Apache-2.0
// What a command shows: results on stdout, problems and progress on stderr; or one JSON object per line with --json.
#pragma once
#include <chrono>
#include <cstdio>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "base/progress.hpp"
#include "document/document.hpp"

namespace scanmill::runner {

enum class ProgressStyle { Auto, Tty, Plain, Json, None };

struct ConsoleOptions {
  ProgressStyle progress = ProgressStyle::Auto;
  bool json = false;
  bool quiet = false;
};

class Console final : public Progress {
 public:
  explicit Console(const ConsoleOptions& options, std::FILE* out = stdout, std::FILE* err = stderr);
  ~Console() override { end(); }

  /// Work on something named `label` begins; its stages are shown with it until end().
  void begin(const std::string& label);
  void end();
  void stage(std::string_view name, std::uint64_t done, std::uint64_t total) override;

  /// Lines that stand below everything else on a terminal until the next block or end().
  void block(const std::vector<std::string>& lines);
  /// A line of progress where there is no terminal; `event` under --json.
  void progress_line(const std::string& line, const document::Node& event);
  ProgressStyle style() const { return options_.progress; }

  /// A result: `line` on stdout, or the event under --json; hidden by --quiet.
  void result(const std::string& line, const document::Node& event) { put(out_, line, event, options_.quiet); }
  /// The event under --json, and nothing otherwise.
  void event_only(const document::Node& event) { put(out_, "", event, true); }
  /// The last line: always shown.
  void last(const std::string& line, const document::Node& event) { put(out_, line, event, false); }
  /// Something worth knowing that is no problem: on stderr, hidden by --quiet.
  void note(const std::string& scan, const std::string& text);
  /// A text on stdout that was asked for, as it is.
  void print(const std::string& text);
  /// A line on stderr that was asked for.
  void remark(const std::string& line);
  /// A problem: one line each on stderr, and the event on stdout under --json.
  void problem(const std::string& line, const document::Node& event);
  /// An error: each line of its text is a problem of its own.
  void complain(const Error& error);

  /// An event of this type.
  static document::Node event(const char* type);

 private:
  using Clock = std::chrono::steady_clock;
  void put(std::FILE* file, const std::string& line, const document::Node& event, bool hidden);
  void show(Clock::time_point now, std::uint64_t done, std::uint64_t total);
  void erase();

  ConsoleOptions options_;
  std::FILE* out_;
  std::FILE* err_;
  bool colour_ = false;
  std::mutex mutex_;
  std::string label_, stage_;
  Clock::time_point stage_began_{}, next_show_{};
  int drawn_ = 0;  // lines of progress on the terminal
};

}  // namespace scanmill::runner
