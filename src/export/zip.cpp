// SPDX-License-Identifier: Apache-2.0
// ZIP (PKWARE APPNOTE 6.3): local header and data per part, then the central directory and its end record.
#include "export/zip.hpp"

#include "base/deflate.hpp"
#include "base/text.hpp"
#include "export/little_endian.hpp"

namespace scanmill::exporting {
namespace {

constexpr int kLevel = 6;
constexpr std::uint64_t kLargest = 0xfffffffeull;  // what 32 bits hold; all ones would mean ZIP64
constexpr std::uint16_t kVersion = 20, kUtf8Names = 0x0800, kDeflated = 8;
constexpr std::uint16_t kNoTime = 0, kFirstDay = 0x0021;  // 1980-01-01: the earliest that the format can say

template <class T>
void add(std::string& out, T value) {
  char bytes[sizeof(T)];
  put(bytes, value);
  out.append(bytes, sizeof(T));
}

class DeflatingSink final : public ByteSink {
 public:
  DeflatingSink(std::string name, Deflater deflater) : name_(std::move(name)), deflater_(std::move(deflater)) {}
  const std::string& name() const override { return name_; }
  using ByteSink::write;
  Result<void> write(std::span<const char> bytes) override {
    crc_ = crc32_of(crc_, bytes);
    size_ += bytes.size();
    return deflater_.add(bytes, compressed_);
  }
  Result<void> commit() override { return deflater_.finish(compressed_); }
  std::uint32_t crc() const { return crc_; }
  std::uint64_t size() const { return size_; }
  const std::string& compressed() const { return compressed_; }

 private:
  std::string name_, compressed_;
  Deflater deflater_;
  std::uint32_t crc_ = 0;
  std::uint64_t size_ = 0;
};

}  // namespace

Result<void> ZipWriter::add(const std::string& name, const std::function<Result<void>(ByteSink&)>& fill) {
  TRY_ASSIGN(Deflater deflater, Deflater::begin(Wrapping::None, kLevel));
  DeflatingSink part(sink_.name() + ": " + name, std::move(deflater));
  TRY(fill(part));
  TRY(part.commit());
  if (part.size() > kLargest || written_ + part.compressed().size() > kLargest)
    return fail(Code::Unsupported,
                "takes " + bytes_text(part.size()) + "; a ZIP part holds 4 GiB: choose a larger bin, or stl or ply",
                part.name());
  parts_.push_back({name, part.crc(), static_cast<std::uint32_t>(part.compressed().size()),
                    static_cast<std::uint32_t>(part.size()), static_cast<std::uint32_t>(written_)});
  const Part& entry = parts_.back();
  std::string header;
  exporting::add(header, std::uint32_t{0x04034b50});
  for (const std::uint16_t field : {kVersion, kUtf8Names, kDeflated, kNoTime, kFirstDay}) exporting::add(header, field);
  for (const std::uint32_t field : {entry.crc, entry.compressed, entry.size}) exporting::add(header, field);
  exporting::add(header, static_cast<std::uint16_t>(name.size()));
  exporting::add(header, std::uint16_t{0});
  header += name;
  TRY(sink_.write(std::string_view(header)));
  TRY(sink_.write(std::string_view(part.compressed())));
  written_ += header.size() + part.compressed().size();
  return {};
}

Result<void> ZipWriter::finish() {
  std::string directory;
  for (const Part& entry : parts_) {
    exporting::add(directory, std::uint32_t{0x02014b50});
    for (const std::uint16_t field : {kVersion, kVersion, kUtf8Names, kDeflated, kNoTime, kFirstDay})
      exporting::add(directory, field);
    for (const std::uint32_t field : {entry.crc, entry.compressed, entry.size}) exporting::add(directory, field);
    exporting::add(directory, static_cast<std::uint16_t>(entry.name.size()));
    for (int zero = 0; zero < 4; ++zero) exporting::add(directory, std::uint16_t{0});  // extra, comment, disk, inside
    exporting::add(directory, std::uint32_t{0});                                       // outside attributes
    exporting::add(directory, entry.offset);
    directory += entry.name;
  }
  const auto count = static_cast<std::uint16_t>(parts_.size());
  std::string end;
  exporting::add(end, std::uint32_t{0x06054b50});
  for (const std::uint16_t field : {std::uint16_t{0}, std::uint16_t{0}, count, count}) exporting::add(end, field);
  exporting::add(end, static_cast<std::uint32_t>(directory.size()));
  exporting::add(end, static_cast<std::uint32_t>(written_));
  exporting::add(end, std::uint16_t{0});
  return sink_.write(std::string_view(directory + end));
}

}  // namespace scanmill::exporting
