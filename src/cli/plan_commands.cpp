// SPDX-License-Identifier: Apache-2.0
#include "cli/plan_commands.hpp"

#include <CLI/CLI.hpp>

namespace scanmill::cli {

void PlanOptions::add_to(CLI::App& group, const MakeCommand& make) {
  group.require_subcommand(1);
  CLI::App& import = make(group, "import", "Poses or machine limits of other programs as a scan plan.");
  import.add_option("inputs", inputs_, ".conf, .aln, .log, .xf, text of 4x4 matrices, PTX, 3DTK .pose, LinuxCNC .ini.")
      ->required();
  import.add_option("-o,--output", output_, "Plan to write, beside or above its views; to the terminal unless given.");
  import.add_option("--machine", import_.machine, "Scan plan whose machine and sensor are taken over.");
  import.add_option("--units", import_.units, "mm, cm, m, in or um; guessed from the first view unless given.");
  import.add_option("--files", import_.files, "Pattern of the views where poses come by order, e.g. 'depth/*.png'.");
  import.add_option("--every", import_.every, "Of the views the first, and every so many.");
  import.add_option("--intrinsics", import_.intrinsics, "fx,fy,cx,cy of depth maps.");
  import.add_option("--depth-scale", import_.depth_scale, "Pixel values of depth maps per unit; 1000 unless given.")
      ->check(CLI::PositiveNumber);
  import.add_flag("--hash", import_.hash, "Write the SHA-256 of every view into the plan.");

  CLI::App& out = make(group, "export", "A scan plan as G-code moves or as poses for other programs.");
  out.add_option("plan", input_, "Scan plan.")->required();
  out.add_option("--as", as_, "gcode, conf, aln, log, xf or 3dtk; gcode unless given.");
  out.add_option("-o,--output", output_, "File to write (3dtk: folder); to the terminal unless given.");

  CLI::App& solve = make(group, "solve", "Wanted poses or surface targets to joints, shaft turns and counts.");
  solve.add_option("plan", input_, "Scan plan with poses, targets or joints.")->required();
  solve.add_option("--machine", machine_, "Scan plan whose machine and sensor are taken in place of its own.");
  solve.add_option("-o,--output", output_, "Plan to write; to the terminal unless given.");

  CLI::App& propose = make(group, "propose", "Stations that see all of an object, in an order with short travel.");
  propose.add_option("machine", input_, "Scan plan with machine and sensor; its stations are not used.")->required();
  propose.add_option("--object", propose_.object, "First mesh of the object (STL, OBJ, OFF, PLY), global frame, mm.");
  propose.add_option("--box", propose_.box, "x0,y0,z0,x1,y1,z1: the object as a box, in place of a mesh.");
  propose.add_option("-o,--output", output_, "Plan to write; to the terminal unless given.");
  propose
      .add_option("--bin-mm", propose_.bin_mm, "Edge of the bins to be seen; a fiftieth of the object unless given.")
      ->check(CLI::PositiveNumber);
  propose
      .add_option("--max-angle-deg", propose_.max_angle_deg,
                  "A bin counts as seen up to this incidence; 60 unless given.")
      ->check(CLI::Range(5.0, 85.0));
  propose.add_option("--coverage", propose_.coverage, "Share of the visible bins that is enough; 0.995 unless given.")
      ->check(CLI::Range(0.1, 1.0));
  propose.add_option("--max-stations", propose_.max_stations, "Stop at so many; 500 unless given.")
      ->check(CLI::Range(1, 100000));

  CLI::App& calibrate =
      make(group, "calibrate", "Where the sensor sits on its mount, from views of a sphere or plane.");
  calibrate
      .add_option("plans", calibrate_.plans,
                  "Scan plans with their views, one per night; what changes from the first on is drift.")
      ->required();
  calibrate.add_option("--target", calibrate_.target, "sphere or plane: what stayed on the deck.")->required();
  calibrate.add_option("--radius-mm", calibrate_.radius_mm, "Of the sphere, as certified; found unless given.")
      ->check(CLI::PositiveNumber);
  calibrate
      .add_option("--axes", calibrate_.axes, "Rotary joints whose place and zero are looked for as well, e.g. a,b.")
      ->delimiter(',')
      ->allow_extra_args(false);
  calibrate.add_option("-o,--output", output_, "Plan to write: the last one with what was found.");
}

std::vector<std::string> PlanOptions::named_files() const {
  std::vector<std::string> files = inputs_;
  for (const std::string& file : {input_, machine_, import_.machine, propose_.object}) files.push_back(file);
  files.insert(files.end(), calibrate_.plans.begin(), calibrate_.plans.end());
  return files;
}

Result<pipeline::ToolReport> PlanOptions::run(const std::string& name, const Context& context,
                                              Progress& progress) const {
  if (name == "import") return pipeline::import_plan(inputs_, import_, output_, context, progress);
  if (name == "export") return pipeline::export_plan(input_, as_, output_);
  if (name == "solve") return pipeline::solve_plan(input_, machine_, output_);
  if (name == "calibrate") return pipeline::calibrate_plans(calibrate_, output_, context, progress);
  return pipeline::propose_plan(input_, propose_, output_, context, progress);
}

}  // namespace scanmill::cli
