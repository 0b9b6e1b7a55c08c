// SPDX-License-Identifier: Apache-2.0
// Ids are distinct types, never bare integers at an interface.
#pragma once
#include <compare>
#include <cstdint>

namespace scanmill {

/// Rank of a view in its scan: order of (relative path as bytes, scan number in the file).
enum class ViewId : std::uint32_t {};
/// Row of a vertex in its mesh: order of bin keys.
enum class VertexId : std::uint32_t {};
/// Number of a patch in its mesh: order of seeds.
enum class PatchId : std::uint32_t {};

template <class Id>
constexpr std::uint32_t index_of(Id id) {
  return static_cast<std::uint32_t>(id);
}

/// Where a measured point came from: view and row in the view's file (PLY: vertex number from 0; text: line number from
/// 1).
struct SourceKey {
  ViewId view{};
  std::uint64_t row = 0;
  friend constexpr auto operator<=>(const SourceKey&, const SourceKey&) = default;
};

}  // namespace scanmill
