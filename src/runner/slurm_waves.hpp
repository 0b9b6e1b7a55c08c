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
/// A file that a task touches while it works.
struct SignOfLife {
  std::string path;
  std::size_t index = 0;  // of the task
  std::int64_t time_ns = 0;
};
std::vector<SignOfLife> signs_of(const WaveFolder& wave);
/// Seconds ago, by the clock of the wave's file system, which stamps the signs too.
double age_by_folder(const WaveFolder& wave, std::int64_t time_ns);

/// Cancels what Slurm has of open waves and closes them, and worklists that were made for other engines, which are at
/// rest (task_signs.hpp); `keep_slurm`: only the latter. Returns how many were closed.
std::size_t abandon_waves(const OutputTree& tree, bool keep_slurm);

}  // namespace scanmill::runner
