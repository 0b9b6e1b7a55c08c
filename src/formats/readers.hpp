// SPDX-License-Identifier: Apache-2.0
// The readers behind open_view, one per family of formats.
#pragma once
#include "formats/view_reader.hpp"

namespace scanmill::formats {

Result<std::unique_ptr<ViewReader>> open_ply(std::shared_ptr<const ByteSource> source);
/// Lines of numbers: XYZ, ASC, CSV.
Result<std::unique_ptr<ViewReader>> open_text(std::shared_ptr<const ByteSource> source);
/// PTS: a count and as many lines, perhaps several times; without a count like open_text.
Result<std::unique_ptr<ViewReader>> open_pts(std::shared_ptr<const ByteSource> source);
/// PTX: one reader per scan. Cells 0 0 0 hold no measurement.
Result<std::vector<std::unique_ptr<ViewReader>>> open_ptx(std::shared_ptr<const ByteSource> source);
/// PCD: ascii, binary, binary_compressed. Of a compressed body marks for beginning anywhere stay in memory, about 3 %
/// of the decoded size.
Result<std::unique_ptr<ViewReader>> open_pcd(std::shared_ptr<const ByteSource> source);
/// LAS 1.0 to 1.4, point formats 0 to 10, not compressed. Withheld points are dropped as invalid.
Result<std::unique_ptr<ViewReader>> open_las(std::shared_ptr<const ByteSource> source);
/// 16-bit grey PNG: one point per pixel, 0 holds no measurement. One decoded image per thread is kept.
Result<std::unique_ptr<ViewReader>> open_depth_map(std::shared_ptr<const ByteSource> source, const DepthCamera& camera);

/// A description of fringe pictures (docs/formats.md): one point per pixel whose phases are sound. All pictures are read
/// and decoded with the one block there is.
Result<std::unique_ptr<ViewReader>> open_fringes(std::shared_ptr<const ByteSource> source, const OpenOptions& options);

/// STL, OBJ, OFF: vertices in the order of the file (an STL's corners joined where they are equal), row = vertex from 0.
/// The whole mesh is held in memory.
Result<std::unique_ptr<ViewReader>> open_mesh_points(std::shared_ptr<const ByteSource> source);

}  // namespace scanmill::formats
