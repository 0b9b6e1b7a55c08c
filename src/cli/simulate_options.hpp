// SPDX-License-Identifier: Apache-2.0
// Options of `scanmill simulate`; those of the effects are made from their table.
#pragma once
#include <memory>
#include <vector>

#include "pipeline/simulate_plan.hpp"

namespace CLI {
class App;
}

namespace scanmill::cli {

class SimulateOptions {
 public:
  void add_to(CLI::App& command);
  Result<pipeline::ToolReport> run(const Context& context, Progress& progress) const {
    return pipeline::simulate_plan(choice_, context, progress);
  }
  /// Paths that were given to read; an object without point and slash is a built-in one.
  std::vector<std::string> named_files() const {
    const bool is_file = choice_.object.find_first_of("./") != std::string::npos;
    return is_file ? std::vector<std::string>{choice_.plan, choice_.object} : std::vector<std::string>{choice_.plan};
  }

 private:
  pipeline::SimulateChoice choice_;
};

}  // namespace scanmill::cli
