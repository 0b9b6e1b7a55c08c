// SPDX-License-Identifier: Apache-2.0
// OUT/work/<wave>/: an array that was handed to Slurm, with its worklist, its tasks' records, signs of life and logs. A
// wave is open while its worklist is there; a driver that comes after one that died finds it and takes it over.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "runner/output_tree.hpp"
#include "runner/task_file.hpp"

namespace scanmill::runner {

struct WaveFolder {
  std::string folder;
  std::string name;  // of the job; empty: a worklist that was made for other engines

  std::string worklist() const { return folder + "/" + kTaskFileName; }
};

/// "<index>.<number>.began": an element's script ran on a node, under a number that Slurm gave it.
std::string began_name(const std::string& index, const std::string& number);
/// The two numbers of such a name; nothing for another name.
std::optional<std::pair<std::size_t, std::uint64_t>> began_numbers(const std::string& name);

/// "scanmill-<job>-<token>", which no other wave has; letters, digits and '-' only.
std::string wave_job_name(const std::string& job_path, const std::string& token);

/// Writes the folder of a new wave: worklist, script, name; synced.
/// errors  IoFailed, NoSpace naming the file
Result<WaveFolder> make_wave(const OutputTree& tree, const TaskFile& file, const std::string& name,
                             const std::string& script);
/// Waves that are open, in the order of their names.
std::vector<WaveFolder> open_waves(const OutputTree& tree);
/// Whether tasks of open waves may be at work in the tree: what looks left over may be theirs.
bool has_open_waves(const OutputTree& tree);
/// Nothing is put in place by the wave's tasks any more; what is there of the folder is removed as far as possible.
void close_wave(const WaveFolder& wave);
/// The tasks' latest sign of life, seconds ago by the file system's own clock; nothing when there is none.
std::optional<double> latest_sign(const WaveFolder& wave);

/// Cancels what Slurm has of open waves and closes them, and worklists that were made for other engines and are at
/// rest; `keep_slurm`: only the latter. Returns how many were closed. errors  Cancelled when a worklist made for other
/// engines is being worked on
Result<std::size_t> abandon_waves(const OutputTree& tree, bool keep_slurm);

}  // namespace scanmill::runner
