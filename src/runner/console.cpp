// SPDX-License-Identifier: Apache-2.0
#include "runner/console.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

#include "base/text.hpp"
#include "base/utf8.hpp"

namespace scanmill::runner {
namespace {

/// Names of files and texts of damaged records may hold anything, also what a terminal obeys.
std::string shown(const std::string& line) { return printable(line, true); }

constexpr auto kTtyInterval = std::chrono::milliseconds(100);
constexpr auto kPlainInterval = std::chrono::seconds(3);

/// 1234567 as "1.2M".
std::string short_count(double value) {
  static constexpr const char* kUnits[] = {"", "k", "M", "G", "T"};
  int unit = 0;
  while (value >= 1000 && unit < 4) {
    value /= 1000;
    ++unit;
  }
  char text[32];
  std::snprintf(text, sizeof text, unit == 0 || value >= 100 ? "%.0f%s" : "%.1f%s", value, kUnits[unit]);
  return text;
}

std::string minutes(double seconds) {
  const auto whole = static_cast<unsigned long long>(seconds + 0.5);
  char text[40];
  std::snprintf(text, sizeof text, "%llu:%02llu", whole / 60, whole % 60);
  return text;
}

std::size_t width_of(std::FILE* file) {
  winsize size{};
  return ioctl(fileno(file), TIOCGWINSZ, &size) == 0 && size.ws_col > 10 ? size.ws_col - 1u : 79u;
}

/// To the beginning of the first of so many lines.
std::string up_to_first(int lines) {
  return lines > 1 ? "\r\x1b[" + std::to_string(lines - 1) + "A" : std::string("\r");
}

}  // namespace

Console::Console(const ConsoleOptions& options, std::FILE* out, std::FILE* err)
    : options_(options), out_(out), err_(err) {
  const bool tty = isatty(fileno(err)) != 0;
  if (options_.progress == ProgressStyle::Auto)
    options_.progress = options_.quiet  ? ProgressStyle::None
                        : options_.json ? ProgressStyle::Json
                        : tty           ? ProgressStyle::Tty
                                        : ProgressStyle::Plain;
  const char* no_colour = std::getenv("NO_COLOR");
  colour_ = tty && !options_.json && (!no_colour || !*no_colour);
}

document::Node Console::event(const char* type) {
  document::Node node = document::Node::map();
  node.set("type", type);
  return node;
}

void Console::begin(const std::string& label) {
  const std::lock_guard<std::mutex> guard(mutex_);
  label_ = label;
  stage_.clear();
  next_show_ = Clock::now() + (options_.progress == ProgressStyle::Tty ? Clock::duration(kTtyInterval)
                                                                       : Clock::duration(kPlainInterval));
}

void Console::end() {
  const std::lock_guard<std::mutex> guard(mutex_);
  erase();
  label_.clear();
  stage_.clear();
}

void Console::stage(std::string_view name, std::uint64_t done, std::uint64_t total) {
  if (options_.progress == ProgressStyle::None) return;
  const std::unique_lock<std::mutex> guard(mutex_, std::try_to_lock);
  if (!guard.owns_lock()) return;  // another thread is showing; the next call will
  const auto now = Clock::now();
  if (stage_ != name) {
    stage_ = name;
    stage_began_ = now;
  }
  if (now < next_show_) return;
  show(now, done, total);
  next_show_ =
      now + (options_.progress == ProgressStyle::Tty ? Clock::duration(kTtyInterval) : Clock::duration(kPlainInterval));
}

void Console::show(Clock::time_point now, std::uint64_t done, std::uint64_t total) {
  const double seconds = std::chrono::duration<double>(now - stage_began_).count();
  const double rate = seconds > 0.05 ? static_cast<double>(done) / seconds : 0;
  const double eta = rate > 0 && total > done ? static_cast<double>(total - done) / rate : 0;
  if (options_.progress == ProgressStyle::Json) {
    document::Node node = event("progress");
    node.set("scan", label_);
    node.set("stage", stage_);
    node.set("done", done);
    node.set("total", total);
    node.set("per_second", rate);
    node.set("eta_s", eta);
    std::FILE* file = options_.json ? out_ : err_;
    std::fprintf(file, "%s\n", document::to_json(node).c_str());
    std::fflush(file);
    return;
  }
  std::string line = label_ + (label_.empty() ? "" : "  ") + stage_ + "  " + short_count(static_cast<double>(done));
  if (total > 0) {
    line += "/" + short_count(static_cast<double>(total)) + "  " +
            std::to_string(std::min<std::uint64_t>(
                100, static_cast<std::uint64_t>(100.0 * static_cast<double>(done) / static_cast<double>(total)))) +
            "%";
  }
  if (rate > 0) line += "  " + short_count(rate) + "/s";
  if (eta > 0) line += "  ETA " + minutes(eta);
  if (options_.progress == ProgressStyle::Tty) {
    erase();
    std::fprintf(err_, "%s", line.substr(0, width_of(err_)).c_str());
    drawn_ = 1;
  } else {
    std::fprintf(err_, "%s\n", line.c_str());
  }
  std::fflush(err_);
}

void Console::block(const std::vector<std::string>& lines) {
  const std::lock_guard<std::mutex> guard(mutex_);
  if (options_.progress != ProgressStyle::Tty) return;
  const std::size_t width = width_of(err_);
  std::string text = up_to_first(drawn_);
  for (std::size_t i = 0; i < lines.size(); ++i) text += (i > 0 ? "\n" : "") + lines[i].substr(0, width) + "\x1b[K";
  std::fputs((text + "\x1b[J").c_str(), err_);
  std::fflush(err_);
  drawn_ = static_cast<int>(lines.size());
}

void Console::progress_line(const std::string& line, const document::Node& event) {
  if (options_.progress == ProgressStyle::None || options_.progress == ProgressStyle::Tty) return;
  const std::lock_guard<std::mutex> guard(mutex_);
  const bool json = options_.progress == ProgressStyle::Json;
  std::FILE* file = json && options_.json ? out_ : err_;
  std::fprintf(file, "%s\n", json ? document::to_json(event).c_str() : line.c_str());
  std::fflush(file);
}

void Console::erase() {
  if (drawn_ == 0) return;
  std::fputs((up_to_first(drawn_) + "\x1b[J").c_str(), err_);
  std::fflush(err_);
  drawn_ = 0;
}

void Console::put(std::FILE* file, const std::string& line, const document::Node& event, bool hidden) {
  const std::lock_guard<std::mutex> guard(mutex_);
  erase();
  if (options_.json)
    std::fprintf(out_, "%s\n", document::to_json(event).c_str());
  else if (!hidden)
    std::fprintf(file, "%s\n", shown(line).c_str());
  std::fflush(file);
  std::fflush(out_);
}

void Console::note(const std::string& scan, const std::string& text) {
  document::Node node = event("note");
  if (!scan.empty()) node.set("scan", scan);
  node.set("text", text);
  put(err_, (scan.empty() ? "note: " : scan + ": note: ") + text, node, options_.quiet);
}

void Console::print(const std::string& text) {
  const std::lock_guard<std::mutex> guard(mutex_);
  erase();
  std::fputs(text.c_str(), out_);
  std::fflush(out_);
}

void Console::remark(const std::string& line) {
  const std::lock_guard<std::mutex> guard(mutex_);
  erase();
  std::fprintf(err_, "%s\n", shown(line).c_str());
  std::fflush(err_);
}

void Console::problem(const std::string& line, const document::Node& event) {
  {
    const std::lock_guard<std::mutex> guard(mutex_);
    erase();
    std::fprintf(err_, colour_ ? "\x1b[31m%s\x1b[0m\n" : "%s\n", shown(line).c_str());
    std::fflush(err_);
  }
  if (options_.json) put(out_, line, event, false);
}

void Console::complain(const Error& error) {
  for (const std::string& line : lines_of(error.text())) {
    document::Node node = event("error");
    node.set("code", name_of(error.code));
    node.set("text", line);
    problem(line, node);
  }
}

}  // namespace scanmill::runner
