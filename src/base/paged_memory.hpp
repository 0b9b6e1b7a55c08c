// SPDX-License-Identifier: Apache-2.0
// Large pieces of memory beyond a budget live in a file that has no name: the kernel keeps of it what is looked at, and
// what this process holds in memory stays under a limit whatever the size of the cloud. Rows lie in the order of bin
// keys, so that every stage walks through space and looks at little at a time.
//
// Where a piece lies has no influence on any result. Only the program `scanmill` takes its memory from here
// (paged_new.cpp); a program without that file uses plain memory.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "base/result.hpp"

namespace scanmill::paged {

/// Smaller pieces are always plain memory; a node of OpenVDB holds 2 KiB.
inline constexpr std::size_t kLeastPaged = 1024;

struct Limits {
  std::uint64_t resident = 0;  // bytes of this process in memory, libraries included
  std::uint64_t plain = 0;     // of pieces from kLeastPaged on that stay in plain memory; beyond it they are paged
  std::uint64_t disk = 0;      // of the file; 0: what the file system holds
};

/// From now on pieces beyond the budget go to a file in `folder`, which must exist. The file is made when it is first
/// needed, has no name and is gone with the process. Called again: new limits and folder, the file that there is stays.
void begin(const std::string& folder, const Limits& limits);

struct Usage {
  std::uint64_t plain = 0;    // bytes of large pieces in plain memory
  std::uint64_t in_file = 0;  // taken from the file now
  std::uint64_t most_in_file = 0;
  std::uint64_t evictions = 0;  // rounds in which pages were given up to stay under the limit
};
Usage usage();

/// What large pieces may still take together; nothing before begin().
struct Room {
  std::uint64_t plain = 0, disk = 0;
};
std::optional<Room> room();

/// Called between two chunks of work: waits until pages were let go where this process holds more than it may. Nothing
/// without a file.
void relieve();

/// True for memory that lives in the file.
bool holds(const void* piece);

/// Why the last piece could not be had, for the message of a std::bad_alloc; empty when memory itself was short.
/// Names the folder and its lack of space, or the limit.
std::string refusal();
/// True when it was the limit given, not the disk: another try comes to the same.
bool limit_was_reached();

namespace detail {
/// nullptr when neither plain memory nor the file has room. `alignment`: a power of two, at most kLeastPaged.
void* take(std::size_t bytes, std::size_t alignment) noexcept;
void give_back(void* piece) noexcept;
}  // namespace detail

}  // namespace scanmill::paged
