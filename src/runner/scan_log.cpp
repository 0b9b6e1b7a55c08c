// SPDX-License-Identifier: Apache-2.0
#include "runner/scan_log.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "store/files.hpp"

namespace scanmill::runner {

Result<std::unique_ptr<ScanLog>> ScanLog::begin(const std::string& path, Progress& onward) {
  TRY(store::make_folders(std::filesystem::path(path).parent_path().string()));
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  std::FILE* stream = file >= 0 ? fdopen(file, "w") : nullptr;
  if (!stream) {
    const int reason = errno;
    if (file >= 0) close(file);
    return fail(reason == ENOSPC || reason == EDQUOT ? Code::NoSpace : Code::IoFailed,
                std::string("cannot be written: ") + std::strerror(reason), path);
  }
  return std::unique_ptr<ScanLog>(new ScanLog(stream, onward));
}

ScanLog::~ScanLog() { std::fclose(file_); }

void ScanLog::line(const std::string& text) {
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
  const std::lock_guard<std::mutex> guard(mutex_);
  std::fprintf(file_, "%9.3f  %s\n", seconds, text.c_str());
  std::fflush(file_);
}

void ScanLog::stage(std::string_view name, std::uint64_t done, std::uint64_t total) {
  bool begins = false;
  {
    const std::lock_guard<std::mutex> guard(mutex_);
    begins = stage_ != name;
    if (begins) stage_ = name;
  }
  if (begins) line("stage " + std::string(name) + (total ? ", " + std::to_string(total) + " to do" : ""));
  onward_.stage(name, done, total);
}

}  // namespace scanmill::runner
