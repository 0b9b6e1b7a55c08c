// SPDX-License-Identifier: Apache-2.0
#include "pipeline/audit.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "base/digest.hpp"
#include "base/text.hpp"
#include "document/document.hpp"
#include "pipeline/record_info.hpp"
#include "pipeline/run_scan.hpp"
#include "provenance/hdf5_reader.hpp"
#include "provenance/record_content.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

namespace fs = std::filesystem;
using provenance::RecordReader;
using Texts = std::vector<std::string>;

constexpr std::string_view kLayouts[] = {"scanmill-record-1"};
constexpr std::uint64_t kReportLimit = 1 << 30;
constexpr std::size_t kDifferencesShown = 5;

struct Claim {
  std::string file, sha256;
};

/// What the record says of itself.
struct Claims {
  std::string title, identity, creator, what_json;
  std::vector<Claim> inputs, outputs;  // inputs with the description; without a digest: missing when it was made
  std::map<std::string, std::string> versions;
};

Result<Claims> claims_of(const RecordReader& record) {
  Claims claims;
  TRY_ASSIGN(claims.title, record.attribute("/", "title"));
  TRY_ASSIGN(claims.identity, record.attribute("/", "identity"));
  TRY_ASSIGN(claims.creator, record.attribute("/", "creator"));
  TRY_ASSIGN(const Texts what, record.texts("/parameters/what_json"));
  if (!what.empty()) claims.what_json = what[0];
  TRY_ASSIGN(const std::string description, record.attribute("/description", "path"));
  TRY_ASSIGN(const std::string digest, record.attribute("/description", "sha256"));
  if (!description.empty()) claims.inputs.push_back({description, digest});
  auto add = [&](const char* files, const char* digests, std::vector<Claim>& to) -> Result<void> {
    TRY_ASSIGN(const Texts names, record.texts(files));
    TRY_ASSIGN(const Texts sums, record.texts(digests));
    for (std::size_t n = 0; n < std::min(names.size(), sums.size()); ++n) {
      const bool known = std::any_of(to.begin(), to.end(), [&](const Claim& c) { return c.file == names[n]; });
      if (!known) to.push_back({names[n], sums[n]});  // a file of several scans stands once per scan
    }
    return {};
  };
  TRY(add("/inputs/path", "/inputs/sha256", claims.inputs));
  TRY(add("/outputs/file", "/outputs/sha256", claims.outputs));
  TRY_ASSIGN(const Texts stages, record.children("/stages"));
  for (const std::string& stage : stages) {
    TRY_ASSIGN(const std::string version, record.attribute("/stages/" + stage, "version"));
    claims.versions[stage.substr(std::min(stage.find('_') + 1, stage.size()))] = version;
  }
  return claims;
}

/// The archive that run.json of the output tree around the record names; empty when there is none.
std::string archive_of_run(const std::string& record) {
  std::error_code ignored;
  for (fs::path folder = fs::absolute(record, ignored).parent_path(); folder.has_relative_path();
       folder = folder.parent_path()) {
    const std::string path = (folder / "run.json").string();
    if (!store::exists(path)) continue;
    const auto source = store::open_file(path, path);
    if (!source.ok()) return {};
    const auto text = read_all(**source, kReportLimit);
    if (!text.ok()) return {};
    const auto tree = document::parse_yaml(*text, path);
    const document::Node* job = tree.ok() ? tree->find("job") : nullptr;
    if (!job || !job->is_map()) return {};
    for (const char* key : {"archive_absolute", "archive"})  // the second is seen from the folder of the run
      if (const document::Node* archive = job->find(key); archive && archive->is_string())
        if (key == std::string_view("archive") || store::is_folder(archive->as_string())) return archive->as_string();
    return {};
  }
  return {};
}

/// "." says nothing to whoever reads the sentence elsewhere.
std::string shown(const std::string& folder) {
  std::error_code error;
  const fs::path whole = fs::absolute(folder, error).lexically_normal();
  if (error || fs::path(folder).is_absolute()) return folder;
  const std::string text = whole.has_filename() ? whole.string() : whole.parent_path().string();
  return folder == "." || folder.starts_with("./") || folder.starts_with("../") ? text : folder;
}

/// What the runner wrote beside the record of all files of the scan, pictures, page and the record itself among them,
/// and the record does not name. Nothing where a record stands alone.
std::vector<Claim> other_files(const std::string& folder, const std::vector<Claim>& outputs) {
  std::vector<Claim> others;
  const std::string path = folder + "/.state.json";
  if (!store::exists(path)) return others;
  const auto source = store::open_file(path, path);
  if (!source.ok()) return others;
  const auto text = read_all(**source, kReportLimit);
  const auto tree = text.ok() ? document::parse_json(*text, path) : Result<document::Node>(text.error());
  const document::Node* files = tree.ok() && tree->is_map() ? tree->find("outputs") : nullptr;
  if (files == nullptr || !files->is_sequence()) return others;
  for (const document::Node& file : files->items()) {
    const document::Node* name = file.is_map() ? file.find("name") : nullptr;
    const document::Node* sum = file.is_map() ? file.find("sha256") : nullptr;
    if (!name || !sum || !name->is_string() || !sum->is_string()) continue;
    const bool known =
        std::any_of(outputs.begin(), outputs.end(), [&](const Claim& c) { return c.file == name->as_string(); });
    if (!known) others.push_back({name->as_string(), sum->as_string()});
  }
  return others;
}

/// Sentences about files that are not what the record says; returns how many are.
Result<std::uint64_t> check_files(const std::vector<Claim>& claims, const std::string& folder, const char* kind,
                                  Texts& problems) {
  std::uint64_t proven = 0;
  for (const Claim& claim : claims) {
    const std::string path = folder + "/" + claim.file, name = std::string(kind) + " " + claim.file + ": ";
    if (!is_inside(claim.file)) {
      problems.push_back(name + "the record names a file outside " + folder + "; it was not opened");
      continue;
    }
    if (claim.sha256.empty()) {
      if (store::exists(path))
        problems.push_back(name + "was missing when the record was made and is there now");
      else
        ++proven;
      continue;
    }
    if (!store::exists(path)) {
      problems.push_back(name + "is not in " + shown(folder));
      continue;
    }
    const auto source = store::open_file(path, path);
    if (!source.ok() && source.error().code != Code::BadInput) return source.error();
    if (!source.ok()) {
      problems.push_back(name + source.error().message);
      continue;
    }
    TRY_ASSIGN(const std::string found, sha256_of(**source));
    if (found == claim.sha256)
      ++proven;
    else
      problems.push_back(name + "was changed: its SHA-256 is " + found + ", as written it was " + claim.sha256);
  }
  return proven;
}

/// Objects that two records do not have in common, by their lines without the digest.
std::string differences(Texts a, Texts b) {
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  Texts apart;
  std::set_symmetric_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(apart));
  Texts names;
  for (const std::string& line : apart) {
    const std::size_t mark = line.find(" @");
    std::string name = line.substr(0, line.find(' ', mark == std::string::npos ? 0 : mark + 1));
    if (name.rfind("/ @", 0) == 0) continue;  // identity and the like follow from the others
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(std::move(name));
  }
  std::string text;
  for (std::size_t n = 0; n < std::min(names.size(), kDifferencesShown); ++n) text += (n ? ", " : "") + names[n];
  if (names.size() > kDifferencesShown) text += " and " + grouped(names.size() - kDifferencesShown) + " more";
  return text;
}

/// A folder that goes with its scope.
class Workplace {
 public:
  /// Below TMPDIR, or /tmp without it.
  Result<void> make() {
    std::error_code error;
    const fs::path temporary = fs::temp_directory_path(error);
    if (error)
      return fail(Code::IoFailed, "there is no folder for temporary files (" + error.message() + "); set TMPDIR to one",
                  std::getenv("TMPDIR") != nullptr ? std::getenv("TMPDIR") : "/tmp");
    path_ = (temporary / ("scanmill-audit-" + std::to_string(::getpid()))).string();
    TRY(store::remove_tree(path_));
    return store::make_folders(path_);
  }
  Workplace() = default;
  ~Workplace() {
    if (!path_.empty()) (void)store::remove_tree(path_);
  }
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Stages whose version is not that of this program.
std::string other_versions(const Claims& claims) {
  std::string text;
  for (const auto& [stage, version] : stage_versions()) {
    const auto found = claims.versions.find(stage);
    if (found == claims.versions.end() || found->second == version) continue;
    text += (text.empty() ? "" : ", ") + stage + " " + found->second + " (here " + version + ")";
  }
  return text;
}

/// Or else of the machine, or a wish to stop: such say nothing of a record.
bool is_about_files(Code code) {
  return code == Code::BadInput || code == Code::BadParameter || code == Code::Unsupported;
}

Result<void> rerun(const Claims& claims, const RecordReader& record, const std::string& archive, const Context& context,
                   Progress& progress, document::Node& values, Texts& problems) {
  if (const std::string other = other_versions(claims); !other.empty()) {
    problems.push_back("rerun: the record was made by other versions of stages: " + other +
                       "; use the program that made it, " + claims.creator);
    return {};
  }
  TRY_ASSIGN(const document::Node tree, document::parse_yaml(claims.what_json, "/parameters/what_json"));
  TRY_ASSIGN(const What what, what_from(tree, "/parameters/what_json"));
  TRY_ASSIGN(const Discovery found, discover(archive, discovery_keys(tree)));
  const auto scan = std::find_if(found.scans.begin(), found.scans.end(),
                                 [&](const ScanSpec& spec) { return spec.name == claims.title; });
  if (scan == found.scans.end()) {
    problems.push_back("rerun: " + archive + " holds no scan " + claims.title);
    return {};
  }
  Workplace place;
  TRY(place.make());
  auto made = run_scan(archive, *scan, what, place.path(), {}, context, progress);
  if (!made.ok()) {
    if (!is_about_files(made.error().code)) return std::move(made).error();
    problems.push_back("rerun: the scan could not be made again: " + made.error().text());
    return {};
  }
  TRY_ASSIGN(const RecordReader again, RecordReader::open(place.path() + "/record.h5"));
  TRY_ASSIGN(const Claims remade, claims_of(again));
  values.set("remade_identity", remade.identity);
  // Objects are compared in any case: `identity` and `content` are texts that anyone can write.
  TRY_ASSIGN(Texts before, record.content());
  TRY_ASSIGN(Texts after, again.content());
  const std::string where = differences(std::move(before), std::move(after));
  if (remade.identity != claims.identity)
    problems.push_back("rerun: the record made again has the identity " + remade.identity + ", this one says " +
                       claims.identity + (where.empty() ? "" : "; they differ in " + where));
  else if (!where.empty())
    problems.push_back("rerun: the record made again has the same identity and differs in " + where +
                       ": this one was changed after it was written");
  for (const Claim& output : claims.outputs) {
    const auto same = std::find_if(remade.outputs.begin(), remade.outputs.end(),
                                   [&](const Claim& c) { return c.file == output.file; });
    if (same == remade.outputs.end())
      problems.push_back("rerun: made no " + output.file);
    else if (same->sha256 != output.sha256)
      problems.push_back("rerun: " + output.file + " made again has the SHA-256 " + same->sha256 +
                         ", the record says " + output.sha256);
  }
  return {};
}

/// What the record itself says, and whether its content is still what was written. BadInput and Unsupported mean that
/// it is not.
Result<void> prove_content(const RecordReader& record, const std::string& path, Claims& claims, ToolReport& report) {
  if (record.has_attribute("/", "content")) {
    TRY_ASSIGN(const std::string said, record.attribute("/", "content"));
    TRY_ASSIGN(Texts items, record.content());
    const std::string found = provenance::content_digest(std::move(items));
    report.values.set("content_proven", found == said);
    if (found != said)
      report.failed_gates.push_back("record: was changed after it was written: its content digests to " + found +
                                    ", it says " + said);
  } else {
    report.values.set("notes", "the record is of an early version without a digest of its content; --rerun proves it");
  }
  TRY_ASSIGN(const std::string layout, record.attribute("/", "Conventions"));
  if (std::find(std::begin(kLayouts), std::end(kLayouts), layout) == std::end(kLayouts))
    return fail(Code::Unsupported,
                "found the layout '" + layout + "'; this version reads " + document::joined(kLayouts), path);
  TRY_ASSIGN(claims, claims_of(record));
  return {};
}

/// A record that nothing more can be said of.
ToolReport not_proven(ToolReport report, const Error& error) {
  report.values.set("content_proven", false);
  report.values.set("proven", false);
  report.failed_gates.push_back(error.text());
  return report;
}

}  // namespace

Result<ToolReport> audit_record(const AuditChoice& choice, const Context& context, Progress& progress) {
  const std::string path = store::is_folder(choice.record) ? choice.record + "/record.h5" : choice.record;
  if (!store::exists(path)) return fail(Code::BadInput, "this folder holds no record.h5", choice.record);
  TRY_ASSIGN(const bool looks_right, is_record_file(path));
  ToolReport report;
  report.values.set("record", path);
  const auto opened = RecordReader::open(path);
  if (!opened.ok() && (!looks_right || opened.error().code != Code::BadInput)) return opened.error();
  if (!opened.ok()) return not_proven(std::move(report), opened.error());
  const RecordReader& record = *opened;
  Texts& problems = report.failed_gates;
  Claims claims;
  if (const auto told = prove_content(record, path, claims, report); !told.ok()) {
    const bool changed = told.error().code == Code::BadInput || !problems.empty();
    return changed ? Result<ToolReport>(not_proven(std::move(report), told.error())) : told.error();
  }
  const std::string archive = choice.archive.empty() ? archive_of_run(path) : choice.archive;
  if (archive.empty() && !problems.empty()) {
    report.values.set("proven", false);
    return report;
  }
  if (archive.empty())
    return fail(Code::BadUsage, "no run.json around the record says where its archive is; add --archive DIR", path);
  if (!store::is_folder(archive))
    return fail(Code::BadUsage, "the archive " + archive + " is not there; add --archive DIR", path);
  progress.stage("audit", 0, 0);

  report.values.set("scan", claims.title);
  report.values.set("identity", claims.identity);
  report.values.set("archive", archive);
  TRY_ASSIGN(const std::uint64_t inputs, check_files(claims.inputs, archive, "input", problems));
  const std::string folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path().string() : ".";
  TRY_ASSIGN(const std::uint64_t outputs, check_files(claims.outputs, folder, "output", problems));
  report.values.set("inputs_proven", inputs);
  report.values.set("inputs", static_cast<std::uint64_t>(claims.inputs.size()));
  report.values.set("outputs_proven", outputs);
  report.values.set("outputs", static_cast<std::uint64_t>(claims.outputs.size()));
  std::vector<Claim> others = other_files(folder, claims.outputs);
  if (!problems.empty()) std::erase_if(others, [](const Claim& claim) { return claim.file == "record.h5"; });
  TRY_ASSIGN(const std::uint64_t as_written, check_files(others, folder, "file", problems));
  report.values.set("other_files_proven", as_written);
  report.values.set("other_files", static_cast<std::uint64_t>(others.size()));
  if (choice.rerun) {
    const std::size_t before = problems.size();
    if (auto done = rerun(claims, record, archive, context, progress, report.values, problems); !done.ok()) {
      // Keys that make no sense come of a record that was changed; everything else is the machine's.
      if (problems.empty() || !is_about_files(done.error().code)) return std::move(done).error();
      problems.push_back("rerun: the scan could not be made again: " + done.error().text());
    }
    report.values.set("remade_the_same", problems.size() == before);
  }
  report.values.set("proven", problems.empty());
  return report;
}

}  // namespace scanmill::pipeline
