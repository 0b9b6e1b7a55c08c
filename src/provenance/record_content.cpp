// SPDX-License-Identifier: Apache-2.0
#include "provenance/record_content.hpp"

#include <algorithm>

#include "base/digest.hpp"

namespace scanmill::provenance {

std::string content_item(const std::string& path, const std::string& attribute, const std::string& type,
                         const std::vector<std::uint64_t>& shape, const std::string& sha256) {
  std::string line = path + (attribute.empty() ? "" : " @" + attribute) + " " + type + " [";
  for (const std::uint64_t extent : shape) line += std::to_string(extent) + ",";
  return line + "] " + sha256;
}

std::string content_digest(std::vector<std::string> items) {
  std::sort(items.begin(), items.end());
  Sha256 digest;
  for (const std::string& item : items) digest.add(std::string_view(item + "\n"));
  return digest.hex();
}

}  // namespace scanmill::provenance
