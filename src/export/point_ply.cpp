// SPDX-License-Identifier: Apache-2.0
#include "base/text.hpp"
#include "export/little_endian.hpp"
#include "export/writers.hpp"

namespace scanmill::exporting {
namespace {

constexpr std::size_t kBufferBytes = 1 << 18;
constexpr std::size_t kRecordBytes = 3 * sizeof(double) + sizeof(std::uint32_t) + sizeof(double);
constexpr std::size_t kViewRecordBytes = 3 * sizeof(float);

/// A comment is one line of printable text, whatever it was made from (file names may hold anything).
std::string comment_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return "comment " + text + "\n";
}

std::string header(std::uint64_t count, std::span<const std::string> comments, std::string_view properties) {
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& comment : comments) text += comment_line(comment);
  text += "element vertex " + std::to_string(count) + "\n";
  text += properties;
  return text + "end_header\n";
}

}  // namespace

Result<void> write_view_ply(std::span<const Vec3> points, std::span<const std::string> comments, ByteSink& sink) {
  auto is_measured = [](Vec3 p) { return !(std::isnan(p.x) || std::isnan(p.y) || std::isnan(p.z)); };
  std::uint64_t count = 0;
  for (const Vec3& p : points) count += is_measured(p);
  const std::string head = header(count, comments, "property float x\nproperty float y\nproperty float z\n");
  TRY(sink.write(std::string_view(head)));
  std::vector<char> buffer(kBufferBytes - kBufferBytes % kViewRecordBytes);
  char* at = buffer.data();
  for (const Vec3& p : points) {
    if (!is_measured(p)) continue;
    for (const double value : {p.x, p.y, p.z}) at = put(at, without_minus_zero(static_cast<float>(value)));
    if (at == buffer.data() + buffer.size()) {
      TRY(sink.write(std::span<const char>(buffer)));
      at = buffer.data();
    }
  }
  return sink.write(std::span<const char>(buffer.data(), at));
}

Result<PlyPointWriter> PlyPointWriter::begin(ByteSink& sink, std::uint64_t count,
                                             std::span<const std::string> comments) {
  const std::string head = header(count, comments,
                                  "property double x\nproperty double y\nproperty double z\n"
                                  "property uint view\nproperty double row\n");
  TRY(sink.write(std::string_view(head)));
  return PlyPointWriter(sink, count);
}

Result<void> PlyPointWriter::add(const PointBlock& block) {
  const std::size_t n = block.positions.size();
  if (block.rows.size() != n)
    return fail(Code::Internal,
                "a block of " + grouped(n) + " points has " + grouped(block.rows.size()) + " source rows",
                sink_->name());
  if (n > announced_ - written_)
    return fail(Code::Internal,
                "more than the " + grouped(announced_) + " points that the header announces came to be written",
                sink_->name());
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 p = block.positions[i];
    const std::size_t used = buffer_.size();
    buffer_.resize(used + kRecordBytes);
    char* at = buffer_.data() + used;
    for (const double value : {p.x, p.y, p.z}) at = put(at, without_minus_zero(value));
    at = put(at, index_of(block.view));
    put(at, static_cast<double>(block.rows[i]));
    if (buffer_.size() >= kBufferBytes) {
      TRY(sink_->write(std::span<const char>(buffer_)));
      buffer_.clear();
    }
  }
  written_ += n;
  return {};
}

Result<void> PlyPointWriter::finish() {
  if (written_ != announced_)
    return fail(Code::Internal,
                "only " + grouped(written_) + " of the " + grouped(announced_) +
                    " points that the header announces came to be written",
                sink_->name());
  TRY(sink_->write(std::span<const char>(buffer_)));
  buffer_.clear();
  return {};
}

}  // namespace scanmill::exporting
