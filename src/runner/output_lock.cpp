// SPDX-License-Identifier: Apache-2.0
#include "runner/output_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include "runner/machine.hpp"

namespace scanmill::runner {

Result<OutputLock> OutputLock::take(const std::string& path, std::string& held_by) {
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file < 0)
    return fail(Code::IoFailed,
                std::string("cannot be written: ") + std::strerror(errno) +
                    "; make the folder writable or choose another --out",
                path);
  if (flock(file, LOCK_EX | LOCK_NB) != 0) {
    const int reason = errno;
    char text[256];
    const ssize_t n = pread(file, text, sizeof text, 0);
    struct stat status {};
    const double age = fstat(file, &status) == 0 ? std::difftime(std::time(nullptr), status.st_mtime) : 0;
    close(file);
    if (reason != EWOULDBLOCK)
      return fail(Code::IoFailed,
                  std::string("cannot be locked: ") + std::strerror(reason) +
                      "; use an output folder on a file system with locks",
                  path);
    held_by.assign(text, n > 0 ? static_cast<std::size_t>(n) : 0);
    while (!held_by.empty() && held_by.back() == '\n') held_by.pop_back();
    held_by = (held_by.empty() ? "another process" : held_by) + ", for " + clock_text(age) + " h";
    return fail(Code::Cancelled,
                "another run (" + held_by +
                    ") holds this output; wait for it, stop it with scanmill cancel, or choose another --out",
                path);
  }
  const char* user = std::getenv("USER");
  const std::string text = "pid " + std::to_string(getpid()) + " on " + host_name() +
                           (user && *user ? std::string(", user ") + user : "") + "\n";
  if (ftruncate(file, 0) != 0 || pwrite(file, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size())) {
    const int reason = errno;
    close(file);
    return fail(reason == ENOSPC ? Code::NoSpace : Code::IoFailed,
                std::string("cannot be written: ") + std::strerror(reason), path);
  }
  return OutputLock(file);
}

void OutputLock::forget() {
  if (file_ >= 0) close(file_);
  file_ = -1;
}

OutputLock::~OutputLock() {
  if (file_ >= 0) close(file_);
}

}  // namespace scanmill::runner
