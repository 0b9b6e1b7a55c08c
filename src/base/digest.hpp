// SPDX-License-Identifier: Apache-2.0
// SHA-256 for content and records; a 64-bit mixer for ties. The wall around OpenSSL is digest.cpp.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "base/bytes.hpp"

namespace scanmill {

class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;
  void add(std::span<const char> bytes);
  void add(std::string_view text) { add(std::span<const char>(text.data(), text.size())); }
  /// Lower-case hex; the object is spent afterwards.
  std::string hex();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

std::string sha256_hex(std::string_view text);
Result<std::string> sha256_of(const ByteSource& source);

/// A fixed 64-bit mixing function (splitmix64's finaliser); the same on every platform.
constexpr std::uint64_t mix64(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

}  // namespace scanmill
