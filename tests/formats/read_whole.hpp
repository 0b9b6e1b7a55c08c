// SPDX-License-Identifier: Apache-2.0
// All points of a file in memory, for tests.
#pragma once
#include "formats/view_reader.hpp"

namespace scanmill::formats {

struct Whole {
  ViewHeader header;
  std::vector<Vec3> positions;
  std::vector<std::uint64_t> rows;
  std::uint64_t points_read = 0, not_finite = 0;
};

inline Result<Whole> read_whole(std::shared_ptr<const ByteSource> source) {
  TRY_ASSIGN(const auto reader, open_view(std::move(source)));
  Whole whole;
  whole.header = reader->header();
  PointBlock block;
  for (std::size_t i = 0; i < reader->block_count(); ++i) {
    TRY(reader->read_block(i, block));
    if (block.positions.size() != block.rows.size() || block.positions.size() + block.not_finite != block.points_read)
      return fail(Code::Internal, "the counts of a block do not add up");
    whole.positions.insert(whole.positions.end(), block.positions.begin(), block.positions.end());
    whole.rows.insert(whole.rows.end(), block.rows.begin(), block.rows.end());
    whole.points_read += block.points_read;
    whole.not_finite += block.not_finite;
  }
  return whole;
}

inline Result<Whole> read_whole(const std::string& name, const std::string& bytes) {
  return read_whole(std::shared_ptr<const ByteSource>(memory_source(name, bytes)));
}

}  // namespace scanmill::formats
