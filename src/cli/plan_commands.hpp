// SPDX-License-Identifier: Apache-2.0
// `scanmill plan import|export|solve|propose|calibrate`.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/progress.hpp"
#include "pipeline/calibrate_plan.hpp"
#include "pipeline/plan_files.hpp"
#include "pipeline/propose_plan.hpp"

namespace CLI {
class App;
}

namespace scanmill::cli {

/// Options of the group; its commands bind to these.
class PlanOptions {
 public:
  using MakeCommand = std::function<CLI::App&(CLI::App& group, const char* name, const char* help)>;
  void add_to(CLI::App& group, const MakeCommand& make);
  Result<pipeline::ToolReport> run(const std::string& name, const Context& context, Progress& progress) const;

  /// Paths that were given to read.
  std::vector<std::string> named_files() const;

 private:
  std::vector<std::string> inputs_;
  std::string input_, output_, as_ = "gcode", machine_;
  pipeline::ImportChoice import_;
  pipeline::ProposeChoice propose_;
  pipeline::CalibrateChoice calibrate_;
};

}  // namespace scanmill::cli
