// SPDX-License-Identifier: Apache-2.0
#include "formats/lzf.hpp"

#include <algorithm>
#include <cstring>

#include "formats/cursor.hpp"

namespace scanmill::formats {
namespace {

constexpr std::size_t kReach = 8192;        // how far back a token may copy
constexpr std::size_t kLongest = 264;       // bytes a token gives at most
constexpr std::size_t kLongestToken = 33;   // bytes of input a token takes at most
constexpr std::size_t kWindow = 1 << 18;    // of decoded bytes held
constexpr std::size_t kInput = 1 << 16;     // of tokens held
constexpr std::uint64_t kStep = 256 << 10;  // between marks

class Decoder {
 public:
  Decoder(const ByteSource& source, std::uint64_t in, std::uint64_t end, std::uint64_t out, std::string_view history)
      : source_(source), in_base_(in), in_end_(end), base_(out - history.size()), window_(kReach + kWindow + kLongest) {
    std::copy(history.begin(), history.end(), window_.begin());
    at_ = history.size();
  }

  std::uint64_t in() const { return in_base_ + in_at_; }
  std::uint64_t out() const { return base_ + at_; }
  bool at_end() const { return in() == in_end_; }
  std::string_view history() const {
    const std::size_t size = std::min(at_, kReach);
    return {window_.data() + at_ - size, size};
  }

  /// Tokens until `limit` bytes of output are there or the input ends. What was decoded since `from` (an offset of the
  /// output) goes to `out`, which may be shorter.
  Result<void> run(std::uint64_t limit, std::uint64_t from, std::span<char> out) {
    std::uint64_t begun = this->out();
    while (this->out() < limit && !at_end()) {
      if (at_ >= kReach + kWindow) {
        keep(begun, from, out);
        slide();
        begun = this->out();
      }
      TRY(token());
    }
    keep(begun, from, out);
    return {};
  }

 private:
  Error broken(const char* what) const {
    return fail(Code::BadInput, std::string("the compressed data is broken: ") + what,
                byte_place(source_.name(), in()));
  }

  Result<void> refill() {
    const std::size_t left = input_.size() - in_at_;
    std::copy(input_.begin() + static_cast<std::ptrdiff_t>(in_at_), input_.end(), input_.begin());
    in_base_ += in_at_;
    in_at_ = 0;
    const auto more = static_cast<std::size_t>(std::min<std::uint64_t>(in_end_ - in_base_ - left, kInput));
    input_.resize(left + more);
    return read_exactly(source_, in_base_ + left, std::span<char>(input_.data() + left, more));
  }

  Result<void> token() {
    if (input_.size() - in_at_ < kLongestToken && in_base_ + input_.size() < in_end_) TRY(refill());
    const auto* p = reinterpret_cast<const unsigned char*>(input_.data()) + in_at_;
    const std::size_t have = input_.size() - in_at_;
    const std::size_t head = p[0];
    char* const to = window_.data() + at_;
    if (head < 32) {
      const std::size_t size = head + 1;
      if (have < 1 + size) return broken("a run of bytes goes past its end");
      std::memcpy(to, p + 1, size);
      in_at_ += 1 + size;
      at_ += size;
      return {};
    }
    std::size_t size = head >> 5, taken = 2;
    if (size == 7) taken = 3;
    if (have < taken) return broken("a token is cut");
    if (size == 7) size += p[1];
    size += 2;
    const std::size_t distance = ((head & 31) << 8) + p[taken - 1] + 1;
    if (distance > at_) return broken("a token copies from before the beginning");
    const char* const copied = to - distance;
    if (distance >= size)
      std::memcpy(to, copied, size);
    else
      for (std::size_t i = 0; i < size; ++i) to[i] = copied[i];  // the copy feeds itself
    in_at_ += taken;
    at_ += size;
    return {};
  }

  void keep(std::uint64_t begun, std::uint64_t from, std::span<char> out) const {
    const std::uint64_t low = std::max(begun, from), high = std::min(this->out(), from + out.size());
    if (low < high)
      std::memcpy(out.data() + (low - from), window_.data() + (low - base_), static_cast<std::size_t>(high - low));
  }

  void slide() {
    const std::size_t gone = at_ - kReach;
    std::memmove(window_.data(), window_.data() + gone, kReach);
    base_ += gone;
    at_ = kReach;
  }

  const ByteSource& source_;
  std::uint64_t in_base_, in_end_;
  std::size_t in_at_ = 0;
  std::vector<char> input_;
  std::uint64_t base_;  // place of window_[0] in the output
  std::vector<char> window_;
  std::size_t at_ = 0;
};

}  // namespace

Result<LzfStream> index_lzf(const ByteSource& source, std::uint64_t begin, std::uint64_t compressed,
                            std::uint64_t size) {
  LzfStream stream{begin, begin + compressed, size, {}};
  Decoder decoder(source, begin, stream.end, 0, {});
  for (;;) {
    stream.marks.push_back({decoder.in(), decoder.out(), std::string(decoder.history())});
    if (decoder.out() >= size || decoder.at_end()) break;
    TRY(decoder.run(std::min(size, decoder.out() + kStep), 0, {}));
  }
  if (decoder.out() == size && decoder.at_end()) return stream;
  return fail(Code::BadInput,
              decoder.out() < size
                  ? "the compressed data ends after " + std::to_string(decoder.out()) +
                        " decoded bytes, declared are " + std::to_string(size) + "; it was cut or the sizes are wrong"
                  : "the compressed data gives more than the " + std::to_string(size) + " bytes declared",
              byte_place(source.name(), decoder.in()));
}

Result<void> read_lzf(const ByteSource& source, const LzfStream& stream, std::uint64_t from, std::span<char> out) {
  const auto behind = std::upper_bound(stream.marks.begin(), stream.marks.end(), from,
                                       [](std::uint64_t place, const LzfMark& mark) { return place < mark.out; });
  const LzfMark& mark = *(behind - 1);
  Decoder decoder(source, mark.in, stream.end, mark.out, mark.history);
  TRY(decoder.run(from + out.size(), from, out));
  if (decoder.out() < from + out.size())
    return fail(Code::IoFailed, "the file changed while it was read", byte_place(source.name(), decoder.in()));
  return {};
}

}  // namespace scanmill::formats
