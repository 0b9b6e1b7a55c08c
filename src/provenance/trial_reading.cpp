// SPDX-License-Identifier: Apache-2.0
#include "provenance/trial_reading.hpp"

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <new>

namespace scanmill::provenance {
namespace {

constexpr int kSaidNo = 1;
constexpr rlim_t kLeastSeconds = 10;                  // of processor time
constexpr std::uint64_t kBytesPerSecond = 4'000'000;  // slower than any deflated dataset is read

[[noreturn]] void child(std::uint64_t bytes, const std::function<bool()>& reading) {
  for (const int number : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGXCPU}) ::signal(number, SIG_DFL);
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  const rlim_t seconds = kLeastSeconds + static_cast<rlim_t>(bytes / kBytesPerSecond);
  const rlimit time{seconds, seconds + 1};
  ::setrlimit(RLIMIT_CPU, &time);
  ::close(STDERR_FILENO);  // the C library writes there of heaps it finds broken
  try {
    ::_exit(reading() ? 0 : kSaidNo);
  } catch (const std::bad_alloc&) {
    ::_exit(0);  // says nothing of the file; whoever reads it next meets the same and tells it
  } catch (...) {
    ::_exit(kSaidNo);
  }
}

}  // namespace

Result<void> try_in_child(const std::string& path, std::uint64_t bytes, const std::function<bool()>& reading) {
  const pid_t number = ::fork();
  if (number < 0)
    return fail(Code::IoFailed, std::string("no process can be started to try the record: ") + std::strerror(errno),
                path);
  if (number == 0) child(bytes, reading);
  int status = 0;
  while (::waitpid(number, &status, 0) < 0)
    if (errno != EINTR)
      return fail(Code::IoFailed, std::string("lost the process that tried the record: ") + std::strerror(errno), path);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  const std::string how = WIFEXITED(status)             ? ""
                          : WTERMSIG(status) == SIGXCPU ? " (the HDF5 library does not come to an end with it)"
                                                        : " (the HDF5 library fails on it)";
  return fail(Code::BadInput, "the record is damaged and cannot be read" + how + "; restore it, or run the scan again",
              path);
}

}  // namespace scanmill::provenance
