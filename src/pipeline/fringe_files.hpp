// SPDX-License-Identifier: Apache-2.0
// Fringe pictures on disk: written by the virtual scanner, decoded to maps that people look at.
#pragma once
#include <string>
#include <vector>

#include "formats/fringe_set.hpp"
#include "pipeline/tools.hpp"
#include "simulate/fringes.hpp"

namespace scanmill::pipeline {

/// Opens files in the folder of `path`.
formats::OpenBeside beside(const std::string& path);

/// NAME.fringes and its pictures at `path`, those of the plate (shared by all views of a folder) beside them.
Result<void> write_fringe_view(const std::string& path, const simulate::FringeRig& rig, const scanmill::Sensor& sensor,
                               const std::vector<fringe::Picture>& object, const std::vector<fringe::Picture>& plate);

/// `fringes`: wrapped.png and unwrapped.png (16 bits), quality.png (8 bits: visibility, 0 where masked), range.png
/// (16-bit depths) and range.ply of a description, with how many pixels each flaw took.
Result<ToolReport> decode_fringe_file(const std::string& path, const std::string& folder, Progress& progress);

}  // namespace scanmill::pipeline
