// SPDX-License-Identifier: Apache-2.0
#include "cli/commands.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/paged_memory.hpp"
#include "base/text.hpp"
#include "cli/pipeline_work.hpp"
#include "cli/versions.hpp"
#include "pipeline/replay_plan.hpp"
#include "plan/plan.hpp"
#include "runner/machine.hpp"
#include "runner/operate.hpp"
#include "runner/task.hpp"
#include "store/files.hpp"

namespace scanmill::cli {

using document::Node;
using runner::Console;

namespace {

constexpr std::string_view kStyles[] = {"auto", "tty", "plain", "json", "none"};
constexpr std::uint64_t kDescriptionLimit = 64ull << 20;

constexpr std::size_t kListed = 10;  // of a list of maps; --json has them all

/// For people: JSON but for texts as they are, numbers of six digits and maps without quotes.
std::string short_text(const Node& node) {
  if (node.is_string()) return node.as_string();
  if (node.is_null()) return "-";
  if (node.is_number() && node.as_number() != std::floor(node.as_number())) return six_digits(node.as_number());
  std::string text;
  if (node.is_sequence()) {
    for (const Node& item : node.items()) text += (text.empty() ? "" : " ") + short_text(item);
    return text.empty() ? "none" : text;
  }
  if (node.is_map()) {
    for (const Node::Entry& entry : node.entries())
      text += (text.empty() ? "" : ", ") + entry.key + " " + short_text(entry.value);
    return text;
  }
  return document::to_json(node);
}

/// "name.inner" and value of every leaf; the items of a list of texts or maps have a row each.
void rows_of(const Node& map, const std::string& prefix, std::vector<std::pair<std::string, std::string>>& rows) {
  for (const Node::Entry& entry : map.entries()) {
    const std::string name = prefix + entry.key;
    if (entry.value.is_map())
      rows_of(entry.value, name + ".", rows);
    else if (entry.value.is_sequence() && !entry.value.items().empty() &&
             (entry.value.items()[0].is_string() || entry.value.items()[0].is_map())) {
      const auto& items = entry.value.items();
      const std::size_t listed = items[0].is_map() ? std::min(items.size(), kListed) : items.size();
      for (std::size_t i = 0; i < listed; ++i) rows.emplace_back(name, short_text(items[i]));
      if (listed < items.size())
        rows.emplace_back(name, "and " + grouped(items.size() - listed) + " more (--json lists all)");
    } else
      rows.emplace_back(name, short_text(entry.value));
  }
}

std::string lines_of_values(const Node& values) {
  std::vector<std::pair<std::string, std::string>> rows;
  rows_of(values, "", rows);
  std::size_t width = 0;
  for (const auto& row : rows) width = std::max(width, row.first.size());
  std::string text;
  for (const auto& [name, value] : rows)
    text += (text.empty() ? "" : "\n") + name + std::string(width - name.size() + 2, ' ') + value;
  return text;
}

void show_report(Console& console, const std::string& command, const pipeline::ToolReport& report) {
  Node event = Console::event("report");
  event.set("command", command);
  event.set("values", report.values);
  console.result(report.text.empty() ? lines_of_values(report.values) : report.text, event);
}

}  // namespace

Result<runner::ConsoleOptions> CommonOptions::console() const {
  const auto style = std::find(std::begin(kStyles), std::end(kStyles), progress);
  if (style == std::end(kStyles)) {
    std::string sentence = "found '" + progress + "'; allowed " + document::joined(kStyles);
    const std::string_view nearest = nearest_name(progress, kStyles);
    if (!nearest.empty()) sentence += "; nearest " + std::string(nearest);
    return fail(Code::BadUsage, sentence, "command line: --progress");
  }
  return runner::ConsoleOptions{static_cast<runner::ProgressStyle>(style - std::begin(kStyles)), json, quiet};
}

namespace {

/// 0 when nothing is given.
Result<std::uint64_t> size_of(const std::string& text, const char* option) {
  if (text.empty()) return std::uint64_t{0};
  const auto bytes = parse_size(text);
  if (!bytes || *bytes == 0)
    return fail(Code::BadUsage, "found '" + text + "'; allowed a size such as 512M or 2G",
                std::string("command line: ") + option);
  return *bytes;
}

/// Where a single tool keeps what does not fit under its cap.
std::string scratch_folder() {
  const char* named = std::getenv("TMPDIR");
  return named != nullptr && *named != 0 ? named : "/var/tmp";
}

}  // namespace

Result<std::uint64_t> CommonOptions::memory_cap() const { return size_of(memory, "--memory"); }
Result<std::uint64_t> CommonOptions::disk_cap() const { return size_of(disk, "--disk"); }

int complain(Console& console, const Error& error) {
  console.complain(error);
  return runner::exit_code_of(error);
}

int run_tool(const CommonOptions& common, const std::string& name, const runner::Stop& stop, const Tool& tool) {
  const auto options = common.console();
  Console console(options ? *options : runner::ConsoleOptions{});
  if (!options) return complain(console, options.error());
  const auto cap = common.memory_cap();
  if (!cap) return complain(console, cap.error());
  const std::uint64_t memory = *cap ? *cap : runner::usable_memory() / 10 * 8;
  if (memory)
    if (const auto capped = runner::cap_memory(memory); !capped) return complain(console, capped.error());
  const auto disk = common.disk_cap();
  if (!disk) return complain(console, disk.error());
  runner::page_beyond(memory, *disk, scratch_folder());
  const ChunkLoop loop(static_cast<int>(common.threads ? common.threads : runner::usable_cores()));
  const Context context{loop, stop.flag};
  console.begin(name);
  auto report = [&]() -> Result<pipeline::ToolReport> {
    try {
      return tool(context, console);
    } catch (const std::bad_alloc&) {
      if (const std::string why = paged::refusal(); !why.empty())
        return fail(Code::NoSpace, why + "; free space there, raise --disk, or set TMPDIR to another folder");
      return fail(Code::NoSpace,
                  "the memory cap of " + bytes_text(memory) + " was reached; raise --memory or choose larger bins");
    } catch (const std::exception& error) {
      return fail(Code::Internal, std::string("unexpected: ") + error.what());
    }
  }();
  console.end();
  if (!report) {
    const int code = complain(console, report.error());
    return stop.signal.load() ? 128 + stop.signal.load() : code;
  }
  show_report(console, name, *report);
  for (const std::string& gate : report->failed_gates) {
    Node event = Console::event("gate");
    event.set("scan", "");
    event.set("text", gate);
    console.problem("rejected: " + gate, event);
  }
  return report->failed_gates.empty() ? runner::kExitGood : runner::kExitGate;
}

int run_check(const CommonOptions& common, const std::string& path, std::vector<std::string> sets,
              const runner::Stop& stop) {
  const auto options = common.console();
  Console console(options ? *options : runner::ConsoleOptions{});
  if (!options) return complain(console, options.error());
  const auto refuse = [&](const Error& error) {
    complain(console, error);
    return runner::kExitUsage;
  };
  const auto source = store::open_file(path, path);
  if (!source) return refuse(source.error());
  const auto text = read_all(**source, kDescriptionLimit);
  if (!text) return refuse(text.error());
  const auto root = document::parse_yaml(*text, path);
  if (!root) return refuse(root.error());

  Node event = Console::event("check");
  event.set("path", path);
  if (root->find("scanmill_plan") || (root->find("stations") && !root->find("scanmill"))) {
    const auto plan = plan::plan_from(*root, path);
    if (!plan) return refuse(plan.error());
    const ChunkLoop loop(static_cast<int>(common.threads ? common.threads : runner::usable_cores()));
    const auto report = pipeline::check_plan(path, Context{loop, stop.flag}, console);
    if (!report) return complain(console, report.error());
    event.set("kind", "plan");
    event.set("stations", static_cast<std::uint64_t>(plan->stations.size()));
    if (const Node* warnings = report->values.find("warnings"))
      for (const Node& line : warnings->items()) console.note("", line.as_string());
    const std::string files = report->values.find("files")->as_string();
    console.result(
        path + ": a valid scan plan with " + std::to_string(plan->stations.size()) + " stations; views: " + files,
        event);
    return runner::kExitGood;
  }
  PipelineWork work;
  const runner::JobCheck check = runner::check_job(path, sets, work);
  for (const std::string& line : check.problems) complain(console, fail(Code::BadParameter, line));
  for (const std::string& line : check.notes) console.note("", line);
  if (!check.problems.empty()) return runner::kExitUsage;
  event.set("kind", "job");
  console.result(path + ": a valid job", event);
  return runner::kExitGood;
}

int run_operation(const CommonOptions& common, const std::string& name, const std::string& out, bool dry_run) {
  const auto options = common.console();
  Console console(options ? *options : runner::ConsoleOptions{});
  if (!options) return complain(console, options.error());
  if (name == "status") return runner::show_status(out, console);
  if (name == "cancel") return runner::cancel_run(out, console);
  return runner::collect_garbage(out, dry_run, console);
}

int run_retry(const CommonOptions& common, const std::string& out, const std::vector<std::string>& scans,
              runner::Stop& stop) {
  const auto options = common.console();
  Console console(options ? *options : runner::ConsoleOptions{});
  if (!options) return complain(console, options.error());
  if (runner::is_held(out, console)) return runner::kExitBusy;
  auto again = runner::release_scans(out, scans, console);
  if (!again) return complain(console, again.error());
  return again->only.empty() ? runner::kExitGood : run_run(common, *std::move(again), stop);
}

namespace {

/// What a run and the bench of one take from the command line and the build.
template <class Options>
Result<void> complete(const CommonOptions& common, Options& options) {
  TRY_ASSIGN(options.memory, common.memory_cap());
  options.threads = common.threads;
  options.version = version();
  options.libraries = libraries();
  return {};
}

}  // namespace

int run_run(const CommonOptions& common, runner::RunOptions options, runner::Stop& stop) {
  auto console_options = common.console();
  if (console_options && !options.dag.empty()) {
    options.dry_run = true;
    *console_options = {runner::ProgressStyle::None, false, true};
  }
  Console console(console_options ? *console_options : runner::ConsoleOptions{});
  if (!console_options) return complain(console, console_options.error());
  if (const auto done = complete(common, options); !done) return complain(console, done.error());
  const auto disk = common.disk_cap();
  if (!disk) return complain(console, disk.error());
  options.disk = *disk;
  PipelineWork work({options.job, "scanmill " + options.version, runner::utc_now()});
  return runner::run_job(options, work, console, stop);
}

int run_worklist(const CommonOptions& common, runner::WorklistOptions options) {
  const auto console_options = common.console();
  Console console(console_options ? *console_options : runner::ConsoleOptions{});
  if (!console_options) return complain(console, console_options.error());
  if (const auto done = complete(common, options.run); !done) return complain(console, done.error());
  PipelineWork work({options.run.job, "scanmill " + options.run.version, runner::utc_now()});
  return runner::write_worklist(options, work, console);
}

int run_task(const CommonOptions& common, const std::string& worklist, std::size_t index, runner::Stop& stop) {
  const auto console_options = common.console();
  Console console(console_options ? *console_options : runner::ConsoleOptions{});
  if (!console_options) return complain(console, console_options.error());
  const auto memory = common.memory_cap();
  if (!memory) return complain(console, memory.error());
  const auto file = runner::load_task_file(worklist);
  if (!file) {
    console.complain(file.error());
    return runner::kExitUsage;
  }
  PipelineWork work({file->job_shown, "scanmill " + version(), runner::utc_now()});
  return runner::run_task({worklist, index, version(), common.threads, *memory}, *file, work, console, stop);
}

int run_bench_job(const CommonOptions& common, runner::BenchJobOptions options, runner::Stop& stop) {
  const auto console_options = common.console();
  Console console(console_options ? *console_options : runner::ConsoleOptions{});
  if (!console_options) return complain(console, console_options.error());
  if (const auto done = complete(common, options); !done) return complain(console, done.error());
  options.work = [job = options.job, version = options.version] {
    return std::make_unique<PipelineWork>(pipeline::RunFrame{job, "scanmill " + version, runner::utc_now()});
  };
  return runner::bench_job(options, console, stop);
}

}  // namespace scanmill::cli
