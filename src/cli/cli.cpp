// SPDX-License-Identifier: Apache-2.0
#include "cli/cli.hpp"

#include <signal.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "base/text.hpp"
#include "cli/commands.hpp"
#include "cli/plan_commands.hpp"
#include "cli/schemas.hpp"
#include "cli/simulate_options.hpp"
#include "cli/stage_options.hpp"
#include "cli/versions.hpp"
#include "pipeline/audit.hpp"
#include "pipeline/bench_scale.hpp"
#include "pipeline/bench_stages.hpp"
#include "pipeline/fringe_files.hpp"
#include "pipeline/mesh_tools.hpp"
#include "pipeline/record_info.hpp"
#include "pipeline/replay_plan.hpp"
#include "runner/console.hpp"
#include "runner/job.hpp"
#include "runner/machine.hpp"

namespace scanmill::cli {
namespace {

runner::Stop g_stop;  // the one global: signal handlers take no argument

extern "C" void on_signal(int number) {
  if (number == SIGHUP && g_stop.signal != 0) return;  // kernel and shell both send one when a terminal goes
  if (!g_stop.request(number)) return;
  signal(number, SIG_DFL);
  raise(number);
}

extern "C" void on_snapshot(int) { g_stop.snapshot.store(true); }

/// Requests to stop are counted (runner::Stop); the one too many ends the process at once.
void install_handlers() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
  struct sigaction hangup {};
  if (sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN)  // else nohup wants it to go on
    sigaction(SIGHUP, &action, nullptr);
  action.sa_handler = on_snapshot;
  sigaction(SIGUSR1, &action, nullptr);
  ::signal(SIGXFSZ, SIG_IGN);  // a limit on the size of files (ulimit -f) fails a write, as a full disk does
  ::signal(SIGPIPE, SIG_IGN);  // a reader that went away ends the messages, not the run
}

/// Options of one invocation; the commands bind to these.
struct Options {
  CommonOptions common;
  runner::RunOptions run;
  StageOptions reduce, mesh, optimise, verify, compare, render, info, cloud, bench, none;
  std::vector<std::string> inputs;
  std::string input, second, output, schema;
  pipeline::PictureChoice picture;
  pipeline::BenchChoice timing;
  pipeline::ScaleChoice scale;
  pipeline::ReplayChoice replay;
  PlanOptions plan;
  SimulateOptions simulate;
  bool as_is = false, as_points = false;
  std::uint64_t task_index = 0;
  std::int64_t worklist_tasks = 0;
  pipeline::MeshForm form;
  pipeline::SectionChoice sections;
  pipeline::AuditChoice audit;

  const StageOptions& stage(const std::string& command) const {
    return command == "reduce"     ? reduce
           : command == "mesh"     ? mesh
           : command == "optimise" ? optimise
           : command == "verify"   ? verify
           : command == "compare"  ? compare
           : command == "render"   ? render
           : command == "info"     ? info
           : command == "convert"  ? cloud
           : command == "bench"    ? bench
                                   : none;
  }
};

CLI::App& command(CLI::App& app, Options& options, const char* name, const char* help) {
  CLI::App& sub = *app.add_subcommand(name, help);
  sub.allow_extras();  // judged afterwards, with the nearest name
  sub.add_flag("--json", options.common.json, "One JSON object with a type per line.");
  sub.add_flag("--quiet", options.common.quiet, "Problems and the last line only.");
  sub.add_option("--progress", options.common.progress, "auto, tty, plain, json or none.");
  sub.add_option("--threads", options.common.threads, "Threads to use; all by default.")->check(CLI::Range(1, 1024));
  sub.add_option("--memory", options.common.memory, "Memory cap such as 512M or 2G; 80 % of the machine's by default.");
  sub.add_option("--disk", options.common.disk,
                 "Disk for what does not fit under the memory cap, such as 30G; 80 % of what is free by default.");
  return sub;
}

void add_job_commands(CLI::App& app, Options& options) {
  CLI::App& run =
      command(app, options, "run", "Every scan of a job to mesh and record; goes on where an earlier run left off.");
  run.add_option("job", options.run.job, "Job file.")->required();
  run.add_option("--out", options.run.out, "Output folder; the job's name with .out in the current folder by default.");
  run.add_option("--only", options.run.only, "Scan name or pattern; may be given again.")->allow_extra_args(false);
  run.add_option("--set", options.run.sets,
                 "key=value in the job's words, e.g. lattice.bin_mm=0.5; may be given again.")
      ->allow_extra_args(false);
  run.add_option("--executor", options.run.executor,
                 document::joined(runner::executor_words()) + "; the job's by default.")
      ->check(
          CLI::IsMember(std::vector<std::string>{runner::executor_words().begin(), runner::executor_words().end()}));
  run.add_flag("--dry-run", options.run.dry_run, "Say what would be done; write nothing.");
  run.add_option("--dag", options.run.dag,
                 "dot or json: print what a dry run finds as a graph of tasks, and nothing else.")
      ->check(CLI::IsMember(std::vector<std::string>{"dot", "json"}));
  run.add_flag("--explain", options.run.explain, "Say for every scan why it runs or is skipped.");
  CLI::App& init = command(app, options, "init", "Look at an archive and write a commented job for it.");
  init.add_option("archive", options.input, "Folder of scans.")->required();
  init.add_option("-o,--output", options.output, "Job to write; job.yaml in the current folder unless given.");
  CLI::App& check = command(app, options, "check", "A job or scan plan against its schema and meaning.");
  check.add_option("file", options.input, "Job or scan plan.")->required();
  check.add_option("--set", options.run.sets, "key=value as for run.")->allow_extra_args(false);
  CLI::App& status = command(app, options, "status", "What goes on in an output folder, or how its last run ended.");
  status.add_option("out", options.input, "Output folder of a run.")->required();
  CLI::App& cancel =
      command(app, options, "cancel", "Ask a run to bring its scans to the end and stop; twice: at once.");
  cancel.add_option("out", options.input, "Output folder of the run.")->required();
  CLI::App& retry =
      command(app, options, "retry", "Try failed and quarantined scans again, with the job of the last run.");
  retry.add_option("out", options.input, "Output folder of the run.")->required();
  retry.add_option("scans", options.inputs, "Scan names or patterns; all unless given.");
  CLI::App& worklist = command(app, options, "worklist",
                               "What a run would make, as numbered tasks for engines of your own (docs/cluster.md).");
  worklist.add_option("job", options.run.job, "Job file.")->required();
  worklist.add_option("--out", options.run.out, "Output folder, as for run.");
  worklist.add_option("--only", options.run.only, "Scan name or pattern; may be given again.")->allow_extra_args(false);
  worklist.add_option("--set", options.run.sets, "key=value as for run.")->allow_extra_args(false);
  worklist
      .add_option("--tasks", options.worklist_tasks,
                  "Tasks at most for scans in one piece, by the forecast unless given; every part of a cut scan is one "
                  "of its own.")
      ->check(CLI::Range(1, 1000000));
  worklist.add_option("-o,--output", options.output, "File to write; OUT/work/by-hand/tasks.json unless given.");
  CLI::App& task = command(app, options, "task", "One task of a worklist file, as every engine runs it.");
  task.add_option("worklist", options.input, "Worklist that run or worklist wrote.")->required();
  task.add_option("index", options.task_index, "Number of the task, from 0.")->required();
  CLI::App& gc =
      command(app, options, "gc", "Remove what killed runs left behind, old journals, logs of scans that are gone.");
  gc.add_option("out", options.input, "Output folder of a run.")->required();
  gc.add_flag("--dry-run", options.run.dry_run, "Say what would be removed; remove nothing.");
}

void add_tool_commands(CLI::App& app, Options& options) {
  CLI::App& reduce = command(app, options, "reduce", "Clouds to one point per bin (PLY).");
  reduce.add_option("inputs", options.inputs, "Cloud files, .conf files or scan plans.")->required();
  reduce.add_option("-o,--output", options.output, "PLY to write.")->required();
  options.reduce.add_to(reduce, {"", "lattice", "reduce"});
  CLI::App& mesh = command(app, options, "mesh", "A cloud to a mesh (STL).");
  mesh.add_option("inputs", options.inputs, "Cloud files, .conf files or scan plans.")->required();
  mesh.add_option("-o,--output", options.output, "STL to write.")->required();
  mesh.add_flag("--as-is", options.as_is, "The input was written by reduce: mesh its points as they are.");
  options.mesh.add_to(mesh, {"", "lattice", "reduce", "grow", "seeds", "merge"});
  CLI::App& optimise = command(app, options, "optimise", "Edge swaps on a mesh: smoothness, then features.");
  optimise.add_option("mesh", options.input, "STL, OBJ, OFF or PLY.")->required();
  optimise.add_option("-o,--output", options.output, "STL, PLY or OBJ to write.")->required();
  options.optimise.add_to(optimise, {"lattice", "grow", "optimise"});
  CLI::App& verify = command(app, options, "verify", "A mesh judged: topology, crossings, angles, distances.");
  verify.add_option("mesh", options.input, "STL, OBJ, OFF or PLY, mm.")->required();
  verify.add_option("--cloud", options.inputs, "Cloud file, .conf file or scan plan; may be given again.")
      ->allow_extra_args(false);
  verify
      .add_option(
          "--section", options.sections.planes,
          "Plane through mesh and cloud: z=12.5, x=worst, y=loop, z=3x (three), 1,1,0=5, x=1,2,3 (a point), or a "
          "map as in the job; may be given again.")
      ->allow_extra_args(false);
  verify.add_option("-o,--output", options.sections.folder, "Folder for the sections as SVG, DXF and PNG.");
  options.verify.add_to(verify, {"", "lattice", "verify", "sensor"});
  CLI::App& compare = command(app, options, "compare", "Two meshes against each other.");
  compare.add_option("a", options.input, "STL, OBJ, OFF or PLY.")->required();
  compare.add_option("b", options.second, "STL, OBJ, OFF or PLY.")->required();
  options.compare.add_to(compare, {""});
  CLI::App& render = command(app, options, "render", "A picture of a mesh or cloud (PNG).");
  render.add_option("file", options.input, "Mesh or cloud.")->required();
  render.add_option("-o,--output", options.output, "PNG to write.")->required();
  render.add_option("--as", options.picture.as, "points, wire, shaded, patches or error.");
  render.add_option("--view", options.picture.view, "iso, +x, -x, +y, -y, +z or -z.");
  render.add_option("--width", options.picture.width, "Pixels.");
  render.add_option("--height", options.picture.height, "Pixels.");
  render.add_option("--error-range-mm", options.picture.error_range_mm, "Both ends of the error scale.");
  options.render.add_to(render, {""});
  CLI::App& info = command(app, options, "info",
                           "What a cloud (size, spacing, noise, suggested bin), a mesh (quality) or a record holds.");
  info.add_option("file", options.input, "Cloud file, .conf file, scan plan, mesh or record.h5.")->required();
  options.info.add_to(info, {""});
  CLI::App& convert = command(app, options, "convert",
                              "A cloud, posed, in mm, as float64 PLY; or a mesh as STL, PLY, OBJ, IGES, DXF or 3MF.");
  convert.add_option("file", options.input, "Cloud file, .conf file, scan plan or mesh.")->required();
  convert.add_option("output", options.output, "File to write; its suffix says what.")->required();
  convert.add_flag("--points", options.as_points, "Take the vertices of a mesh as a cloud.");
  convert.add_flag("--ascii", options.form.ascii, "STL as text.");
  convert.add_option("--style", options.form.style,
                     "IGES: brep (default), trimmed, patches, wire, surfaces; DXF: faces (default), polyface.");
  options.cloud.add_to(convert, {""});
  CLI::App& audit =
      command(app, options, "audit",
              "Proves a record: its content, inputs and outputs by digest; exit code 4 when one differs.");
  audit.add_option("record", options.audit.record, "record.h5, or the folder of a scan.")->required();
  audit.add_option("--archive", options.audit.archive, "Folder with the inputs; run.json of the output tree says it.");
  audit.add_flag("--rerun", options.audit.rerun, "Make the scan again from record and archive alone, and compare.");
  CLI::App& simulate = command(app, options, "simulate",
                               "Views of an object from the stations of a scan plan, as a rig would take them.");
  options.simulate.add_to(simulate);
  CLI::App& fringes = command(app, options, "fringes", "Fringe pictures to phases, a quality mask and a range map.");
  fringes.add_option("description", options.input, "Text that names the pictures (docs/formats.md).")->required();
  fringes.add_option("-o,--out", options.output, "Folder to write.")->required();
  CLI::App& replay =
      command(app, options, "replay", "The motions of a scan plan offline: limits, times, poses, cloud.");
  replay.add_option("plan", options.input, "Scan plan.")->required();
  replay.add_option("-o,--out", options.output,
                    "Folder to write; the plan's name with .replay in the current folder by default.");
  replay.add_option("--bin-mm", options.replay.bin_mm, "Bins of the coverage; ten sensor pixels unless given.")
      ->check(CLI::PositiveNumber);
  replay.add_flag("--no-cloud", options.replay.no_cloud, "Do not write the merged cloud.");
  replay.add_flag("--no-pictures", options.replay.no_pictures, "Do not draw.");
  CLI::App& plan = command(app, options, "plan", "Scan plans from and to other programs, and stations for a machine.");
  options.plan.add_to(plan, [&](CLI::App& group, const char* name, const char* help) -> CLI::App& {
    return command(group, options, name, help);
  });
  CLI::App& bench =
      command(app, options, "bench", "How fast each stage, or a whole job, is on this machine and on these points.");
  bench.add_option(
      "stage", options.timing.stage,
      document::joined(pipeline::bench_stage_words()) +
          ", a job file, or scale: the whole job over made clouds of growing size; all stages unless given.");
  bench.add_option("--file", options.timing.file,
                   "Cloud file, .conf file or scan plan; a made sphere of a million points unless given.");
  bench.add_option("--repeat", options.timing.repeats, "Times each stage runs; 5 if not given.")
      ->check(CLI::Range(1, 1000));
  bench.add_option("--against", options.timing.against, "Earlier --out document; a confirmed slowdown ends with 4.");
  bench.add_option("--out", options.timing.out, "JSON document to write; scale: folder for scale.json and scale.png.");
  bench.remove_option(bench.get_option("--threads"));
  bench.add_option("--threads", options.scale.threads, "Threads to use; all by default; scale: numbers such as 1,2.")
      ->delimiter(',')
      ->check(CLI::Range(1, 1024));
  bench
      .add_option("--points", options.scale.points, "scale: numbers of points such as 1e6,1e7; 1e5,1e6,1e7 by default.")
      ->delimiter(',');
  bench
      .add_option("--bricks", options.scale.bricks,
                  "scale: edges of bricks in bins such as 0,64,256 (as brick.edge_bins); 0, the default: in one piece.")
      ->delimiter(',')
      ->check(CLI::IsMember({0, 8, 16, 32, 64, 128, 256}));
  bench.add_option("--per-bin", options.scale.per_bin, "scale: points a bin, which chooses its size; 60 by default.")
      ->check(CLI::Range(0.1, 1e6));
  bench.add_option("--seed", options.scale.seed, "scale: of the clouds' noise; 1 by default.");
  bench.add_flag("--views", options.scale.as_views, "scale: a file per view in place of one file.");
  bench.add_flag("--keep", options.scale.keep, "scale: leave clouds and output trees below --out.");
  bench.add_option("--generate", options.scale.generate,
                   "scale: write the cloud of --points to this PLY, or a file per view to this folder, and no more.");
  options.bench.add_to(bench, {"", "lattice"});
  CLI::App& schema = command(app, options, "schema", "A JSON schema of what users write or scripts read.");
  schema.add_option("name", options.schema, document::joined(schema_names()))->required();
}

/// A command line that cannot be followed; `json` before it was parsed, so looked for by hand.
int refuse(const std::string& sentence, bool json) {
  runner::ConsoleOptions options;
  options.json = json;
  runner::Console(options).complain(fail(Code::BadUsage, "scanmill: " + sentence));
  return runner::kExitUsage;
}

std::string with_nearest(const std::string& sentence, const std::string& word,
                         const std::vector<std::string>& candidates) {
  const std::vector<std::string_view> views(candidates.begin(), candidates.end());
  const std::string_view nearest = nearest_name(word, views);
  return sentence + (nearest.empty() ? "" : "; nearest " + std::string(nearest));
}

/// The first word that nothing takes, as a sentence; empty when there is none.
std::string unknown_word(const CLI::App& app) {
  const auto subs = app.get_subcommands();
  if (subs.empty()) {
    const auto rest = app.remaining();
    if (rest.empty()) return {};
    std::vector<std::string> names;
    for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
      names.push_back(sub->get_name());
    std::string all;
    for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
    if (rest[0].starts_with('-')) return with_nearest("unknown option " + rest[0], rest[0], {"--version", "--help"});
    return with_nearest("unknown command " + rest[0] + "; allowed " + all, rest[0], names);
  }
  const CLI::App& sub = *subs[0];
  if (!sub.get_subcommands([](const CLI::App*) { return true; }).empty()) return unknown_word(sub);
  std::vector<std::string> options;
  for (const CLI::Option* option : sub.get_options())
    for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
  const auto rest = sub.remaining();
  for (const std::string& word : rest)
    if (word.size() > 1 && word.front() == '-')
      return with_nearest(sub.get_name() + ": unknown option " + word, word.substr(0, word.find('=')), options) +
             "; scanmill " + sub.get_name() + " --help lists all";
  return rest.empty() ? std::string()
                      : sub.get_name() + ": " + rest[0] + " is one word too many; scanmill " + sub.get_name() +
                            " --help shows the use";
}

/// A path of the command line that leads nowhere is a slip there, whatever the command would have made of the file.
Result<void> inputs_are_there(const std::string& name, const Options& o) {
  std::vector<std::string> files = name.starts_with("plan ") ? o.plan.named_files()
                                   : name == "simulate"      ? o.simulate.named_files()
                                                             : o.inputs;
  for (const std::string& file : {o.input, o.second, o.audit.record, o.timing.file, o.timing.against})
    files.push_back(file);
  for (const std::string& file : files) {
    std::error_code error;
    if (!file.empty() && std::filesystem::status(file, error).type() == std::filesystem::file_type::not_found)
      return fail(Code::BadUsage, "there is no such file; check the path", file);
  }
  return {};
}

Result<pipeline::ToolReport> run_stage(const std::string& name, const Options& o, const pipeline::What& what,
                                       const Context& context, Progress& progress) {
  TRY(inputs_are_there(name, o));
  if (name == "init")
    return pipeline::write_first_job(o.input, o.output.empty() ? "job.yaml" : o.output, context, progress);
  if (name == "fringes") return pipeline::decode_fringe_file(o.input, o.output, progress);
  if (name == "simulate") return o.simulate.run(context, progress);
  if (name.starts_with("plan ")) return o.plan.run(name.substr(5), context, progress);
  if (name == "replay") return pipeline::replay_plan(o.input, o.output, o.replay, context, progress);
  if (name == "reduce") return pipeline::reduce_to_file(o.inputs, what, o.output, context, progress);
  if (name == "mesh") return pipeline::mesh_to_file(o.inputs, what, o.as_is, o.output, context, progress);
  if (name == "optimise") return pipeline::optimise_file(o.input, what, o.output, context, progress);
  if (name == "verify") return pipeline::verify_file(o.input, o.inputs, o.sections, what, context, progress);
  if (name == "compare") return pipeline::compare_files(o.input, o.second, what, context, progress);
  if (name == "render") return pipeline::render_file(o.input, what, o.picture, o.output, context, progress);
  if (name == "audit") return pipeline::audit_record(o.audit, context, progress);
  if (name == "bench" && o.timing.stage == "scale") {
    pipeline::ScaleChoice scale = o.scale;
    scale.out = o.timing.out;
    scale.memory = o.common.memory;
    scale.executable = "/proc/self/exe";
    scale.version = version();
    scale.cores = runner::usable_cores();
    scale.processor = runner::processor_name();
    return pipeline::bench_scale(scale, context, progress);
  }
  if (name == "bench") {
    pipeline::BenchChoice timing = o.timing;
    timing.version = version();
    timing.cores = runner::usable_cores();
    timing.processor = runner::processor_name();
    return pipeline::bench_stages(timing, what, context, progress);
  }
  if (name == "info") {
    TRY_ASSIGN(const bool is_record, pipeline::is_record_file(o.input));
    if (is_record) return pipeline::record_info(o.input, progress);
  }
  TRY_ASSIGN(const bool is_mesh, pipeline::is_mesh_file(o.input));
  if (name == "info")
    return is_mesh ? pipeline::mesh_info(o.input, what, context, progress)
                   : pipeline::cloud_info(o.input, what, context, progress);
  return is_mesh && !o.as_points ? pipeline::convert_mesh(o.input, what, o.form, o.output, context, progress)
                                 : pipeline::convert_cloud(o.input, what, o.output, context, progress);
}

int print_schema_line(const std::string& name, const std::string& text) {
  const auto tree = document::parse_json(text, name);
  if (!tree) return refuse(tree.error().text(), true);
  document::Node line = document::Node::map();
  line.set("type", "schema");
  line.set("name", name);
  line.set("schema", *tree);
  std::printf("%s\n", document::to_json(line).c_str());
  return runner::kExitGood;
}

/// A stage is a word; a job is a file.
bool is_job_file(const std::string& word) {
  return word.ends_with(".yaml") || word.ends_with(".yml") || word.ends_with(".json") ||
         word.find('/') != std::string::npos;
}

/// An option that only `bench scale` takes; empty when none was given.
std::string scale_option_of(const pipeline::ScaleChoice& scale) {
  return !scale.points.empty()      ? "--points"
         : !scale.bricks.empty()    ? "--bricks"
         : !scale.generate.empty()  ? "--generate"
         : scale.as_views           ? "--views"
         : scale.keep               ? "--keep"
         : scale.threads.size() > 1 ? "several --threads"
                                    : "";
}

int dispatch(const CLI::App& app, Options& options) {
  const CLI::App& sub = *app.get_subcommands()[0];
  const std::string name =
      sub.get_subcommands().empty() ? sub.get_name() : sub.get_name() + " " + sub.get_subcommands()[0]->get_name();
  if (name == "run") return run_run(options.common, options.run, g_stop);
  if (name == "status" || name == "cancel" || name == "gc")
    return run_operation(options.common, name, options.input, options.run.dry_run);
  if (name == "worklist") return run_worklist(options.common, {options.run, options.output, options.worklist_tasks});
  if (name == "task") return run_task(options.common, options.input, options.task_index, g_stop);
  if (name == "retry") return run_retry(options.common, options.input, options.inputs, g_stop);
  if (name == "check") return run_check(options.common, options.input, options.run.sets, g_stop);
  if (name == "schema") {
    const auto text = schema_text(options.schema);
    if (!text) return refuse(text.error().message, options.common.json);
    if (options.common.json) return print_schema_line(options.schema, *text);
    std::fputs(text->c_str(), stdout);
    return runner::kExitGood;
  }
  if (name == "bench" && options.timing.stage == "scale") {
    if (!options.timing.file.empty() || !options.timing.against.empty())
      return refuse("bench scale: found --file or --against; it makes its clouds itself and compares with nothing",
                    options.common.json);
  } else if (name == "bench") {
    if (const std::string option = scale_option_of(options.scale); !option.empty())
      return refuse("bench: found " + option + ", which belongs to bench scale", options.common.json);
    if (!options.scale.threads.empty()) options.common.threads = options.scale.threads[0];
  }
  if (name == "bench" && is_job_file(options.timing.stage)) {
    if (!options.timing.file.empty())
      return refuse("bench: found both a job and --file; a job names its archive itself", options.common.json);
    runner::BenchJobOptions job;
    job.job = options.timing.stage;
    job.against = options.timing.against;
    job.out = options.timing.out;
    job.repeats = options.timing.repeats;
    return run_bench_job(options.common, std::move(job), g_stop);
  }
  const bool needs_bin = name == "reduce" || (name == "mesh" && !options.as_is);
  const auto what = options.stage(name).what(needs_bin);
  return run_tool(options.common, name, g_stop,
                  [&](const Context& context, Progress& progress) -> Result<pipeline::ToolReport> {
                    if (!what) return what.error();
                    return run_stage(name, options, *what, context, progress);
                  });
}

}  // namespace

int run(int argc, char** argv) {
  try {
    CLI::App app("From raw multi-view range scans to one clean mesh with its record.", "scanmill");
    app.require_subcommand(1);
    app.allow_extras();
    app.set_version_flag("--version", version_text());
    Options options;
    add_job_commands(app, options);
    add_tool_commands(app, options);
    const bool json =
        std::any_of(argv + 1, argv + argc, [](const char* word) { return std::string(word) == "--json"; });
    try {
      app.parse(argc, argv);
    } catch (const CLI::CallForHelp& help) {
      return app.exit(help);
    } catch (const CLI::CallForVersion& shown) {
      if (json) return std::puts(version_line().c_str()) < 0 ? runner::kExitInternal : runner::kExitGood;
      return app.exit(shown);
    } catch (const CLI::ParseError& error) {
      const std::string unknown = unknown_word(app);
      return refuse(unknown.empty() ? std::string(error.what()) + "; scanmill --help shows the use" : unknown, json);
    }
    if (const std::string unknown = unknown_word(app); !unknown.empty()) return refuse(unknown, json);
    install_handlers();
    return dispatch(app, options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "scanmill: unexpected: %s\n", error.what());
    return runner::kExitInternal;
  }
}

}  // namespace scanmill::cli
