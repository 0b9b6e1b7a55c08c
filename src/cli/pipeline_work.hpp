// SPDX-License-Identifier: Apache-2.0
// The pipeline as the runner sees it.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/discovery.hpp"
#include "pipeline/hash_cache.hpp"
#include "pipeline/night_page.hpp"
#include "pipeline/run_scan.hpp"
#include "runner/work.hpp"

namespace scanmill::cli {

class PipelineWork final : public runner::Work {
 public:
  /// `frame`: what reports say about the run.
  explicit PipelineWork(pipeline::RunFrame frame = {}) : frame_(std::move(frame)) {}
  std::span<const std::string_view> what_keys() const override { return pipeline::what_keys(); }
  void check_part(const document::Node& part, document::Problems& problems) const override;
  document::Node overlay(document::Node base, const document::Node& over) const override;
  Result<document::Node> resolve(const document::Node& what, const std::string& name) const override;
  Result<runner::Archive> discover(const std::string& archive, const document::Node& what,
                                   const std::function<document::Node(const std::string& scan)>& what_for) override;
  Result<runner::Fingerprint> fingerprint(std::size_t scan, const document::Node& resolved) override;
  std::optional<runner::Fingerprint> known_fingerprint(std::size_t scan, const document::Node& resolved) override;
  runner::InputLook look_at(std::size_t scan) const override;
  Result<runner::Outcome> run(std::size_t scan, const document::Node& resolved, const std::string& folder,
                              const Context& context, Progress& progress) override;
  runner::CutParts parts_of(std::size_t scan, const document::Node& resolved, const runner::BrickKeys& keys,
                            const std::string& folder) const override;
  Result<void> make_part(std::size_t scan, const document::Node& resolved, const runner::BrickKeys& keys,
                         const std::string& folder, const std::string& part, const Context& context,
                         Progress& progress) override;
  Result<std::optional<runner::CutForecast>> forecast_parts(std::size_t scan, const document::Node& resolved,
                                                            const runner::BrickKeys& keys, const std::string& folder,
                                                            const Context& context, Progress& progress) override;
  void use_parts(std::size_t scan, const runner::BrickKeys& keys, const std::string& folder,
                 const runner::StageSeconds& took) override;
  Result<std::optional<runner::Outcome>> rewrite(std::size_t scan, const document::Node& resolved,
                                                 const std::string& standing,
                                                 const std::vector<runner::OutputFile>& files,
                                                 const std::string& folder, const Context& context, Progress& progress,
                                                 std::string& refusal) override;
  void load_hashes(std::string_view text) override { hashes_.load(text); }
  std::string save_hashes() const override { return hashes_.save(); }
  std::string save_hashes_of(std::size_t scan) const override { return hashes_.save(paths_of(scan)); }
  std::string night_page(const runner::Night& night) const override {
    return pipeline::night_page(night.head, night.scans, night.scan);
  }

 private:
  /// Description and views that are there.
  std::vector<std::string> paths_of(std::size_t scan) const;

  /// Keys of the scan as text; those of the scan asked for before are kept, since most scans of a job share theirs.
  Result<pipeline::KeyTexts> keys_of(const pipeline::ScanSpec& scan, const document::Node& resolved);

  /// errors  those of digests_of
  Result<pipeline::Cut> cut_of(std::size_t scan, const document::Node& resolved, const runner::BrickKeys& keys,
                               const std::string& folder);

  /// A scan of the archive. One file and nothing else to say is what most are, and a driver holds all of them.
  struct Known {
    std::string name, file;
    std::unique_ptr<const pipeline::ScanSpec> spec;  // of all others
  };
  /// `room` holds the answer where there is no other place for it.
  const pipeline::ScanSpec& spec_of(std::size_t scan, pipeline::ScanSpec& room) const;

  pipeline::RunFrame frame_;
  struct UsedParts {
    std::size_t scan = 0;
    runner::BrickKeys keys;
    std::string folder;
    pipeline::StageTimes took;
  };
  std::optional<UsedParts> used_parts_;
  std::string archive_;
  std::vector<Known> scans_;
  pipeline::HashCache hashes_;
  document::Node last_resolved_;
  pipeline::KeyTexts last_keys_;
};

}  // namespace scanmill::cli
