// SPDX-License-Identifier: Apache-2.0
#include "pipeline/record_info.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "provenance/hdf5_reader.hpp"
#include "provenance/record_content.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

using Texts = std::vector<std::string>;

constexpr std::array<char, 8> kHdf5Start = {'\x89', 'H', 'D', 'F', '\r', '\n', '\x1a', '\n'};

document::Node list_of(const Texts& texts) {
  document::Node node = document::Node::sequence();
  for (const std::string& text : texts) node.push(text);
  return node;
}

}  // namespace

Result<bool> is_record_file(const std::string& path) {
  TRY_ASSIGN(const auto source, store::open_file(path, path));
  std::array<char, kHdf5Start.size()> start{};
  if (source->size() < start.size()) return false;
  TRY(source->read_at(0, start));
  return start == kHdf5Start;
}

Result<ToolReport> record_info(const std::string& path, Progress& progress) {
  TRY_ASSIGN(const provenance::RecordReader record, provenance::RecordReader::open(path));
  if (!record.has_attribute("/", "Conventions"))
    return fail(Code::BadInput, "is an HDF5 file, but no record of scanmill: it has no attribute Conventions", path);
  progress.stage("info", 0, 0);
  ToolReport report;
  report.values.set("file", path);
  report.values.set("format", "HDF5 record");
  const std::pair<const char*, const char*> said[] = {
      {"layout", "Conventions"}, {"scan", "title"}, {"creator", "creator"}, {"identity", "identity"}};
  for (const auto& [key, attribute] : said) {
    TRY_ASSIGN(std::string text, record.attribute("/", attribute));
    report.values.set(key, std::move(text));
  }
  if (record.has_attribute("/", "content")) {
    TRY_ASSIGN(const std::string digest, record.attribute("/", "content"));
    TRY_ASSIGN(Texts items, record.content());
    const bool whole = provenance::content_digest(std::move(items)) == digest;
    report.values.set("content_proven", whole);
    if (!whole) report.failed_gates.push_back("the record was changed after it was written; audit says more");
  }
  const std::pair<const char*, const char*> sizes[] = {
      {"views", "/inputs/path"},        {"reduced_points", "/reduced/points"}, {"vertices", "/mesh/stl_positions"},
      {"triangles", "/mesh/triangles"}, {"patches", "/patches/area_mm2"},      {"boundary_loops", "/loops/length_mm"},
      {"strays", "/strays/triangles"}};
  for (const auto& [key, dataset] : sizes) {
    TRY_ASSIGN(const std::uint64_t rows, record.rows(dataset));
    report.values.set(key, rows);
  }
  document::Node stages = document::Node::map();
  TRY_ASSIGN(const Texts names, record.children("/stages"));
  for (const std::string& name : names) {
    TRY_ASSIGN(std::string version, record.attribute("/stages/" + name, "version"));
    stages.set(name.substr(std::min(name.find('_') + 1, name.size())), std::move(version));
  }
  report.values.set("stage_versions", std::move(stages));
  TRY_ASSIGN(const Texts inputs, record.texts("/inputs/path"));
  report.values.set("inputs", list_of(inputs));
  TRY_ASSIGN(const Texts outputs, record.texts("/outputs/file"));
  report.values.set("outputs", list_of(outputs));
  TRY_ASSIGN(const Texts notes, record.texts("/notes"));
  if (!notes.empty()) report.values.set("notes", list_of(notes));
  return report;
}

}  // namespace scanmill::pipeline
