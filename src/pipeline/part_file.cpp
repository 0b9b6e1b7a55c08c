// SPDX-License-Identifier: Apache-2.0
#include "pipeline/part_file.hpp"

#include <cstring>
#include <vector>

#include "base/deflate.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

constexpr char kMagic[16] = {'s', 'c', 'a', 'n', 'm', 'i', 'l', 'l', ' ', 'p', 'a', 'r', 't', ' ', '2', '\n'};
constexpr std::size_t kIdentity = 64, kName = 24, kSum = 64;
constexpr std::uint64_t kLargestText = 1ull << 30;
constexpr std::size_t kBlock = 32 << 10;  // bytes of rows that one checksum covers

struct Head {
  char magic[16];
  char identity[kIdentity];
  char name[kName];
  std::uint64_t row_bytes;
};
/// Behind the rows stand the text, the checksums of the blocks, and this.
struct Tail {
  std::uint64_t rows, text_bytes;
  char sum[kSum];  // SHA-256 of all but the rows, hex
};
static_assert(sizeof(Head) == 112 && sizeof(Tail) == 80);

Head head_of(const PartKind& kind) {
  Head head{};
  std::memcpy(head.magic, kMagic, sizeof kMagic);
  std::memcpy(head.identity, kind.identity.data(), std::min(kind.identity.size(), kIdentity));
  std::memcpy(head.name, kind.name.data(), std::min(kind.name.size(), kName));
  head.row_bytes = kind.row_bytes;
  return head;
}

template <class T>
std::span<const char> bytes_of(const T& value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

}  // namespace

Result<PartWriter> PartWriter::create(const std::string& path, const PartKind& kind) {
  PartWriter writer;
  TRY_ASSIGN(writer.sink_, store::create_file(path));
  writer.row_bytes_ = kind.row_bytes;
  const Head head = head_of(kind);
  writer.hash_.add(bytes_of(head));
  TRY(writer.sink_->write(bytes_of(head)));
  return writer;
}

Result<void> PartWriter::add(std::span<const char> rows) {
  for (std::size_t at = 0; at < rows.size();) {
    const std::size_t in_block = static_cast<std::size_t>(bytes_ % kBlock);
    if (in_block == 0) sums_.push_back(0);
    const auto some = rows.subspan(at, std::min(kBlock - in_block, rows.size() - at));
    sums_.back() = crc32_of(sums_.back(), some);
    bytes_ += some.size();
    at += some.size();
  }
  return sink_->write(rows);
}

Result<void> PartWriter::commit(std::string_view text) {
  const std::span<const char> sums(reinterpret_cast<const char*>(sums_.data()), sums_.size() * sizeof(std::uint32_t));
  Tail tail{bytes_ / row_bytes_, text.size(), {}};
  hash_.add(text);
  hash_.add(sums);
  hash_.add(std::span<const char>(reinterpret_cast<const char*>(&tail), offsetof(Tail, sum)));
  const std::string sum = hash_.hex();
  std::memcpy(tail.sum, sum.data(), kSum);
  TRY(sink_->write(text));
  TRY(sink_->write(sums));
  TRY(sink_->write(bytes_of(tail)));
  return sink_->commit();
}

std::optional<PartFile> PartFile::open(const std::string& path, const PartKind& kind) {
  if (!store::exists(path)) return std::nullopt;
  auto source = store::open_file(path, path);
  if (!source) return std::nullopt;
  PartFile file;
  file.source_ = *std::move(source);
  const std::uint64_t size = file.source_->size();
  Head head;
  Tail tail;
  if (size < sizeof head + sizeof tail) return std::nullopt;
  const Head wanted = head_of(kind);
  auto got = file.source_->read_at(0, {reinterpret_cast<char*>(&head), sizeof head});
  if (!got || *got != sizeof head || std::memcmp(&head, &wanted, sizeof head) != 0) return std::nullopt;
  got = file.source_->read_at(size - sizeof tail, {reinterpret_cast<char*>(&tail), sizeof tail});
  if (!got || *got != sizeof tail || tail.text_bytes > kLargestText) return std::nullopt;
  const std::uint64_t behind = size - sizeof head - sizeof tail;
  if (tail.rows > behind / kind.row_bytes) return std::nullopt;
  const std::uint64_t bytes = tail.rows * kind.row_bytes, blocks = (bytes + kBlock - 1) / kBlock;
  if (tail.text_bytes > behind || blocks * sizeof(std::uint32_t) > behind ||
      bytes + tail.text_bytes + blocks * sizeof(std::uint32_t) != behind)
    return std::nullopt;
  file.path_ = path;
  file.row_bytes_ = kind.row_bytes;
  file.rows_ = tail.rows;
  file.text_.resize(tail.text_bytes);
  file.sums_.resize(static_cast<std::size_t>(blocks));
  file.seen_.assign(static_cast<std::size_t>(blocks), 0);
  got = file.source_->read_at(sizeof head + bytes, file.text_);
  if (!got || *got != file.text_.size()) return std::nullopt;
  const std::span<char> sums(reinterpret_cast<char*>(file.sums_.data()), file.sums_.size() * sizeof(std::uint32_t));
  got = file.source_->read_at(sizeof head + bytes + tail.text_bytes, sums);
  if (!got || *got != sums.size()) return std::nullopt;
  Sha256 hash;
  hash.add(bytes_of(head));
  hash.add(std::string_view(file.text_));
  hash.add(std::span<const char>(sums));
  hash.add(std::span<const char>(reinterpret_cast<const char*>(&tail), offsetof(Tail, sum)));
  if (hash.hex() != std::string_view(tail.sum, kSum)) return std::nullopt;
  return file;
}

Result<void> PartFile::read(std::uint64_t first, std::span<char> out) const {
  const std::uint64_t begin = first * row_bytes_, end = begin + out.size(), bytes = rows_ * row_bytes_;
  if (end > bytes) return fail(Code::IoFailed, "ends before row " + std::to_string(end / row_bytes_), source_->name());
  TRY_ASSIGN(const std::size_t got, source_->read_at(sizeof(Head) + begin, out));
  if (got != out.size()) return damaged(begin + got);
  std::vector<char> whole;
  for (std::uint64_t block = begin / kBlock; block * kBlock < end; ++block) {
    if (seen_[block]) continue;
    const std::uint64_t low = block * kBlock, high = std::min(low + kBlock, bytes);
    std::span<const char> rows;
    if (low >= begin && high <= end) {
      rows = out.subspan(static_cast<std::size_t>(low - begin), static_cast<std::size_t>(high - low));
    } else {
      whole.resize(static_cast<std::size_t>(high - low));
      TRY_ASSIGN(const std::size_t there, source_->read_at(sizeof(Head) + low, whole));
      if (there != whole.size()) return damaged(low + there);
      rows = whole;
    }
    if (crc32_of(0, rows) != sums_[block]) return damaged(low);
    seen_[block] = 1;
  }
  return {};
}

/// Nobody believes it any more, and the task that made it finds it gone.
Error PartFile::damaged(std::uint64_t at) const {
  (void)store::remove_tree(path_);
  return fail(
      Code::IoFailed,
      "byte " + std::to_string(sizeof(Head) + at) +
          " and those behind it are not what was written: a fault of the disk; the file was removed, and is made again",
      path_);
}

}  // namespace scanmill::pipeline
