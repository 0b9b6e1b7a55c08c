// SPDX-License-Identifier: Apache-2.0
// ZIP (PKWARE APPNOTE 6.3): local header and data per part, then the central directory and its end record. Where 32
// bits do not hold a size or an offset, the fields of ZIP64 (4.5.3).
#include "export/zip.hpp"

#include <algorithm>
#include <initializer_list>

#include "base/deflate.hpp"
#include "export/little_endian.hpp"

namespace scanmill::exporting {
namespace {

constexpr int kLevel = 6;
constexpr std::uint32_t kInExtra = 0xffffffffu;  // the value stands in the ZIP64 field, 64 bits wide
constexpr std::uint16_t kVersion = 20, kVersion64 = 45, kUtf8Names = 0x0800, kDeflated = 8, kExtra64 = 1;
constexpr std::uint16_t kNoTime = 0, kFirstDay = 0x0021;  // 1980-01-01: the earliest that the format can say

template <class T>
void add(std::string& out, T value) {
  char bytes[sizeof(T)];
  put(bytes, value);
  out.append(bytes, sizeof(T));
}

/// Compresses what is written: to another sink, or into memory as long as it is no more than `most`; counts it anyway.
class DeflatingSink final : public ByteSink {
 public:
  DeflatingSink(std::string name, Deflater deflater, std::size_t most, ByteSink* onward)
      : name_(std::move(name)), deflater_(std::move(deflater)), most_(most), onward_(onward) {}
  const std::string& name() const override { return name_; }
  using ByteSink::write;
  Result<void> write(std::span<const char> bytes) override {
    crc_ = crc32_of(crc_, bytes);
    size_ += bytes.size();
    TRY(deflater_.add(bytes, ready_));
    return hand_on();
  }
  Result<void> commit() override {
    TRY(deflater_.finish(ready_));
    return hand_on();
  }
  std::uint32_t crc() const { return crc_; }
  std::uint64_t size() const { return size_; }
  std::uint64_t compressed_size() const { return compressed_size_; }
  /// Nothing when it was too much.
  const std::string* compressed() const { return compressed_size_ <= most_ ? &compressed_ : nullptr; }

 private:
  Result<void> hand_on() {
    compressed_size_ += ready_.size();
    if (onward_) {
      TRY(onward_->write(std::string_view(ready_)));
    } else if (compressed_size_ <= most_) {
      compressed_ += ready_;
    } else {
      compressed_ = std::string();
    }
    ready_.clear();
    return {};
  }

  std::string name_, ready_, compressed_;
  Deflater deflater_;
  std::size_t most_;
  ByteSink* onward_;
  std::uint32_t crc_ = 0;
  std::uint64_t size_ = 0, compressed_size_ = 0;
};

void add_fields(std::string& out, std::initializer_list<std::uint16_t> fields) {
  for (const std::uint16_t field : fields) add(out, field);
}

}  // namespace

Result<void> ZipWriter::add(const std::string& name, const std::function<Result<void>(ByteSink&)>& fill) {
  const std::string shown = sink_.name() + ": " + name;
  TRY_ASSIGN(Deflater deflater, Deflater::begin(Wrapping::None, kLevel));
  DeflatingSink part(shown, std::move(deflater), limits_.in_memory, nullptr);
  TRY(fill(part));
  TRY(part.commit());
  Part entry{name, part.crc(), part.compressed_size(), part.size(), written_, false};
  entry.wide = std::max({entry.compressed, entry.size, entry.offset}) > limits_.narrow;
  parts_.push_back(entry);
  std::string header;
  exporting::add(header, std::uint32_t{0x04034b50});
  add_fields(header, {entry.wide ? kVersion64 : kVersion, kUtf8Names, kDeflated, kNoTime, kFirstDay});
  exporting::add(header, entry.crc);
  exporting::add(header, entry.wide ? kInExtra : static_cast<std::uint32_t>(entry.compressed));
  exporting::add(header, entry.wide ? kInExtra : static_cast<std::uint32_t>(entry.size));
  exporting::add(header, static_cast<std::uint16_t>(name.size()));
  exporting::add(header, static_cast<std::uint16_t>(entry.wide ? 20 : 0));
  header += name;
  if (entry.wide) {
    add_fields(header, {kExtra64, 16});
    exporting::add(header, entry.size);
    exporting::add(header, entry.compressed);
  }
  TRY(sink_.write(std::string_view(header)));
  written_ += header.size() + entry.compressed;
  if (const std::string* compressed = part.compressed()) return sink_.write(std::string_view(*compressed));
  TRY_ASSIGN(Deflater again, Deflater::begin(Wrapping::None, kLevel));
  DeflatingSink second(shown, std::move(again), 0, &sink_);
  TRY(fill(second));
  TRY(second.commit());
  if (second.crc() == entry.crc && second.compressed_size() == entry.compressed) return {};
  return fail(Code::Internal, "the part was not the same when it was made again; please report this", shown);
}

Result<void> ZipWriter::finish() {
  std::string directory;
  for (const Part& entry : parts_) {
    exporting::add(directory, std::uint32_t{0x02014b50});
    const std::uint16_t version = entry.wide ? kVersion64 : kVersion;
    add_fields(directory, {version, version, kUtf8Names, kDeflated, kNoTime, kFirstDay});
    exporting::add(directory, entry.crc);
    exporting::add(directory, entry.wide ? kInExtra : static_cast<std::uint32_t>(entry.compressed));
    exporting::add(directory, entry.wide ? kInExtra : static_cast<std::uint32_t>(entry.size));
    exporting::add(directory, static_cast<std::uint16_t>(entry.name.size()));
    exporting::add(directory, static_cast<std::uint16_t>(entry.wide ? 28 : 0));
    add_fields(directory, {0, 0, 0});             // comment, disk, inside attributes
    exporting::add(directory, std::uint32_t{0});  // outside attributes
    exporting::add(directory, entry.wide ? kInExtra : static_cast<std::uint32_t>(entry.offset));
    directory += entry.name;
    if (!entry.wide) continue;
    add_fields(directory, {kExtra64, 24});
    for (const std::uint64_t field : {entry.size, entry.compressed, entry.offset}) exporting::add(directory, field);
  }
  const std::uint64_t count = parts_.size();
  const bool wide = written_ > limits_.narrow;
  std::string end;
  if (wide) {
    exporting::add(end, std::uint32_t{0x06064b50});
    exporting::add(end, std::uint64_t{44});  // of this record, behind here
    add_fields(end, {kVersion64, kVersion64});
    for (int disk = 0; disk < 2; ++disk) exporting::add(end, std::uint32_t{0});
    for (const std::uint64_t field : {count, count, std::uint64_t{directory.size()}, written_})
      exporting::add(end, field);
    exporting::add(end, std::uint32_t{0x07064b50});
    exporting::add(end, std::uint32_t{0});
    exporting::add(end, written_ + directory.size());
    exporting::add(end, std::uint32_t{1});  // disks
  }
  exporting::add(end, std::uint32_t{0x06054b50});
  add_fields(end, {0, 0, static_cast<std::uint16_t>(count), static_cast<std::uint16_t>(count)});
  exporting::add(end, static_cast<std::uint32_t>(directory.size()));
  exporting::add(end, wide ? kInExtra : static_cast<std::uint32_t>(written_));
  exporting::add(end, std::uint16_t{0});
  return sink_.write(std::string_view(directory + end));
}

}  // namespace scanmill::exporting
