// SPDX-License-Identifier: Apache-2.0
// Numbers as a lab reads them; the same text everywhere.
#pragma once
#include <cstdint>
#include <string>

#include "geom/vec3.hpp"

namespace scanmill::report {

/// Four significant digits, whole digits grouped: "0.01235", "12.35", "1.000", "1,235", "1,234,568"; fewer where the
/// number is exactly that: "1.2"; "1.235e-07" below a nanometre, "not known" for NaN.
std::string figure(double value);
/// The same with a sign: "+0.01235".
std::string signed_figure(double value);
/// Three decimals, grouped: "-1,234.568".
std::string fixed3(double value);
/// "(12.000, -3.500, 0.125)"
std::string place(Vec3 p);
/// part / whole as "98.21 %"; "99.99 %" when not all and "0.01 %" when not none; "-" of nothing.
std::string share(std::uint64_t part, std::uint64_t whole);

}  // namespace scanmill::report
