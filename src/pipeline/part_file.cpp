// SPDX-License-Identifier: Apache-2.0
#include "pipeline/part_file.hpp"

#include <cstring>
#include <vector>

#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

constexpr char kMagic[16] = {'s', 'c', 'a', 'n', 'm', 'i', 'l', 'l', ' ', 'p', 'a', 'r', 't', ' ', '1', '\n'};
constexpr std::size_t kIdentity = 64, kName = 24, kSum = 64;
constexpr std::uint64_t kLargestText = 1ull << 30;

struct Head {
  char magic[16];
  char identity[kIdentity];
  char name[kName];
  std::uint64_t row_bytes;
};
struct Tail {
  std::uint64_t rows, text_bytes;
  char sum[kSum];
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
  hash_.add(rows);
  bytes_ += rows.size();
  return sink_->write(rows);
}

Result<void> PartWriter::commit(std::string_view text) {
  hash_.add(text);
  TRY(sink_->write(text));
  Tail tail{bytes_ / row_bytes_, text.size(), {}};
  hash_.add(std::span<const char>(reinterpret_cast<const char*>(&tail), offsetof(Tail, sum)));
  const std::string sum = hash_.hex();
  std::memcpy(tail.sum, sum.data(), kSum);
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
  const std::uint64_t body = size - sizeof head - sizeof tail;
  if (tail.text_bytes > body || tail.rows != (body - tail.text_bytes) / kind.row_bytes ||
      (body - tail.text_bytes) % kind.row_bytes != 0)
    return std::nullopt;
  file.row_bytes_ = kind.row_bytes;
  file.rows_ = tail.rows;
  file.sum_.assign(tail.sum, kSum);
  file.text_.resize(tail.text_bytes);
  got = file.source_->read_at(size - sizeof tail - tail.text_bytes, file.text_);
  if (!got || *got != file.text_.size()) return std::nullopt;
  return file;
}

Result<void> PartFile::read(std::uint64_t first, std::span<char> out) const {
  TRY_ASSIGN(const std::size_t got, source_->read_at(sizeof(Head) + first * row_bytes_, out));
  if (got != out.size())
    return fail(Code::IoFailed, "ends before row " + std::to_string(first + out.size() / row_bytes_), source_->name());
  return {};
}

Result<bool> PartFile::is_sound() const {
  Sha256 hash;
  std::vector<char> buffer(1 << 20);
  const std::uint64_t end = source_->size() - kSum;
  for (std::uint64_t at = 0; at < end;) {
    const std::size_t wanted = static_cast<std::size_t>(std::min<std::uint64_t>(buffer.size(), end - at));
    TRY_ASSIGN(const std::size_t got, source_->read_at(at, std::span(buffer).first(wanted)));
    if (got != wanted) return false;
    hash.add(std::span<const char>(buffer.data(), got));
    at += got;
  }
  return hash.hex() == sum_;
}

}  // namespace scanmill::pipeline
