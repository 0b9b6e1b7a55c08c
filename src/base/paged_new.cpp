// SPDX-License-Identifier: Apache-2.0
// The global operators of a program that takes its memory from base/paged_memory.hpp. Sanitizers bring their own.
#include <cstdlib>
#include <new>

#include "base/paged_memory.hpp"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {

void* take_or_throw(std::size_t bytes, std::size_t alignment) {
  if (void* piece = scanmill::paged::detail::take(bytes, alignment)) return piece;
  throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t bytes) { return take_or_throw(bytes, __STDCPP_DEFAULT_NEW_ALIGNMENT__); }
void* operator new[](std::size_t bytes) { return take_or_throw(bytes, __STDCPP_DEFAULT_NEW_ALIGNMENT__); }
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return take_or_throw(bytes, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t bytes, std::align_val_t alignment) {
  return take_or_throw(bytes, static_cast<std::size_t>(alignment));
}
void operator delete(void* piece) noexcept { scanmill::paged::detail::give_back(piece); }
void operator delete[](void* piece) noexcept { scanmill::paged::detail::give_back(piece); }
void operator delete(void* piece, std::size_t) noexcept { scanmill::paged::detail::give_back(piece); }
void operator delete[](void* piece, std::size_t) noexcept { scanmill::paged::detail::give_back(piece); }
void operator delete(void* piece, std::align_val_t) noexcept { scanmill::paged::detail::give_back(piece); }
void operator delete[](void* piece, std::align_val_t) noexcept { scanmill::paged::detail::give_back(piece); }
void operator delete(void* piece, std::size_t, std::align_val_t) noexcept { scanmill::paged::detail::give_back(piece); }
void operator delete[](void* piece, std::size_t, std::align_val_t) noexcept {
  scanmill::paged::detail::give_back(piece);
}

#endif
