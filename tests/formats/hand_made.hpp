// SPDX-License-Identifier: Apache-2.0
// Files built byte by byte, and what every reader must bear.
#pragma once
#include <gtest/gtest.h>

#include <cstring>
#include <initializer_list>
#include <string>

#include "base/random.hpp"
#include "formats/read_whole.hpp"

namespace scanmill::formats {

/// The bytes of a number as the machine (little-endian) holds it.
template <class T>
std::string raw(T value) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return bytes;
}

template <class T>
std::string raw(std::initializer_list<T> values) {
  std::string bytes;
  for (const T value : values) bytes += raw(value);
  return bytes;
}

/// Puts a number into bytes.
template <class T>
void put(std::string& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

inline void expect_sound(const Result<std::vector<Whole>>& scans, const std::string& name, const std::string& what) {
  if (scans.ok()) return;
  const Error& error = scans.error();
  EXPECT_TRUE(error.code == Code::BadInput || error.code == Code::Unsupported) << what << ": " << error.text();
  EXPECT_NE(error.where.find(name), std::string::npos) << what << ": " << error.text();
}

/// Cut at every byte the file gives points or an error that names it; where `from` says so, an error for sure.
inline void expect_bears_cuts(const std::string& name, const std::string& bytes, const OpenOptions& options,
                              std::size_t fails_below) {
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto scans = read_scans(name, bytes.substr(0, size), options);
    expect_sound(scans, name, "cut at " + std::to_string(size));
    EXPECT_FALSE(scans.ok() && size < fails_below) << "cut at " << size;
  }
}

/// Random bytes, cuts, repeats and large numbers.
inline void expect_bears_damage(const std::string& name, const std::string& bytes, const OpenOptions& options,
                                std::uint64_t rounds) {
  const std::string pieces[] = {"4294967296",        "-1", "\n", "\r", " ", "nan", "1e999", std::string(4, '\xff'),
                                std::string(8, '\0')};
  for (std::uint64_t round = 0; round < rounds; ++round) {
    Random random(7, round, 3);
    std::string damaged = bytes;
    for (std::uint64_t change = 0; change <= random.next() % 3; ++change) {
      const std::size_t at = random.next() % (damaged.size() + 1);
      const std::string& piece = pieces[random.next() % std::size(pieces)];
      switch (random.next() % 5) {
        case 0:
          if (at < damaged.size()) damaged[at] = static_cast<char>(random.next());
          break;
        case 1:
          damaged.erase(at, random.next() % 5);
          break;
        case 2:
          damaged.insert(at, piece);
          break;
        case 3:
          damaged.replace(at, std::min(piece.size(), damaged.size() - at), piece);
          break;
        default:
          damaged.insert(at, damaged.substr(at, random.next() % 20));
      }
    }
    expect_sound(read_scans(name, damaged, options), name, "round " + std::to_string(round));
  }
}

}  // namespace scanmill::formats
