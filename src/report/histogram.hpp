// SPDX-License-Identifier: Apache-2.0
// The histogram of signed distances as an inline SVG.
#pragma once
#include <optional>
#include <string>

#include "report/scan_report.hpp"

namespace scanmill::report {

/// A window around zero that holds 99.9 % of the points; what lies outside is counted in words. `limit_mm`: dashed
/// lines at both signs where they fall into the window. Empty when the histogram is.
std::string histogram_figure(const Histogram& histogram, std::optional<double> limit_mm);

}  // namespace scanmill::report
