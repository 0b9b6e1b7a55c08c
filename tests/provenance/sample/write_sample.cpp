// SPDX-License-Identifier: Apache-2.0
// Writes the sample scan for the independent readers: FOLDER/archive, FOLDER/mesh.stl, FOLDER/record.h5, and one wrong
// STL.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "provenance/sample/sample_record.hpp"

int main(int argc, char** argv) {
  using namespace scanmill::provenance;
  if (argc != 2) return 2;
  const std::string folder = argv[1];
  std::filesystem::create_directories(folder + "/archive/sub");
  sample::SampleScan scan = sample::make_scan(folder + "/archive");
  scan.record.mesh = &scan.mesh;
  std::string stl = sample::stl_bytes(scan.mesh);
  std::ofstream(folder + "/mesh.stl", std::ios::binary) << stl;
  stl[200] = static_cast<char>(stl[200] ^ 1);
  std::ofstream(folder + "/wrong.stl", std::ios::binary) << stl;
  const auto identity = write_record(scan.record, folder + "/record.h5");
  if (!identity) {
    std::fprintf(stderr, "%s\n", identity.error().text().c_str());
    return 1;
  }
  for (auto& source : scan.record.source) source.row ^= 1;
  return write_record(scan.record, folder + "/wrong-rows.h5") ? 0 : 1;
}
