// SPDX-License-Identifier: Apache-2.0
// Binary STL: 80 bytes of header, a 32-bit count, and 50 bytes per triangle: normal, three corners, two attribute
// bytes.
#include <algorithm>
#include <limits>

#include "base/text.hpp"
#include "export/facet.hpp"
#include "export/writers.hpp"

namespace scanmill::exporting {
namespace {

constexpr std::size_t kHeaderBytes = 80, kPreambleBytes = 84, kRecordBytes = 50;
constexpr std::size_t kRecordsAtOnce = 8192;
// No "solid" in front: readers take that for ASCII. No time and no version: equal meshes give equal files.
constexpr std::string_view kTitle = "scanmill binary STL UNITS=mm";

char* put_record(char* at, const Vec3& first, const Vec3& second, const Vec3& third) {
  const FloatCorner a = corner_of(first), b = corner_of(second), c = corner_of(third);
  for (const FloatCorner& value : {normal_of(a, b, c), a, b, c}) at = put(at, value);
  return put(at, std::uint16_t{0});
}

std::array<char, kPreambleBytes> preamble(std::uint64_t triangles, const Vec3& offset) {
  std::array<char, kPreambleBytes> bytes{};
  const std::string header = stl_header(offset);
  std::copy(header.begin(), header.end(), bytes.begin());
  put(bytes.data() + kHeaderBytes, static_cast<std::uint32_t>(triangles));
  return bytes;
}

/// The announced triangles, once the size of the file agrees with them.
Result<std::uint32_t> count_of(const ByteSource& source) {
  std::array<char, 4> bytes{};
  if (source.size() < kPreambleBytes)
    return fail(Code::BadInput,
                "the file ends after " + std::to_string(source.size()) +
                    " bytes; a binary STL begins with a header of 84 bytes",
                source.name() + ": byte " + std::to_string(source.size()));
  TRY_ASSIGN(const std::size_t got, source.read_at(kHeaderBytes, bytes));
  std::uint32_t count = 0;
  if (got == bytes.size()) std::memcpy(&count, bytes.data(), sizeof count);
  const std::uint64_t wanted = kPreambleBytes + std::uint64_t{kRecordBytes} * count;
  if (got != bytes.size() || source.size() != wanted)
    return fail(Code::BadInput,
                "the header announces " + grouped(count) + " triangles, which take " + std::to_string(wanted) +
                    " bytes, but the file has " + std::to_string(source.size()) + "; it was cut or is not a binary STL",
                source.name() + ": byte " + std::to_string(std::min(wanted, source.size())));
  return count;
}

/// body(first triangle, records) for the whole file in pieces.
template <class Body>
Result<void> for_each_piece_of(const ByteSource& source, std::uint32_t count, const Body& body) {
  std::vector<char> buffer(kRecordBytes * std::min<std::size_t>(kRecordsAtOnce, count));
  for (std::size_t first = 0; first < count; first += kRecordsAtOnce) {
    const std::size_t bytes = kRecordBytes * std::min<std::size_t>(kRecordsAtOnce, count - first);
    const std::uint64_t offset = kPreambleBytes + kRecordBytes * std::uint64_t{first};
    TRY_ASSIGN(const std::size_t got, source.read_at(offset, std::span<char>(buffer.data(), bytes)));
    if (got != bytes)
      return fail(Code::IoFailed, "the file became shorter while it was read",
                  source.name() + ": byte " + std::to_string(offset + got));
    TRY(body(first, std::span<const char>(buffer.data(), bytes)));
  }
  return {};
}

const char* part_at(std::size_t byte) {
  constexpr const char* kParts[] = {"normal", "first corner", "second corner", "third corner", "attribute"};
  return kParts[byte / sizeof(FloatCorner)];
}

}  // namespace

std::string stl_header(const Vec3& offset) {
  std::string header(kTitle);
  if (!(offset == Vec3{})) {
    const std::string words =
        " offset_mm " + number_text(offset.x) + " " + number_text(offset.y) + " " + number_text(offset.z);
    if (header.size() + words.size() <= kHeaderBytes) header += words;
  }
  header.resize(kHeaderBytes, ' ');
  return header;
}

Result<void> write_stl(const Mesh& mesh, ByteSink& sink) { return stream_stl(MeshBlocks(mesh), sink); }

Result<void> stream_stl(const MeshStream& mesh, ByteSink& sink) {
  if (mesh.triangles() > std::numeric_limits<std::uint32_t>::max())
    return fail(Code::Unsupported,
                "the mesh has " + grouped(mesh.triangles()) +
                    " triangles, but an STL counts them in 32 bits, up to 4,294,967,295; choose a larger bin, or ply",
                sink.name());
  TRY(sink.write(std::span<const char>(preamble(mesh.triangles(), mesh.offset()))));
  std::vector<char> buffer;
  return mesh.each_triangles(Corners::Yes, [&](const TriangleBlock& block) -> Result<void> {
    buffer.resize(kRecordBytes * block.corners.size());
    char* at = buffer.data();
    for (const auto& corner : block.corners) at = put_record(at, corner[0], corner[1], corner[2]);
    return sink.write(std::span<const char>(buffer.data(), at));
  });
}

Result<std::vector<std::array<float, 9>>> read_stl(const ByteSource& source) {
  TRY_ASSIGN(const std::uint32_t count, count_of(source));
  std::vector<std::array<float, 9>> corners(count);
  TRY(for_each_piece_of(source, count, [&](std::size_t first, std::span<const char> records) -> Result<void> {
    for (std::size_t at = 0; at < records.size(); at += kRecordBytes)
      std::memcpy(corners[first + at / kRecordBytes].data(), records.data() + at + sizeof(FloatCorner),
                  sizeof corners[0]);
    return {};
  }));
  return corners;
}

Result<void> compare_stl(const Mesh& mesh, const ByteSource& source) {
  TRY_ASSIGN(const std::uint32_t count, count_of(source));
  if (count != mesh.triangles.size())
    return fail(Code::Internal,
                "the file holds " + grouped(count) + " triangles, the mesh it was written from " +
                    grouped(mesh.triangles.size()),
                source.name() + ": byte 80");
  return for_each_piece_of(source, count, [&](std::size_t first, std::span<const char> records) -> Result<void> {
    std::array<char, kRecordBytes> wanted;
    for (std::size_t at = 0; at < records.size(); at += kRecordBytes) {
      const std::size_t triangle = first + at / kRecordBytes;
      const Triangle& rows = mesh.triangles[triangle];
      put_record(wanted.data(), mesh.positions[rows[0]], mesh.positions[rows[1]], mesh.positions[rows[2]]);
      const auto [found, expected] =
          std::mismatch(records.begin() + static_cast<std::ptrdiff_t>(at),
                        records.begin() + static_cast<std::ptrdiff_t>(at + kRecordBytes), wanted.begin());
      if (expected == wanted.end()) continue;
      const auto byte = static_cast<std::size_t>(expected - wanted.begin());
      return fail(Code::Internal,
                  "the " + std::string(part_at(byte)) + " of triangle " + grouped(triangle) +
                      " is not what the mesh holds; the file was damaged on its way",
                  source.name() + ": byte " + std::to_string(kPreambleBytes + kRecordBytes * triangle + byte));
    }
    return {};
  });
}

}  // namespace scanmill::exporting
