// SPDX-License-Identifier: Apache-2.0
// What a stage may use besides its values: the chunk loop and the cancel flag. No log, no path, no clock, no global.
#pragma once
#include <atomic>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>

namespace scanmill {

/// Non-owning reference to a callable; one indirect call.
template <class Signature>
class FunctionRef;
template <class R, class... Args>
class FunctionRef<R(Args...)> {
 public:
  template <class F, class = std::enable_if_t<!std::is_same_v<std::remove_cvref_t<F>, FunctionRef>>>
  FunctionRef(F&& f)  // NOLINT: by intent
      : object_(const_cast<void*>(static_cast<const void*>(std::addressof(f)))),
        call_([](void* object, Args... args) -> R {
          return (*static_cast<std::remove_reference_t<F>*>(object))(std::forward<Args>(args)...);
        }) {}
  R operator()(Args... args) const { return call_(object_, std::forward<Args>(args)...); }

 private:
  void* object_;
  R (*call_)(void*, Args...);
};

/// Set once, from any thread or a signal handler; read by stages between chunks.
class CancelFlag {
 public:
  void set() { flag_.store(true, std::memory_order_relaxed); }
  bool is_set() const { return flag_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> flag_{false};
};

/// Runs numbered chunks on a fixed number of threads. Which worker gets which chunk is not fixed, so results are stored
/// by chunk number, or combined by a commutative and associative operation on exact values.
class ChunkLoop {
 public:
  /// threads >= 1
  explicit ChunkLoop(int threads);
  ~ChunkLoop();
  ChunkLoop(const ChunkLoop&) = delete;
  ChunkLoop& operator=(const ChunkLoop&) = delete;

  int threads() const;
  /// body(chunk, worker) for every chunk in [0, chunks); worker in [0, threads()), never two at once with the same
  /// number. Exceptions of the body reach the caller.
  void run(std::size_t chunks, FunctionRef<void(std::size_t chunk, int worker)> body) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct Context {
  const ChunkLoop& loop;
  const CancelFlag& cancel;
};

/// body(begin, end) over [0, count) in fixed pieces of `grain`; stops early when cancelled (the caller checks the
/// flag).
void for_each_range(const Context& context, std::size_t count, std::size_t grain,
                    FunctionRef<void(std::size_t begin, std::size_t end)> body);
/// The same with the number of the piece and of the worker.
void for_each_piece(const Context& context, std::size_t count, std::size_t grain,
                    FunctionRef<void(std::size_t begin, std::size_t end, std::size_t piece, int worker)> body);

}  // namespace scanmill
