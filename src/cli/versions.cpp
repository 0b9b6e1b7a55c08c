// SPDX-License-Identifier: Apache-2.0
#include "cli/versions.hpp"

#include <span>
#include <string_view>

#include "document/read_fields.hpp"

namespace scanmill::cli {
namespace {

constexpr std::string_view kReads[] = {
    "ply",  "xyz/asc/txt/csv/pwn", "pts", "ptx", "pcd", "las", "png (depth)", ".conf",
    ".aln", "scan plans",          "stl", "obj", "off"};
constexpr std::string_view kWrites[] = {"stl", "ply", "obj", "3mf", "iges", "dxf", "vdb", "svg", "png", "record.h5"};

document::Node list_of(std::span<const std::string_view> words) {
  document::Node list = document::Node::sequence();
  for (const std::string_view word : words) list.push(std::string(word));
  return list;
}

}  // namespace

std::string version() { return SCANMILL_VERSION; }

document::Node libraries() {
  document::Node node = document::Node::map();
  node.set("openvdb", SCANMILL_OPENVDB);
  node.set("tbb", SCANMILL_TBB);
  node.set("hdf5", SCANMILL_HDF5);
  node.set("eigen", SCANMILL_EIGEN);
  node.set("yaml-cpp", SCANMILL_YAML_CPP);
  node.set("nlohmann-json", SCANMILL_JSON);
  node.set("openssl", SCANMILL_OPENSSL);
  node.set("cli11", SCANMILL_CLI11);
  return node;
}

std::string version_text() {
  std::string text = "scanmill " + version() + "\nbuild      " SCANMILL_BUILD ", " SCANMILL_COMPILER "\nreads      " +
                     document::joined(kReads) + "\nwrites     " + document::joined(kWrites) + "\nlibraries ";
  const document::Node list = libraries();
  for (const document::Node::Entry& entry : list.entries())
    text += " " + entry.key + " " + entry.value.as_string() + ",";
  text.pop_back();
  return text;
}

std::string version_line() {
  document::Node line = document::Node::map();
  line.set("type", "version");
  line.set("version", version());
  line.set("build", SCANMILL_BUILD);
  line.set("compiler", SCANMILL_COMPILER);
  line.set("reads", list_of(kReads));
  line.set("writes", list_of(kWrites));
  line.set("libraries", libraries());
  return document::to_json(line);
}

}  // namespace scanmill::cli
