// SPDX-License-Identifier: Apache-2.0
// What each part of a cut scan took, beside the part itself: whoever puts the scan together knows it, in this run or a
// later one.
#pragma once
#include <string>
#include <vector>

#include "runner/work.hpp"

namespace scanmill::runner {

struct PartSeconds {
  std::string part, host, ended;  // ended: UTC
  double wall = 0, cpu = 0;       // of all tries that made it or found it there
};

/// Adds to what earlier tries took. What cannot be written is left out: times decide nothing.
void add_seconds(const std::string& folder, PartSeconds seconds);
/// Of those parts that left them, wave by wave.
std::vector<PartSeconds> seconds_in(const CutParts& parts);
/// Sums over the parts of a kind, in the same order.
StageSeconds by_kind(const std::vector<PartSeconds>& parts);

}  // namespace scanmill::runner
