// SPDX-License-Identifier: Apache-2.0
// Options of single stages, made from the tables that read the job: --bin-mm is the job's lattice.bin_mm.
#pragma once
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "pipeline/what.hpp"

namespace CLI {
class App;
}

namespace scanmill::cli {

class StageOptions {
 public:
  /// Adds the keys of these sections ("" is the job's top level with the camera of depth maps, "seeds" also
  /// --seed x,y,z) to the command.
  void add_to(CLI::App& command, std::initializer_list<std::string_view> sections);
  /// The values given, judged like a job's.
  /// errors  BadParameter, a line each, with "command line" as place
  Result<pipeline::What> what(bool needs_bin) const;

 private:
  struct Given {
    pipeline::WhatField key;
    std::string option, text;
  };
  std::vector<std::unique_ptr<Given>> given_;  // addresses are bound to options
  std::string units_, intrinsics_, depth_scale_;
  std::vector<std::string> seeds_;
};

}  // namespace scanmill::cli
