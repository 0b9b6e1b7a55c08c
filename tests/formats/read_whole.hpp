// SPDX-License-Identifier: Apache-2.0
// All points of a file in memory, for tests.
#pragma once
#include "formats/view_reader.hpp"

namespace scanmill::formats {

struct Whole {
  ViewHeader header;
  std::vector<Vec3> positions;
  std::vector<std::uint64_t> rows;
  std::uint64_t points_read = 0, not_finite = 0, sensor_invalid = 0;
};

inline Result<Whole> read_whole(const ViewReader& reader) {
  Whole whole;
  whole.header = reader.header();
  PointBlock block;
  for (std::size_t i = 0; i < reader.block_count(); ++i) {
    TRY(reader.read_block(i, block));
    if (block.positions.size() != block.rows.size() ||
        block.positions.size() + block.not_finite + block.sensor_invalid != block.points_read)
      return fail(Code::Internal, "the counts of a block do not add up");
    whole.positions.insert(whole.positions.end(), block.positions.begin(), block.positions.end());
    whole.rows.insert(whole.rows.end(), block.rows.begin(), block.rows.end());
    whole.points_read += block.points_read;
    whole.not_finite += block.not_finite;
    whole.sensor_invalid += block.sensor_invalid;
  }
  return whole;
}

inline Result<Whole> read_whole(std::shared_ptr<const ByteSource> source, const OpenOptions& options = {}) {
  TRY_ASSIGN(const auto reader, open_view(std::move(source), options));
  return read_whole(*reader);
}

/// Every scan of a file.
inline Result<std::vector<Whole>> read_scans(std::shared_ptr<const ByteSource> source,
                                             const OpenOptions& options = {}) {
  TRY_ASSIGN(const auto readers, open_views(std::move(source), options));
  std::vector<Whole> scans;
  for (const auto& reader : readers) {
    TRY_ASSIGN(Whole whole, read_whole(*reader));
    scans.push_back(std::move(whole));
  }
  return scans;
}

inline Result<std::vector<Whole>> read_scans(const std::string& name, const std::string& bytes,
                                             const OpenOptions& options = {}) {
  return read_scans(std::shared_ptr<const ByteSource>(memory_source(name, bytes)), options);
}

inline Result<Whole> read_whole(const std::string& name, const std::string& bytes) {
  return read_whole(std::shared_ptr<const ByteSource>(memory_source(name, bytes)));
}

}  // namespace scanmill::formats
