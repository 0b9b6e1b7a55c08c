// SPDX-License-Identifier: Apache-2.0
// One sparse file, mapped once as a whole: a piece of memory is a piece of the file. Pieces of kLargest bytes and more
// are runs of blocks, found first-fit and given back to the disk when freed; smaller ones come from blocks of one size
// each. A thread looks at what the process holds in memory and lets go of pages, round after round through the file,
// while that is more than allowed; their content stays in the kernel's cache or on disk.
//
// Nothing here may allocate through operator new.
#include "base/paged_memory.hpp"

#include <fcntl.h>
#include <malloc.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <thread>

#include "base/text.hpp"

namespace scanmill::paged {
namespace {

constexpr std::uint64_t kBlock = 1ull << 20;         // of the file
constexpr std::uint64_t kLargest = 128ull << 10;     // from here on pieces are runs of blocks
constexpr std::uint64_t kGreatestSpan = 1ull << 40;  // bytes of addresses
constexpr std::uint64_t kPage = 4096;
constexpr std::uint64_t kLetGoAtOnce = 8ull << 20;
constexpr std::uint64_t kLargeRun = 8;            // blocks
constexpr std::uint64_t kMostWrittenAhead = 128;  // blocks
constexpr auto kLookEvery = std::chrono::microseconds(3000), kLookAgain = std::chrono::microseconds(250);
/// Bytes that may come into memory in a microsecond: a look at one page brings its neighbours where the kernel has
/// them.
constexpr std::uint64_t kComing = 16000;
constexpr auto kPause = std::chrono::milliseconds(50);
constexpr int kClasses = 24;

template <class T>
struct PlainAllocator {
  using value_type = T;
  PlainAllocator() = default;
  template <class U>
  PlainAllocator(const PlainAllocator<U>&) {}  // NOLINT: by intent
  T* allocate(std::size_t count) {
    if (void* piece = std::malloc(count * sizeof(T))) return static_cast<T*>(piece);
    throw std::bad_alloc();
  }
  void deallocate(T* piece, std::size_t) { std::free(piece); }
  template <class U>
  bool operator==(const PlainAllocator<U>&) const {
    return true;
  }
};
using Runs = std::map<std::uint64_t, std::uint64_t, std::less<>,
                      PlainAllocator<std::pair<const std::uint64_t, std::uint64_t>>>;  // first block -> blocks

/// Sizes of the small pieces: every KiB up to 8, then four steps a doubling. Multiples of kLeastPaged, as are places.
constexpr std::uint32_t size_of_class(int number) {
  if (number < 8) return static_cast<std::uint32_t>(kLeastPaged) * static_cast<std::uint32_t>(number + 1);
  return (static_cast<std::uint32_t>(kLeastPaged) * 8 << ((number - 8) / 4)) / 4 *
         static_cast<std::uint32_t>(5 + (number - 8) % 4);
}
static_assert(size_of_class(kClasses - 1) == kLargest);
int class_of(std::size_t bytes) {
  int number = 0;
  while (size_of_class(number) < bytes) ++number;
  return number;
}

struct SizeClass {
  std::mutex mutex;
  void* free = nullptr;                  // a free piece holds the place of the next one
  char *next = nullptr, *end = nullptr;  // of the newest block
};

struct Heap {
  // Set by begin().
  std::atomic<std::uint64_t> plain_limit{0}, resident_limit{0}, disk_limit{0};
  std::atomic<std::int64_t> plain{0};
  char folder[4096] = {};

  std::atomic<char*> base{nullptr};  // of the mapping
  std::uint64_t span = 0;
  int file = -1;
  bool failed = false;

  std::mutex mutex;  // of the runs
  Runs free_runs, taken;
  std::uint64_t blocks = 0;                // used so far, free runs included
  std::uint8_t* class_of_block = nullptr;  // number + 1; 0: a run
  std::atomic<std::uint64_t> in_file{0}, most_in_file{0}, evictions{0}, used_blocks{0};
  SizeClass classes[kClasses];

  std::mutex keeper_mutex;
  std::uint64_t hand = 0;  // where the next round goes on
  int statm = -1;
  std::atomic<std::int64_t> pause_until{0};

  char reason[4600] = {};
  std::atomic<bool> at_limit{false};

  bool holds(const void* piece) const {
    const char* at = static_cast<const char*>(piece);
    const char* begins = base.load(std::memory_order_acquire);
    return begins != nullptr && at >= begins && at < begins + span;
  }
};

/// Never destroyed: pieces are given back until the very end of the process.
Heap& heap() {
  alignas(Heap) static char place[sizeof(Heap)];
  static Heap* const kHeap = new (place) Heap;
  return *kHeap;
}
std::atomic<Heap*> g_heap{nullptr};  // set by begin(): programs without a limit pay for one look at it

void refuse(Heap& h, const char* what, int error) {
  std::snprintf(h.reason, sizeof h.reason, "%s: %s%s%s", h.folder, what, error ? ": " : "",
                error ? std::strerror(error) : "");
}

int nameless_file(const char* folder) {
  int file = open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != ENOENT && errno != EINVAL)) return file;
  char name[4200];
  std::snprintf(name, sizeof name, "%s/.memory.XXXXXX", folder);
  file = mkostemp(name, O_CLOEXEC);
  if (file >= 0) unlink(name);
  return file;
}

/// Bytes of this process in memory, and those of them that come from files.
struct Resident {
  std::uint64_t all = 0, of_files = 0;
};
Resident resident_bytes(int statm) {
  char text[128];
  const ssize_t n = pread(statm, text, sizeof text - 1, 0);
  if (n <= 0) return {};
  text[n] = 0;
  unsigned long long size = 0, resident = 0, shared = 0;
  if (std::sscanf(text, "%llu %llu %llu", &size, &resident, &shared) != 3) return {};
  return {resident * kPage, shared * kPage};
}

/// Lets go of pages until the process holds an eighth less than it may. The mapping stays: what is looked at again
/// comes back from the kernel's cache or the disk.
void let_go(Heap& h) {
  const std::uint64_t high = h.resident_limit.load(std::memory_order_relaxed);
  if (high == 0 || resident_bytes(h.statm).all <= high) return;
  const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
  if (now < h.pause_until.load(std::memory_order_relaxed)) return;
  const std::lock_guard<std::mutex> guard(h.keeper_mutex);  // who is over the limit waits for the one who clears up
  if (resident_bytes(h.statm).all <= high) return;
  h.evictions.fetch_add(1, std::memory_order_relaxed);
  const std::uint64_t low = high - high / 8, used = h.used_blocks.load() * kBlock;
  for (std::uint64_t gone = 0, step = kLetGoAtOnce; gone < used; gone += step) {
    if (h.hand >= used) h.hand = 0;
    const std::uint64_t bytes = std::min(step, used - h.hand);
    madvise(h.base.load() + h.hand, bytes, MADV_DONTNEED);
    h.hand += bytes;
    const std::uint64_t held = resident_bytes(h.statm).all;
    if (held <= low) return;
    // What grows faster than it goes is let go of in larger steps: pages come while this looks for those that are
    // there.
    step = held > high ? 2 * step : kLetGoAtOnce;
  }
  // Pages come back as fast as they go where many threads look at them: then the next look lets go again. But where
  // what is held is not of the file, to go through it again and again brings nothing.
  if (const Resident held = resident_bytes(h.statm); held.all - held.of_files > low)
    h.pause_until.store(now + std::chrono::steady_clock::duration(kPause).count(), std::memory_order_relaxed);
}

/// A thread that works for so short asks the scheduler to come in between those that compute for long, and before them
/// where it has the right to: every turn that it waits lets a gigabyte a second come in. Advice only.
void ask_for_short_turns() {
#ifdef SYS_sched_setattr
  struct {
    std::uint32_t size = 48, policy = 0;
    std::uint64_t flags = 0;
    std::int32_t nice = 0;
    std::uint32_t priority = 0;
    std::uint64_t runtime = 100'000, deadline = 0, period = 0;  // ns
  } attributes;
  attributes.nice = -20;
  if (syscall(SYS_sched_setattr, 0, &attributes, 0) == 0) return;
  attributes.nice = getpriority(PRIO_PROCESS, 0);
  (void)syscall(SYS_sched_setattr, 0, &attributes, 0);
#endif
}

void keep_under_limit(Heap& h) {
  ask_for_short_turns();
  for (;;) {
    const std::uint64_t high = h.resident_limit.load(std::memory_order_relaxed), held = resident_bytes(h.statm).all;
    const std::chrono::microseconds until((high - std::min(high, held)) / kComing);
    std::this_thread::sleep_for(std::clamp(until, kLookAgain, kLookEvery));
    let_go(h);
  }
}

/// Under h.mutex.
bool make_file(Heap& h) {
  if (h.base.load(std::memory_order_relaxed) != nullptr) return true;
  if (h.failed) return false;
  h.failed = true;
  h.file = nameless_file(h.folder);
  if (h.file < 0) {
    refuse(h, "no file for memory can be made here", errno);
    return false;
  }
  h.span = kGreatestSpan;
  while (ftruncate(h.file, static_cast<off_t>(h.span)) != 0) {
    if (h.span <= (1ull << 30)) {
      refuse(h, "no large file can be made here", errno);
      return false;
    }
    h.span /= 2;
  }
  void* mapped = mmap(nullptr, h.span, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_NORESERVE, h.file, 0);
  h.class_of_block = static_cast<std::uint8_t*>(std::calloc(h.span / kBlock, 1));
  if (mapped == MAP_FAILED || h.class_of_block == nullptr) {
    refuse(h, "the file for memory cannot be mapped", errno);
    return false;
  }
  madvise(mapped, h.span, MADV_DONTDUMP);
  // Small pages, one at a time: read-ahead makes pieces of up to 2 MiB, which a single look maps as a whole, so that
  // the limit is reached by a fraction of what was looked at.
  madvise(mapped, h.span, MADV_RANDOM);
  madvise(mapped, h.span, MADV_NOHUGEPAGE);
  madvise(mapped, h.span, MADV_DONTFORK);  // a command that is started must not write into it
  h.statm = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
  mallopt(M_MMAP_THRESHOLD, 1 << 20);  // plain memory is scarce now: what is freed leaves the process
  h.base.store(static_cast<char*>(mapped), std::memory_order_release);
  h.failed = false;
  try {
    std::thread([&h] { keep_under_limit(h); }).detach();
  } catch (...) {
    h.failed = true;
    refuse(h, "no thread that watches the limit can be started", 0);
    return false;
  }
  return true;
}

/// First block of a run with disk space behind it; ~0 when there is none. Under h.mutex.
std::uint64_t take_run(Heap& h, std::uint64_t count) {
  constexpr std::uint64_t kNone = ~0ull;
  if (!make_file(h)) return kNone;
  const std::uint64_t disk = h.disk_limit.load(), after = h.in_file.load() + count * kBlock;
  if (disk > 0 && after > disk) {
    h.at_limit.store(true);
    std::snprintf(h.reason, sizeof h.reason,
                  "%s: memory that does not fit under the cap needs more than the %llu MiB of disk allowed", h.folder,
                  static_cast<unsigned long long>(disk >> 20));
    return kNone;
  }
  std::uint64_t first = kNone;
  for (auto run = h.free_runs.begin(); run != h.free_runs.end(); ++run)
    if (run->second >= count) {
      first = run->first;
      const std::uint64_t rest = run->second - count;
      h.free_runs.erase(run);
      if (rest > 0) h.free_runs.emplace(first + count, rest);
      break;
    }
  if (first == kNone) {
    if (h.blocks + count > h.span / kBlock) {
      refuse(h, "the file for memory has reached its greatest size", 0);
      return kNone;
    }
    first = h.blocks;
    h.blocks += count;
    h.used_blocks.store(h.blocks);
  }
  int error = fallocate(h.file, 0, static_cast<off_t>(first * kBlock), static_cast<off_t>(count * kBlock)) ? errno : 0;
  if (error == EOPNOTSUPP)
    error = posix_fallocate(h.file, static_cast<off_t>(first * kBlock), static_cast<off_t>(count * kBlock));
  if (error != 0) {
    refuse(h, "no space for memory that does not fit under the cap", error);
    h.free_runs.emplace(first, count);
    return kNone;
  }
  h.in_file.store(after);
  h.most_in_file.store(std::max(h.most_in_file.load(), after));
  return first;
}

/// A page of the file that was never written comes with a fault that asks the disk's map for it, four times as dear as
/// one for a page that is at hand. Larger pieces fill over so long a time that what is written ahead of them might have
/// left memory by then. Little at once: the kernel keeps what one call wrote in one piece, and a single look maps all
/// of it.
void write_ahead(const Heap& h, std::uint64_t first, std::uint64_t count) {
  static char none[16 << 10];
  if (count > kMostWrittenAhead) return;
  for (std::uint64_t at = first * kBlock; at < (first + count) * kBlock; at += sizeof none)
    if (pwrite(h.file, none, sizeof none, static_cast<off_t>(at)) != static_cast<ssize_t>(sizeof none)) return;
}

void join_free(Heap& h, std::uint64_t first, std::uint64_t count) {
  auto after = h.free_runs.upper_bound(first);
  if (after != h.free_runs.end() && after->first == first + count) {
    count += after->second;
    after = h.free_runs.erase(after);
  }
  if (after != h.free_runs.begin()) {
    auto before = std::prev(after);
    if (before->first + before->second == first) {
      before->second += count;
      return;
    }
  }
  h.free_runs.emplace(first, count);
}

void* take_large(Heap& h, std::size_t bytes) {
  const std::uint64_t count = (bytes + kBlock - 1) / kBlock;
  std::uint64_t first = 0;
  {
    const std::lock_guard<std::mutex> guard(h.mutex);
    first = take_run(h, count);
    if (first == ~0ull) return nullptr;
    h.taken.emplace(first, count);
    if (count >= kLargeRun) let_go(h);  // before it fills
  }
  write_ahead(h, first, count);
  return h.base.load(std::memory_order_relaxed) + first * kBlock;
}

void* take_small(Heap& h, std::size_t bytes) {
  const int number = class_of(bytes);
  SizeClass& c = h.classes[number];
  const std::lock_guard<std::mutex> guard(c.mutex);
  if (c.free != nullptr) {
    void* piece = c.free;
    std::memcpy(&c.free, piece, sizeof c.free);
    return piece;
  }
  const std::uint32_t size = size_of_class(number);
  if (c.next == nullptr || c.next + size > c.end) {
    const std::lock_guard<std::mutex> runs(h.mutex);
    const std::uint64_t first = take_run(h, 1);
    if (first == ~0ull) return nullptr;
    h.class_of_block[first] = static_cast<std::uint8_t>(number + 1);
    write_ahead(h, first, 1);
    c.next = h.base.load(std::memory_order_relaxed) + first * kBlock;
    c.end = c.next + kBlock;
  }
  void* piece = c.next;
  c.next += size;
  return piece;
}

void give_back_paged(Heap& h, void* piece) {
  const auto at = static_cast<std::uint64_t>(static_cast<char*>(piece) - h.base.load(std::memory_order_relaxed));
  const std::uint64_t block = at / kBlock;
  if (const int number = h.class_of_block[block]) {
    SizeClass& c = h.classes[number - 1];
    const std::lock_guard<std::mutex> guard(c.mutex);
    std::memcpy(piece, &c.free, sizeof c.free);
    c.free = piece;
    return;
  }
  const std::lock_guard<std::mutex> guard(h.mutex);
  const auto run = h.taken.find(block);
  if (run == h.taken.end()) std::abort();  // nobody took this
  const std::uint64_t count = run->second;
  h.taken.erase(run);
  // Also forgets the pages, so that nothing of them is ever written to the disk.
  (void)fallocate(h.file, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, static_cast<off_t>(block * kBlock),
                  static_cast<off_t>(count * kBlock));
  join_free(h, block, count);
  h.in_file.fetch_sub(count * kBlock);
}

void* plain(std::size_t bytes, std::size_t alignment) {
  if (bytes == 0) bytes = 1;
  if (alignment <= alignof(std::max_align_t)) return std::malloc(bytes);
  return std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
}

}  // namespace

void begin(const std::string& folder, const Limits& limits) {
  Heap& h = heap();
  const std::lock_guard<std::mutex> guard(h.mutex);
  std::snprintf(h.folder, sizeof h.folder, "%s", folder.c_str());
  h.plain_limit.store(limits.plain);
  h.resident_limit.store(limits.resident);
  h.disk_limit.store(limits.disk);
  h.reason[0] = 0;
  h.at_limit.store(false);
  h.failed = false;
  g_heap.store(&h, std::memory_order_release);
}

Usage usage() {
  Heap& h = heap();
  return {static_cast<std::uint64_t>(std::max<std::int64_t>(0, h.plain.load())), h.in_file.load(),
          h.most_in_file.load(), h.evictions.load()};
}

std::optional<Room> room() {
  Heap* h = g_heap.load(std::memory_order_relaxed);
  if (h == nullptr) return std::nullopt;
  const std::lock_guard<std::mutex> guard(h->mutex);
  const std::uint64_t plain = static_cast<std::uint64_t>(std::max<std::int64_t>(0, h->plain.load())),
                      in_file = h->in_file.load(), limit = h->disk_limit.load();
  struct statvfs file_system {};
  std::uint64_t disk = statvfs(h->folder, &file_system) == 0
                           ? static_cast<std::uint64_t>(file_system.f_bavail) * file_system.f_frsize
                           : 0;
  if (limit > 0) disk = std::min(disk, limit - std::min(limit, in_file));
  return Room{h->plain_limit.load() - std::min(h->plain_limit.load(), plain), disk};
}

void relieve() {
  Heap* h = g_heap.load(std::memory_order_relaxed);
  if (h != nullptr && h->base.load(std::memory_order_relaxed) != nullptr) let_go(*h);
}

bool limit_was_reached() { return heap().at_limit.load(); }

bool holds(const void* piece) {
  const Heap* h = g_heap.load(std::memory_order_relaxed);
  return h != nullptr && h->holds(piece);
}

std::string refusal() {
  Heap& h = heap();
  const std::lock_guard<std::mutex> guard(h.mutex);
  return h.reason;
}

namespace detail {

void* take(std::size_t bytes, std::size_t alignment) noexcept {
  Heap* h = g_heap.load(std::memory_order_relaxed);
  // What the C library makes of a piece is up to 24 bytes larger, and counts when it is given back.
  if (h == nullptr || bytes + 32 < kLeastPaged || alignment > kLeastPaged) return plain(bytes, alignment);
  const auto size = static_cast<std::int64_t>(bytes);
  if (h->plain.fetch_add(size, std::memory_order_relaxed) + size <=
      static_cast<std::int64_t>(h->plain_limit.load(std::memory_order_relaxed))) {
    void* piece = plain(bytes, alignment);
    // Counted as what the C library will call it when it is given back.
    if (piece != nullptr) {
      h->plain.fetch_add(static_cast<std::int64_t>(malloc_usable_size(piece)) - size, std::memory_order_relaxed);
      return piece;
    }
  }
  h->plain.fetch_sub(size, std::memory_order_relaxed);
  try {
    return bytes >= kLargest ? take_large(*h, bytes) : take_small(*h, bytes);
  } catch (...) {
    return nullptr;
  }
}

void give_back(void* piece) noexcept {
  if (piece == nullptr) return;
  Heap* h = g_heap.load(std::memory_order_relaxed);
  if (h != nullptr) {
    if (h->holds(piece)) return give_back_paged(*h, piece);
    const std::size_t size = malloc_usable_size(piece);
    if (size >= kLeastPaged) h->plain.fetch_sub(static_cast<std::int64_t>(size), std::memory_order_relaxed);
  }
  std::free(piece);
}

}  // namespace detail
}  // namespace scanmill::paged
