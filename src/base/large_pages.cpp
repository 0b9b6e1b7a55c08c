// SPDX-License-Identifier: Apache-2.0
#include "base/large_pages.hpp"

#include <sys/mman.h>

#include <cstdint>

#include "base/paged_memory.hpp"

namespace scanmill {

void advise_large_pages(void* begin, std::size_t bytes) {
  if (paged::holds(begin)) return;  // one look would bring 2 MiB of the file back
  constexpr std::uintptr_t kPage = std::uintptr_t{1} << 21;
  if (bytes < 2 * kPage) return;
  const auto from = reinterpret_cast<std::uintptr_t>(begin), first = (from + kPage - 1) & ~(kPage - 1);
  const std::uintptr_t last = (from + bytes) & ~(kPage - 1);
  madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
}

}  // namespace scanmill
