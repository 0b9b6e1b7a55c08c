// SPDX-License-Identifier: Apache-2.0
#include "pipeline/bench_cloud.hpp"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "base/text.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

using simulate::BumpyBall;
static_assert(std::endian::native == std::endian::little && sizeof(BumpyBall::Point) == 12,
              "points are written as they lie in memory");

constexpr std::size_t kBatch = 1 << 20, kGrain = 1 << 15;

/// Rows begin to end as one file.
Result<std::uint64_t> write_rows(const BumpyBall& ball, std::uint64_t begin, std::uint64_t end, const std::string& path,
                                 std::vector<BumpyBall::Point>& batch, const Context& context, Progress& progress) {
  TRY_ASSIGN(const auto sink, store::create_file(path));
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment scanmill bench scale, units mm\nelement vertex " +
      std::to_string(end - begin) + "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  TRY(sink->write(std::string_view(header)));
  for (std::uint64_t first = begin; first < end; first += kBatch) {
    batch.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kBatch, end - first)));
    for_each_range(context, batch.size(), kGrain, [&](std::size_t from, std::size_t to) {
      ball.fill(first + from, std::span(batch).subspan(from, to - from));
    });
    if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped on request");
    TRY(sink->write(std::span<const char>(reinterpret_cast<const char*>(batch.data()), 12 * batch.size())));
    progress.stage("make", first + batch.size(), ball.points());
  }
  TRY(sink->commit());
  return header.size() + 12 * (end - begin);
}

}  // namespace

Result<std::uint64_t> write_bench_cloud(const BumpyBall& ball, const std::string& path, const Context& context,
                                        Progress& progress) {
  const bool one_file = path.ends_with(".ply");
  const std::string parent = std::filesystem::path(path).parent_path().string();
  const std::string folder = one_file ? (parent.empty() ? "." : parent) : path;
  TRY(store::make_folders(folder));
  const std::uint64_t wanted = 12 * ball.points();
  if (const auto room = store::free_space(folder); room && *room < wanted)
    return fail(Code::BadUsage,
                counted(ball.points(), "point") + " take " + bytes_text(wanted) + ", the disk has " +
                    bytes_text(*room) + " left; ask for fewer points or name another folder",
                folder);
  progress.stage("make", 0, ball.points());
  std::vector<BumpyBall::Point> batch;
  if (one_file) return write_rows(ball, 0, ball.points(), path, batch, context, progress);
  std::uint64_t bytes = 0;
  for (std::size_t view = 0; view < ball.views(); ++view) {
    char name[32];
    std::snprintf(name, sizeof name, "/view-%04zu.ply", view);
    TRY_ASSIGN(const std::uint64_t written, write_rows(ball, ball.first_of_view(view), ball.first_of_view(view + 1),
                                                       path + name, batch, context, progress));
    bytes += written;
  }
  return bytes;
}

}  // namespace scanmill::pipeline
