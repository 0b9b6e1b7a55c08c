// SPDX-License-Identifier: Apache-2.0
// A record read back to what it was written from.
#pragma once
#include <memory>
#include <string>

#include "mesh/mesh.hpp"
#include "provenance/record.hpp"

namespace scanmill::provenance {

struct StoredRecord {
  std::unique_ptr<Mesh> mesh;
  Record record;         // refers to `mesh`; without sections, and without the text of the description
  std::string identity;  // as it stands in the file
};

/// Written again with the same sections and description it gives the same file.
/// errors  IoFailed when the file cannot be opened; BadInput when it is no record, or not of a layout that holds
///         everything
Result<StoredRecord> read_record(const std::string& path);

}  // namespace scanmill::provenance
