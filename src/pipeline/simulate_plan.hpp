// SPDX-License-Identifier: Apache-2.0
// The virtual scanner on files: a plan and an object to an archive as a rig would have left it, and the truth.
#pragma once
#include <cstdint>
#include <string>

#include "pipeline/tools.hpp"
#include "simulate/fringes.hpp"
#include "simulate/rig.hpp"

namespace scanmill::pipeline {

struct SimulateChoice {
  std::string plan, object, folder;  // object: name of a built-in solid, or a mesh file (global frame, mm)
  std::uint64_t seed = 1;
  std::string format;     // of all views, in place of what their names say; empty: as named, PLY where there is no name
  bool keep_out = false;  // the plan's keep_out bodies (deck, fixture) stand in view
  simulate::Effects effects;
  simulate::FringeRig
      fringes;  // of views written as fringe pictures; its baseline is effects.projector_mm if that is set
};

/// Views of the object from the stations of a plan, the plan (unchanged where nothing had to be added) and
/// PLAN.truth.json in `folder`.
/// errors  BadUsage for an object or format that does not exist; those of plan and mesh file
Result<ToolReport> simulate_plan(const SimulateChoice& choice, const Context& context, Progress& progress);

}  // namespace scanmill::pipeline
