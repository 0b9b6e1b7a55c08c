// SPDX-License-Identifier: Apache-2.0
// The parts of the page of a run, each appended to `out`; nothing where there is nothing to tell. Internal to `report`.
#pragma once
#include <string>

#include "report/night_report.hpp"

namespace scanmill::report {

// night_page.cpp
/// "12.3 s", "4 min 05 s", "1 h 52 min"
std::string duration(double seconds);
/// The name, as a link to the scan's own page where it has one.
std::string linked_name(const NightScan& scan);
/// A picture that is fetched when it scrolls into sight; empty where there is none.
std::string thumbnail(const NightScan& scan, const std::string& picture);
/// A heading with its count.
void add_counted_heading(std::string& out, const char* id, const char* title, std::size_t count);

// night_problems.cpp: what somebody should look at
void add_worse(const NightReport& night, std::string& out);
void add_failed(const NightReport& night, std::string& out);
void add_rejected(const NightReport& night, std::string& out);
void add_quarantined(const NightReport& night, std::string& out);

// night_results.cpp: what was made, what was not, and what it cost
void add_made(const NightReport& night, std::string& out);
void add_others(const NightReport& night, std::string& out);
void add_cost(const NightReport& night, std::string& out);

}  // namespace scanmill::report
