// SPDX-License-Identifier: Apache-2.0
#include "cli/simulate_options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "base/text.hpp"

namespace scanmill::cli {

void SimulateOptions::add_to(CLI::App& command) {
  command.add_option("plan", choice_.plan, "Scan plan.")->required();
  command
      .add_option("--object", choice_.object,
                  "figurine, handset, sphere, torus or cube; or a mesh file (global frame, mm).")
      ->required();
  command.add_option("--out", choice_.folder, "Folder for views, plan and truth.")->required();
  command.add_option("--seed", choice_.seed, "Seed of all that is drawn.")
      ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1} << 53));
  command.add_option("--format", choice_.format,
                     "ply, xyz, ptx, pcd, png or fringes: of all views, in place of what the plan names.");
  command
      .add_option("--fringe-periods", choice_.fringes.periods_mm,
                  "Periods of the gratings on the plate, mm, the coarsest first.")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->group("Fringes");
  command.add_option("--fringe-steps", choice_.fringes.steps, "Shifts of each grating.")
      ->check(CLI::Range(3, 64))
      ->group("Fringes");
  command.add_option("--fringe-bits", choice_.fringes.bits, "8 or 16.")
      ->check(CLI::IsMember({8, 16}))
      ->group("Fringes");
  command.add_option("--fringe-noise", choice_.fringes.noise_levels, "Noise of brightness, in 255ths of white.")
      ->check(CLI::Range(0.0, 100.0))
      ->group("Fringes");
  command.add_flag("--keep-out", choice_.keep_out, "The plan's keep_out bodies (deck, fixture) stand in view.");
  for (const Field& field : simulate::Effects::fields()) {
    std::string name = "--" + std::string(field.name);
    std::replace(name.begin(), name.end(), '_', '-');
    const CLI::Validator limits = CLI::Range(field.minimum, field.maximum);
    if (const auto* number = std::get_if<double* (*)(void*)>(&field.member))
      command.add_option(name, *(*number)(&choice_.effects), std::string(field.help))->check(limits)->group("Effects");
    else if (const auto* count = std::get_if<std::int64_t* (*)(void*)>(&field.member))
      command.add_option(name, *(*count)(&choice_.effects), std::string(field.help))->check(limits)->group("Effects");
  }
}

}  // namespace scanmill::cli
