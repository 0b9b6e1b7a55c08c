// SPDX-License-Identifier: Apache-2.0
#include "runner/run_files.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "runner/night.hpp"
#include "runner/run_texts.hpp"
#include "store/files.hpp"

namespace scanmill::runner {
namespace {

constexpr std::uint64_t kLongestMetrics = 1 << 20;

std::string metrics_before(const OutputTree& tree) {
  if (!store::exists(tree.metrics_file())) return {};
  const auto source = store::open_file(tree.metrics_file(), tree.metrics_file());
  if (!source) return {};
  const auto text = read_all(**source, kLongestMetrics);
  return text ? *text : std::string();
}

/// Other steps append to the file too, so it is never replaced.
void append_summary(const std::string& text, std::vector<std::string>& notes) {
  const char* path = std::getenv("GITHUB_STEP_SUMMARY");
  if (!path || !*path) return;
  std::ofstream file(path, std::ios::binary | std::ios::app);
  file << text;
  file.flush();
  if (!file) notes.push_back("the step summary " + std::string(path) + " takes no text: " + std::strerror(errno));
}

}  // namespace

Result<void> write_run_files(const RunReport& report, const LastNight* last_night, const Work& work,
                             const OutputTree& tree, std::vector<std::string>& notes) {
  const std::vector<WorseScan> worse = last_night ? worse_scans(report, *last_night) : std::vector<WorseScan>();
  append_summary(step_summary(report, worse), notes);
  // Somebody works through last night's failures one by one: the page of the night must not vanish under them, nor may
  // one good scan count as a good night.
  if (!report.only.empty() && store::exists(tree.junit_file())) return {};
  Result<void> all;
  const auto keep = [&](Result<void> written) {
    if (all && !written) all = std::move(written);
  };
  if (const std::string page = work.night_page(night_of(report, last_night, worse)); !page.empty())
    keep(store::write_text(tree.page_file(), page));
  keep(store::write_text(tree.junit_file(), junit_xml(report)));
  keep(store::write_text(tree.trace_file(), trace_tsv(report)));
  keep(store::write_text(tree.metrics_file(), prometheus_text(report, metrics_before(tree))));
  keep(save_night(report, last_night, tree));
  return all;
}

Result<void> write_run_files(const RunReport& report, const Work& work, const OutputTree& tree,
                             std::vector<std::string>& notes) {
  const auto last = load_night(tree);
  return write_run_files(report, last ? &*last : nullptr, work, tree, notes);
}

}  // namespace scanmill::runner
