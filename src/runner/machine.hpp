// SPDX-License-Identifier: Apache-2.0
// The machine a run finds itself on: cores, memory, and the cap on this process.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "base/result.hpp"

namespace scanmill::runner {

/// Cores this process may use (affinity mask).
int usable_cores();
/// Physical memory, or the least limit of the control groups above this process where that is less; 0 when neither can
/// be read.
std::uint64_t usable_memory();
/// What the system tells of a lack of memory.
struct MemorySigns {
  std::uint64_t kills = 0;      // processes it killed for that, of the control group or else of the machine
  std::uint64_t available = 0;  // bytes now; 0: not known
};
MemorySigns memory_signs();
/// Whether a process that was killed between the two, and held so much, may have been killed for a lack of memory.
/// machine  usable memory; 0: not known
bool was_short_of_memory(const MemorySigns& before, const MemorySigns& after, std::uint64_t held,
                         std::uint64_t machine);
std::string host_name();
/// Where process numbers mean what they mean here: this start of the kernel and its space of numbers; empty when it
/// cannot be told.
std::string process_space();
/// A process of this process_space.
struct ProcessSign {
  char state = 0;           // as /proc/PID/stat has it: R, S, D, T (stopped), ...
  std::uint64_t began = 0;  // clock ticks since the machine's start: tells processes of one number apart
};
/// Nothing when there is none, or it has ended and only its parent does not know yet.
std::optional<ProcessSign> look_at_process(int pid);
/// False as well for one that has ended and whose parent never asked how; true where nobody may look at it.
bool is_process_alive(int pid);
/// Model of the processor as /proc/cpuinfo has it; "unknown" where it does not say.
std::string processor_name();
/// Highest resident memory of this process so far.
std::uint64_t peak_memory();

/// Time of this process on processors so far.
struct CpuTimes {
  double user_s = 0, system_s = 0;
};
CpuTimes cpu_times();
inline double cpu_seconds() {
  const CpuTimes times = cpu_times();
  return times.user_s + times.system_s;
}

/// Caps the private memory of this process: an allocation beyond it fails, and the scan at hand with it.
/// errors  BadUsage when the cap is below what the process needs by itself
Result<void> cap_memory(std::uint64_t bytes);
/// Large pieces of memory that this process has no room for under the cap go to a nameless file in `folder`
/// (base/paged_memory.hpp). disk  greatest size of that file; 0: what the file system has
void page_beyond(std::uint64_t cap, std::uint64_t disk, const std::string& folder);
/// Bytes that a process then holds before it takes some from the file.
std::uint64_t unpaged_under(std::uint64_t cap);

/// "2026-01-31T08:15:00Z"
std::string utc_now();
/// "00:01:07"
std::string clock_text(double seconds);

}  // namespace scanmill::runner
