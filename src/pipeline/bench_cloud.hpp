// SPDX-License-Identifier: Apache-2.0
// The cloud of `bench scale` as files, streamed: its size is bounded by the disk only.
#pragma once
#include <string>

#include "base/context.hpp"
#include "base/progress.hpp"
#include "base/result.hpp"
#include "simulate/bumpy_ball.hpp"

namespace scanmill::pipeline {

/// Writes all points as binary little-endian PLY, float x y z (12 bytes a point), in the order of their rows: one file
/// where `path` ends with .ply, else a folder of one file per view, `view-0000.ply` and so on. Holds 12 MB of points at
/// a time; the same bytes for any number of threads.
/// errors  NoSpace, IoFailed; BadUsage when the disk has not the room; Cancelled
/// returns bytes written
Result<std::uint64_t> write_bench_cloud(const simulate::BumpyBall& ball, const std::string& path,
                                        const Context& context, Progress& progress);

}  // namespace scanmill::pipeline
