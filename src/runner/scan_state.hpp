// SPDX-License-Identifier: Apache-2.0
// What a finished scan was made from and of: a small file inside its folder, so it is switched in with the result
// itself.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "document/document.hpp"
#include "runner/work.hpp"

namespace scanmill::runner {

inline constexpr const char* kStateFile = ".state.json";

struct ScanState {
  Fingerprint fingerprint;
  document::Node what;  // resolved
  document::Node counts;
  std::string record_identity;
  std::vector<std::string> failed_gates;
  std::vector<OutputFile> outputs;
};

/// The state of a scan's folder; nothing when there is none that can be read.
std::optional<ScanState> load_state(const std::string& folder);
/// Hashes the files in `folder`, fills `outputs` and writes the state file beside them, synced.
Result<void> save_state(ScanState& state, const std::string& folder);

/// Why the scan must run: one phrase each; empty when the folder holds the result of exactly this work.
std::vector<std::string> reasons_to_run(const std::optional<ScanState>& state, const std::string& folder,
                                        const Fingerprint& fingerprint, const document::Node& what);

/// Whether the mesh of the folder's record is that of this work, so that files can be made from it.
bool mesh_stands(const std::optional<ScanState>& state, const Fingerprint& fingerprint);

}  // namespace scanmill::runner
