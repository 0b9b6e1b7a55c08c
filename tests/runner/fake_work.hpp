// SPDX-License-Identifier: Apache-2.0
// Work whose scans are the .txt files of a folder; what a file says decides what happens.
#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <stdexcept>

#include "base/digest.hpp"
#include "runner/work.hpp"
#include "store/files.hpp"

namespace scanmill::runner {

inline std::string slurp(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

inline void spill(const std::string& path, const std::string& text) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

class FakeWork final : public Work {
 public:
  std::span<const std::string_view> what_keys() const override {
    static constexpr std::string_view kKeys[] = {"lattice", "mesh_vertices_as_scan"};
    return kKeys;
  }
  void check_part(const document::Node& part, document::Problems& problems) const override {
    if (const document::Node* lattice = part.find("lattice"))
      for (const document::Node::Entry& entry : lattice->entries())
        if (entry.key != "bin_mm") problems.add_unknown(entry, "lattice", std::vector<std::string_view>{"bin_mm"});
  }
  document::Node overlay(document::Node base, const document::Node& over) const override {
    for (const document::Node::Entry& entry : over.entries()) base.set(entry.key, entry.value);
    return base;
  }
  Result<document::Node> resolve(const document::Node& what, const std::string& name) const override {
    if (!what.find("lattice")) return fail(Code::BadParameter, name + ":1:1: lattice: found no bin size");
    return what;
  }
  Result<Archive> discover(const std::string& archive, const document::Node&,
                           const std::function<document::Node(const std::string&)>&) override {
    archive_ = archive;
    names_.clear();
    TRY_ASSIGN(const auto files, store::list_files(archive));
    Archive found;
    for (const std::string& file : files) {
      names_.push_back(file.substr(0, file.size() - 4));
      found.scans.push_back({names_.back(),
                             {},
                             text_of(names_.size() - 1) == "broken" ? "its description is broken" : "",
                             names_.back() == of_job});
    }
    if (names_.size() > 1) found.notes = {"1 file of the suffix .las is not read by this version"};
    return found;
  }
  Result<Fingerprint> fingerprint(std::size_t scan, const document::Node& what) override {
    const std::string text = text_of(scan);
    Fingerprint result;
    result.value = sha256_hex(text + document::to_canonical_json(what));
    result.inputs = {{names_[scan] + ".txt", sha256_hex(text), text.size()}};
    result.versions = {{"reduce", "1"}};
    return result;
  }
  Result<Outcome> run(std::size_t scan, const document::Node&, const std::string& folder, const Context& context,
                      Progress& progress) override {
    runs.push_back(names_[scan]);
    const std::string text = text_of(scan);
    progress.stage("reduce", 1, 2);
    spill(folder + "/mesh.stl", "mesh of " + text);
    if (before_end) before_end(names_[scan]);
    if (context.cancel.is_set()) return fail(Code::Cancelled, "stopped");
    if (text == "bad") return fail(Code::BadInput, "found 'bad'; wanted numbers", names_[scan] + ".txt:1");
    if (text == "throws") throw std::runtime_error("surprise");
    if (text == "hungry") throw std::bad_alloc();
    spill(folder + "/record.h5", "record of " + text);
    Outcome outcome;
    outcome.counts.set("triangles", 7);
    if (text == "rough") outcome.failed_gates = {"max_error_mm: found 2, allowed 1"};
    outcome.record_identity = "id-" + text;
    return outcome;
  }
  std::optional<Fingerprint> known_fingerprint(std::size_t, const document::Node&) override { return std::nullopt; }
  InputLook look_at(std::size_t scan) const override {
    return {text_of(scan).size(), changed_ns ? changed_ns(names_[scan]) : 0};
  }
  void load_hashes(std::string_view) override {}
  std::string save_hashes() const override { return "{}"; }
  std::string save_hashes_of(std::size_t) const override { return ""; }

  std::vector<std::string> runs;                       // names in the order of running
  std::function<void(const std::string&)> before_end;  // called inside each run
  std::function<std::int64_t(const std::string&)> changed_ns;
  std::string of_job;  // the scan that the job describes itself

 private:
  std::string text_of(std::size_t scan) const { return slurp(archive_ + "/" + names_[scan] + ".txt"); }
  std::string archive_;
  std::vector<std::string> names_;
};

/// A folder of its own for each test.
class RunnerTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    root = testing::TempDir() + "scanmill-" + info->test_suite_name() + "-" + info->name() + "-" +
           std::to_string(getpid());
    std::filesystem::remove_all(root);
    std::filesystem::create_directories(root + "/archive");
  }
  void TearDown() override { std::filesystem::remove_all(root); }
  std::string root;
};

}  // namespace scanmill::runner
