// SPDX-License-Identifier: Apache-2.0
// The digest of a record's content that does not depend on the order of writing, so that a reader can work it out
// again.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace scanmill::provenance {

/// "path @attribute type [extents] digest": one line per group, dataset and attribute.
std::string content_item(const std::string& path, const std::string& attribute, const std::string& type,
                         const std::vector<std::uint64_t>& shape, const std::string& sha256);
/// SHA-256 over the items in the order of their bytes, each followed by a line feed.
std::string content_digest(std::vector<std::string> items);

}  // namespace scanmill::provenance
