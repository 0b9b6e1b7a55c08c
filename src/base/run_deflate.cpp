// SPDX-License-Identifier: Apache-2.0
// RFC 1951, blocks with codes of their own. Tokens are single bytes and runs of the byte before (distance 1).
#include "base/run_deflate.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

namespace scanmill {
namespace {

constexpr std::size_t kTokensPerBlock = 32768;
constexpr std::size_t kLeastRun = 4, kLongestRun = 258;  // three bytes of a run seldom cost more than its code
constexpr std::size_t kEnd = 256, kCodes = 286, kLengthCodes = 19;
constexpr int kLongestCode = 15, kLongestLengthCode = 7;

/// Least bit first.
class Bits {
 public:
  explicit Bits(std::string& out) : out_(out) {}
  void put(std::uint64_t value, int count) {
    held_ |= value << have_;
    have_ += count;
    if (have_ < 32) return;
    char four[4];
    for (int i = 0; i < 4; ++i) four[i] = static_cast<char>(held_ >> (8 * i) & 0xff);
    out_.append(four, 4);
    held_ >>= 32;
    have_ -= 32;
  }
  void end() {
    for (; have_ > 0; have_ -= 8, held_ >>= 8) out_.push_back(static_cast<char>(held_ & 0xff));
    have_ = 0;
  }

 private:
  std::string& out_;
  std::uint64_t held_ = 0;
  int have_ = 0;
};

struct Code {
  std::uint16_t bits = 0;  // reversed, as they are written
  std::uint8_t length = 0;
};

/// Lengths of a Huffman code; of equal weights the lower number counts as lighter. False when one is beyond `most`.
bool code_lengths(std::span<const std::uint32_t> weights, int most, std::vector<Code>& codes) {
  struct Tree {
    std::uint64_t weight;
    int left, right;
  };
  std::vector<Tree> trees;
  std::vector<int> symbol;
  for (std::size_t n = 0; n < weights.size(); ++n)
    if (weights[n] > 0) {
      trees.push_back({weights[n], -1, -1});
      symbol.push_back(static_cast<int>(n));
    }
  const std::size_t leaves = trees.size();
  std::vector<int> order(leaves);
  for (std::size_t n = 0; n < leaves; ++n) order[n] = static_cast<int>(n);
  const auto weight = [&](int n) { return trees[static_cast<std::size_t>(n)].weight; };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return weight(a) < weight(b); });
  // Two queues, leaves and joined ones, both ascending.
  std::size_t leaf = 0, joined = leaves;
  const auto lightest = [&] {
    if (leaf < leaves && (joined == trees.size() || weight(order[leaf]) <= trees[joined].weight)) return order[leaf++];
    return static_cast<int>(joined++);
  };
  for (std::size_t n = 1; n < leaves; ++n) {
    const int a = lightest(), b = lightest();
    trees.push_back({weight(a) + weight(b), a, b});
  }
  std::vector<int> depth(trees.size(), 0);
  codes.assign(weights.size(), {});
  for (std::size_t n = trees.size(); n-- > 0;) {
    if (n < leaves) {
      if (depth[n] > most) return false;
      codes[static_cast<std::size_t>(symbol[n])].length = static_cast<std::uint8_t>(depth[n]);
      continue;
    }
    depth[static_cast<std::size_t>(trees[n].left)] = depth[static_cast<std::size_t>(trees[n].right)] = depth[n] + 1;
  }
  return true;
}

/// At least two of the weights are positive. Where codes come out too long, weights are evened.
std::vector<Code> codes_of(std::vector<std::uint32_t> weights, int most) {
  std::vector<Code> codes;
  while (!code_lengths(weights, most, codes))
    for (std::uint32_t& weight : weights) weight = weight > 0 ? weight / 2 + 1 : 0;
  std::array<std::uint32_t, kLongestCode + 2> count{}, next{};
  for (const Code& code : codes) ++count[code.length];
  count[0] = 0;
  for (int length = 1; length <= most; ++length)
    next[static_cast<std::size_t>(length) + 1] =
        (next[static_cast<std::size_t>(length)] + count[static_cast<std::size_t>(length)]) << 1;
  for (Code& code : codes) {
    if (code.length == 0) continue;
    std::uint32_t value = next[code.length]++;
    for (int bit = 0; bit < code.length; ++bit, value >>= 1)
      code.bits = static_cast<std::uint16_t>(code.bits << 1 | (value & 1));
  }
  return codes;
}

/// Code, extra bits and their value of a run's length.
struct LengthCode {
  std::uint16_t code;
  std::uint8_t extra_bits, extra;
};
std::array<LengthCode, kLongestRun + 1> length_codes() {
  std::array<LengthCode, kLongestRun + 1> table{};
  std::size_t length = 3;
  for (std::uint16_t code = 257; code < 285; ++code) {
    const int extra = code < 265 ? 0 : (code - 261) / 4;
    for (unsigned value = 0; value < 1u << extra && length <= kLongestRun; ++value)
      table[length++] = {code, static_cast<std::uint8_t>(extra), static_cast<std::uint8_t>(value)};
  }
  table[kLongestRun] = {285, 0, 0};
  return table;
}

/// As many bytes from `at` on as equal the one before it, 258 at most.
std::size_t run_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  const std::uint8_t byte = bytes[at - 1];
  const std::size_t end = std::min(bytes.size(), at + kLongestRun);
  std::size_t n = at;
  const std::uint64_t eight = 0x0101010101010101ull * byte;
  for (std::uint64_t next = 0; n + 8 <= end; n += 8) {
    std::memcpy(&next, &bytes[n], 8);
    if (next != eight) break;
  }
  while (n < end && bytes[n] == byte) ++n;
  return n - at;
}

/// A byte, or 256 + the length of a run.
using Token = std::uint16_t;

void write_block(std::span<const Token> tokens, bool last, Bits& out) {
  static const auto kLengths = length_codes();
  std::vector<std::uint32_t> weights(kCodes, 0);
  for (const Token token : tokens) ++weights[token < 256 ? token : kLengths[token - 256u].code];
  weights[kEnd] = 1;
  if (tokens.empty()) weights[0] = 1;
  const std::vector<Code> codes = codes_of(weights, kLongestCode);
  std::vector<std::uint32_t> length_weights(kLengthCodes, 0);
  for (const Code& code : codes) ++length_weights[code.length];
  ++length_weights[1];  // of the one distance
  length_weights[0] = std::max(length_weights[0], 1u);
  const std::vector<Code> lengths = codes_of(length_weights, kLongestLengthCode);
  static constexpr int kOrder[kLengthCodes] = {16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15};
  out.put(last, 1);
  out.put(2, 2);
  out.put(kCodes - 257, 5);
  out.put(0, 5);
  out.put(kLengthCodes - 4, 4);
  for (const int n : kOrder) out.put(lengths[static_cast<std::size_t>(n)].length, 3);
  for (const Code& code : codes) out.put(lengths[code.length].bits, lengths[code.length].length);
  out.put(lengths[1].bits, lengths[1].length);
  for (const Token token : tokens) {
    if (token < 256) {
      out.put(codes[token].bits, codes[token].length);
      continue;
    }
    const LengthCode& run = kLengths[token - 256u];
    out.put(codes[run.code].bits, codes[run.code].length);
    out.put(run.extra, run.extra_bits + 1);  // and the distance, a zero bit
  }
  out.put(codes[kEnd].bits, codes[kEnd].length);
}

/// RFC 1950: so many sums fit 32 bits before the remainder is due.
std::uint32_t adler32_of(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kAtOnce = 5552;
  constexpr std::uint32_t kPrime = 65521;
  std::uint32_t a = 1, b = 0;
  for (std::size_t at = 0; at < bytes.size(); at += kAtOnce) {
    for (const std::uint8_t byte : bytes.subspan(at, std::min(kAtOnce, bytes.size() - at))) {
      a += byte;
      b += a;
    }
    a %= kPrime;
    b %= kPrime;
  }
  return b << 16 | a;
}

}  // namespace

std::string run_deflated(std::span<const std::uint8_t> bytes) {
  std::string out("\x78\x01", 2);
  Bits bits(out);
  std::vector<Token> tokens;
  tokens.reserve(kTokensPerBlock);
  std::size_t at = 0;
  do {
    tokens.clear();
    while (at < bytes.size() && tokens.size() < kTokensPerBlock) {
      const std::size_t run = at > 0 && bytes[at] == bytes[at - 1] ? run_at(bytes, at) : 0;
      if (run >= kLeastRun) {
        tokens.push_back(static_cast<Token>(256 + run));
        at += run;
      } else {
        tokens.push_back(bytes[at++]);
      }
    }
    write_block(tokens, at == bytes.size(), bits);
  } while (at < bytes.size());
  bits.end();
  const std::uint32_t sum = adler32_of(bytes);
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<char>(sum >> shift & 0xff));
  return out;
}

}  // namespace scanmill
