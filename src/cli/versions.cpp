// SPDX-License-Identifier: Apache-2.0
#include "cli/versions.hpp"

namespace scanmill::cli {

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
  std::string text =
      "scanmill " + version() +
      "\nbuild      " SCANMILL_BUILD ", " SCANMILL_COMPILER
      "\nreads      ply, xyz/asc/txt/csv/pwn, .conf, scan plans\nwrites     stl, record.h5, ply (clouds)\nlibraries ";
  const document::Node list = libraries();
  for (const document::Node::Entry& entry : list.entries())
    text += " " + entry.key + " " + entry.value.as_string() + ",";
  text.pop_back();
  return text;
}

}  // namespace scanmill::cli
