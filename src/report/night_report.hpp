// SPDX-License-Identifier: Apache-2.0
// The page of a whole run: one self-contained HTML file beside the scans' own pages. It links to them and shows their
// pictures; it fetches nothing else and runs nothing.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace scanmill::report {

enum class NightState { Pending, Unchanged, Done, Failed, Stale, Quarantined, Interrupted, Vanished };

struct NightScan {
  std::string name;
  NightState state = NightState::Pending;
  bool is_new = false;
  std::vector<std::string> why, failed_gates;
  std::string failure, stage, error, advice, repeat;  // of one that failed: class, running stage, message, what to do
  std::optional<double> max_error_mm, rms_mm;
  std::optional<std::uint64_t> points, triangles, loops;
  double seconds = 0, cpu_seconds = 0;
  std::uint64_t peak_bytes = 0;
  // Relative to the page, '/' between folders; empty: not there.
  std::string page, log, picture, error_picture;
};

struct NightFigure {
  std::string name, unit;
  double then = 0, now = 0;
};

struct NightWorse {
  std::string scan;
  std::vector<NightFigure> figures;
  std::vector<std::string> new_gates;
};

struct NightReport {
  std::string job, archive, host, tool, started, ended, verdict;
  std::string compared_with;  // when the run before ended; empty without one
  int exit_code = 0, threads = 0;
  std::uint64_t memory_cap = 0;
  double seconds = 0;
  std::vector<std::string> notes;  // of the archive as a whole
  std::vector<NightScan> scans;
  std::vector<NightWorse> worse;  // worst first
  std::vector<std::pair<std::string, double>> stage_seconds;
};

/// About 600 bytes per scan made and 100 per unchanged one. Every text may hold any byte.
std::string night_page(const NightReport& night);

/// A relative path as a link: every byte but letters, digits and "-._~/" as %NN.
std::string link_of(std::string_view path);

}  // namespace scanmill::report
