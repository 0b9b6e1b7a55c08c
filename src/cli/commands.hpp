// SPDX-License-Identifier: Apache-2.0
// The bodies of the commands: bind options to runner and pipeline, show what comes back.
#pragma once
#include <cstdint>
#include <functional>
#include <string>

#include "base/context.hpp"
#include "base/progress.hpp"
#include "base/result.hpp"
#include "pipeline/tools.hpp"
#include "runner/bench_job.hpp"
#include "runner/console.hpp"
#include "runner/driver.hpp"
#include "runner/write_worklist.hpp"

namespace scanmill::cli {

/// What every command takes.
struct CommonOptions {
  bool json = false, quiet = false;
  std::string progress = "auto";
  std::int64_t threads = 0;
  std::string memory, disk;

  Result<runner::ConsoleOptions> console() const;
  /// The value of --memory in bytes; 0 when no cap was given.
  /// errors  BadUsage when it is no size
  Result<std::uint64_t> memory_cap() const;
  /// The same of --disk.
  Result<std::uint64_t> disk_cap() const;
};

using Tool = std::function<Result<pipeline::ToolReport>(const Context&, Progress&)>;

/// Runs a single stage with threads, cap and progress, shows its report, returns the exit code.
int run_tool(const CommonOptions& common, const std::string& name, const runner::Stop& stop, const Tool& tool);
int run_check(const CommonOptions& common, const std::string& path, std::vector<std::string> sets,
              const runner::Stop& stop);
int run_run(const CommonOptions& common, runner::RunOptions options, runner::Stop& stop);
/// status, cancel or gc of an output folder.
int run_operation(const CommonOptions& common, const std::string& name, const std::string& out, bool dry_run);
int run_retry(const CommonOptions& common, const std::string& out, const std::vector<std::string>& scans,
              runner::Stop& stop);
/// `options`: what the command line says; the rest is filled in.
int run_worklist(const CommonOptions& common, runner::WorklistOptions options);
int run_task(const CommonOptions& common, const std::string& worklist, std::size_t index, runner::Stop& stop);
/// `options`: job, repeats and documents; the rest is filled in.
int run_bench_job(const CommonOptions& common, runner::BenchJobOptions options, runner::Stop& stop);

/// One line per line of the error on stderr; the exit code of the error.
int complain(runner::Console& console, const Error& error);

}  // namespace scanmill::cli
