// SPDX-License-Identifier: Apache-2.0
#include "runner/machine.hpp"

#include <sched.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <sstream>

#include "base/paged_memory.hpp"
#include "base/text.hpp"
#include "runner/control_group.hpp"

namespace scanmill::runner {
namespace {

// Measured on an idle process with all libraries loaded and a pool of two threads: 50 MB.
constexpr std::uint64_t kBaseMemory = 64ull << 20;

}  // namespace

int usable_cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) == 0) return std::max(1, CPU_COUNT(&set));
  return std::max(1, static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN)));
}

std::uint64_t usable_memory() {
  const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
  const std::uint64_t whole =
      pages > 0 && page > 0 ? static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page) : 0;
  const std::uint64_t limit = group_memory_limit();
  return whole > 0 && limit > 0 ? std::min(whole, limit) : std::max(whole, limit);
}

MemorySigns memory_signs() {
  const auto named = [](const char* path, const std::string& name) -> std::uint64_t {
    std::ifstream file(path);
    std::string word;
    while (file >> word)
      if (std::uint64_t value = 0; word == name && file >> value) return value;
    return 0;
  };
  const auto of_group = group_memory_kills();
  return {of_group ? *of_group : named("/proc/vmstat", "oom_kill"), named("/proc/meminfo", "MemAvailable:") << 10};
}

bool was_short_of_memory(const MemorySigns& before, const MemorySigns& after, std::uint64_t held,
                         std::uint64_t machine) {
  if (after.kills > before.kills || after.available == 0 || machine == 0) return true;
  // A watcher like systemd-oomd kills before the kernel must, and is not counted.
  return after.available < held + machine / 20;
}

std::string host_name() {
  utsname name;
  return uname(&name) == 0 ? name.nodename : "unknown";
}

std::string process_space() {
  std::string boot;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> boot;
  char space[64];
  const ssize_t length = readlink("/proc/self/ns/pid", space, sizeof space);
  if (boot.empty() || length <= 0) return {};
  return boot + " " + std::string(space, static_cast<std::size_t>(length));
}

namespace {

bool has_ended(const ProcessSign& sign) { return sign.state == 'Z' || sign.state == 'X'; }

/// Those too that have ended and are only not forgotten yet.
std::optional<ProcessSign> read_sign(int pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string line;
  if (pid <= 0 || !std::getline(file, line)) return std::nullopt;
  const std::size_t name_end = line.rfind(')');  // the name may hold anything
  if (name_end == std::string::npos) return std::nullopt;
  std::istringstream rest(line.substr(name_end + 1));
  ProcessSign sign;
  if (!(rest >> sign.state)) return std::nullopt;
  std::string skipped;
  for (int field = 4; field < 22; ++field) rest >> skipped;
  if (!(rest >> sign.began)) return std::nullopt;
  return sign;
}

}  // namespace

std::optional<ProcessSign> look_at_process(int pid) {
  auto sign = read_sign(pid);
  return sign && !has_ended(*sign) ? sign : std::nullopt;
}

bool is_process_alive(int pid) {
  if (pid <= 0 || (kill(pid, 0) != 0 && errno != EPERM)) return false;
  const auto sign = read_sign(pid);
  return !sign || !has_ended(*sign);  // /proc may hide what belongs to others
}

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("model name")) continue;
    const std::size_t colon = line.find(':');
    if (colon != std::string::npos && colon + 2 < line.size()) return line.substr(colon + 2);
  }
  return "unknown";
}

std::uint64_t peak_memory() {
  rusage usage;
  return getrusage(RUSAGE_SELF, &usage) == 0 ? static_cast<std::uint64_t>(usage.ru_maxrss) * 1024 : 0;
}

CpuTimes cpu_times() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return {seconds(usage.ru_utime), seconds(usage.ru_stime)};
}

Result<void> cap_memory(std::uint64_t bytes) {
  if (bytes < kBaseMemory)
    return fail(
        Code::BadUsage,
        "found " + bytes_text(bytes) + "; the process itself needs " + bytes_text(kBaseMemory) + "; give at least that",
        "memory cap");
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // their shadow memory counts as private memory
  rlimit limit;
  if (getrlimit(RLIMIT_DATA, &limit) == 0) {
    limit.rlim_cur = std::min<rlim_t>(bytes, limit.rlim_max);
    if (setrlimit(RLIMIT_DATA, &limit) != 0)
      return fail(Code::Internal, "the system does not take a limit of " + bytes_text(bytes), "memory cap");
  }
#endif
  return {};
}

std::uint64_t unpaged_under(std::uint64_t cap) { return cap > kBaseMemory ? (cap - kBaseMemory) / 5 * 2 : 0; }

void page_beyond(std::uint64_t cap, std::uint64_t disk, const std::string& folder) {
  if (cap == 0) return;
  // What a process holds rises between two looks at it, the more the busier the machine.
  paged::begin(folder, {cap - cap / 5, unpaged_under(cap), disk});
}

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

std::string clock_text(double seconds) {
  const auto whole = static_cast<std::uint64_t>(std::max(0.0, seconds));
  char text[40];
  std::snprintf(text, sizeof text, "%02llu:%02llu:%02llu", static_cast<unsigned long long>(whole / 3600),
                static_cast<unsigned long long>(whole / 60 % 60), static_cast<unsigned long long>(whole % 60));
  return text;
}

}  // namespace scanmill::runner
