// SPDX-License-Identifier: Apache-2.0
#include "runner/journal.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>

#include "base/digest.hpp"
#include "runner/machine.hpp"
#include "store/files.hpp"

namespace scanmill::runner {

using document::Node;

namespace {

constexpr auto kOldEnough = std::chrono::milliseconds(200);
constexpr int kMuchEnough = 32;
constexpr std::size_t kSumDigits = 16;
constexpr std::string_view kBeforeSum = ",\"sum\":\"", kAfterSum = "\"}";

std::string sum_of(std::string_view text) { return sha256_hex(text).substr(0, kSumDigits); }

Error write_error(const std::string& path) {
  const int reason = errno;
  return fail(
      reason == ENOSPC || reason == EDQUOT ? Code::NoSpace : Code::IoFailed,
      std::string("cannot be written: ") + std::strerror(reason) + "; make room or make it writable, and run again",
      path);
}

}  // namespace

std::string journal_line(const Node& event) {
  std::string text = document::to_json(event);
  const std::string sum = sum_of(text);
  text.pop_back();
  return text + std::string(kBeforeSum) + sum + std::string(kAfterSum) + "\n";
}

std::vector<Node> read_journal(const std::string& text) {
  const std::size_t tail = kBeforeSum.size() + kSumDigits + kAfterSum.size();
  std::vector<Node> events;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    if (end == std::string::npos || end - begin <= tail) break;
    const std::string body = text.substr(begin, end - begin - tail) + "}";
    if (text.compare(end - tail, tail, std::string(kBeforeSum) + sum_of(body) + std::string(kAfterSum)) != 0) break;
    auto event = document::parse_json(body, "journal");
    if (!event || !event->is_map()) break;
    events.push_back(*std::move(event));
    begin = end + 1;
  }
  return events;
}

std::string journal_file(const std::string& folder, std::uint64_t epoch) {
  return folder + "/" + std::to_string(epoch) + ".jsonl";
}

std::vector<std::uint64_t> epochs_in(const std::string& folder) {
  std::vector<std::uint64_t> epochs;
  std::error_code error;
  for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    std::uint64_t epoch = 0;
    const auto [rest, bad] = std::from_chars(name.data(), name.data() + name.size(), epoch);
    if (bad == std::errc() && std::string_view(rest) == ".jsonl") epochs.push_back(epoch);
  }
  std::sort(epochs.begin(), epochs.end());
  return epochs;
}

std::uint64_t latest_epoch(const std::string& folder) {
  const auto epochs = epochs_in(folder);
  return epochs.empty() ? 0 : epochs.back();
}

std::vector<Node> load_journal(const std::string& folder, std::uint64_t epoch) {
  const std::string path = journal_file(folder, epoch);
  const auto source = store::open_file(path, path);
  if (!source) return {};
  const auto text = read_all(**source, 1ull << 30);
  return text ? read_journal(*text) : std::vector<Node>();
}

Result<Journal> Journal::begin(const std::string& folder, Node head) {
  for (std::uint64_t epoch = latest_epoch(folder) + 1;; ++epoch) {
    const std::string path = journal_file(folder, epoch);
    const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0644);
    if (file < 0 && errno == EEXIST) continue;
    if (file < 0) return write_error(path);
    Journal journal(file, path, epoch);
    head.set("epoch", epoch);
    journal.add(std::move(head));
    TRY(journal.commit(true));
    TRY(store::sync_folder(folder));
    return journal;
  }
}

Journal::Journal(Journal&& other) noexcept
    : file_(std::exchange(other.file_, -1)),
      path_(std::move(other.path_)),
      epoch_(other.epoch_),
      waiting_(std::move(other.waiting_)),
      lines_(other.lines_),
      oldest_(other.oldest_) {}

Journal::~Journal() {
  if (file_ < 0) return;
  (void)commit(true);
  close(file_);
}

void Journal::forget() {
  if (file_ >= 0) close(file_);
  file_ = -1;
}

void Journal::add(Node event) {
  event.set("at", utc_now());
  if (lines_++ == 0) oldest_ = std::chrono::steady_clock::now();
  waiting_ += journal_line(event);
}

Result<void> Journal::commit(bool now) {
  if (lines_ == 0 || file_ < 0) return {};
  if (!now && lines_ < kMuchEnough && std::chrono::steady_clock::now() - oldest_ < kOldEnough) return {};
  while (!waiting_.empty()) {
    const ssize_t n = write(file_, waiting_.data(), waiting_.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return write_error(path_);
    waiting_.erase(0, static_cast<std::size_t>(n));
  }
  lines_ = 0;
  if (fdatasync(file_) != 0) return write_error(path_);
  return {};
}

}  // namespace scanmill::runner
