// SPDX-License-Identifier: Apache-2.0
// The control groups that this process is in, of both versions of Linux's interface.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

namespace scanmill::runner {

/// The least memory limit of this process's control group and all above it, in bytes; 0: none.
/// proc  holds `cgroup` and `mountinfo` of the process; root  stands before the mount points named there
std::uint64_t group_memory_limit(const std::string& proc = "/proc/self", const std::string& root = "");
/// Processes of this process's control group that the kernel killed for a lack of memory, of both versions together;
/// nothing where it does not count them.
std::optional<std::uint64_t> group_memory_kills(const std::string& proc = "/proc/self", const std::string& root = "");

}  // namespace scanmill::runner
