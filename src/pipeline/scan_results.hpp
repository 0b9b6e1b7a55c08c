// SPDX-License-Identifier: Apache-2.0
// Everything known of a scan once its mesh is finished: what record, report and pictures are made of.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "mesh/section.hpp"
#include "optimise/optimise.hpp"
#include "pipeline/clean_scan.hpp"
#include "pipeline/scan_points.hpp"
#include "pipeline/scan_spec.hpp"
#include "pipeline/surface.hpp"
#include "pipeline/what.hpp"
#include "reduce/reduce.hpp"
#include "verify/verify.hpp"

namespace scanmill::pipeline {

struct WrittenFile {
  std::string name;  // in the scan's folder
  std::uint64_t bytes = 0;
  std::string sha256;
  std::vector<std::string> notes{};  // what its reader should know
};

/// Sentences for the user with where they come from.
struct NoteList {
  std::vector<std::string> texts;
  std::vector<provenance::NoteKind> kinds;
  void add(std::vector<std::string> notes, provenance::NoteKind kind = provenance::NoteKind::Finding) {
    kinds.insert(kinds.end(), notes.size(), kind);
    for (std::string& note : notes) texts.push_back(std::move(note));
  }
};

struct ScanResults {
  const std::string& archive;
  const ScanSpec& scan;
  const What& what;
  const ScanPoints& points;
  const CleanedScan& cleaned;
  reduce::Reduction reduction;
  MeshedSurface surface;
  optimise::Report swaps{};
  verify::Quality quality{};
  verify::Report fit{};
  std::uint64_t points_in_strays = 0;  // not judged
  std::vector<std::string> digests{};  // SHA-256 of each view of `points`
  NoteList notes{};
  const struct RefinedScan* refined = nullptr;
};

}  // namespace scanmill::pipeline
