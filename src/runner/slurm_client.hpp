// SPDX-License-Identifier: Apache-2.0
// Slurm by its commands: the library behind them changes with every release, the commands do not.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "runner/cluster_keys.hpp"
#include "runner/slurm_command.hpp"

namespace scanmill::runner {

/// An element of an array as squeue shows it.
struct QueueRow {
  std::string name;  // of the job
  std::string job;   // number of the array
  std::size_t index = 0;
  bool is_rest = false;  // all elements of the array that have no row of their own
  std::string state;     // a word
  int wait_status = 0;   // as wait(2) gives it, once it ended
  std::string reason;    // why it waits, or failed
  std::string node;      // that it has, or had
  int restarts = 0;      // times that Slurm put it back into the queue; -1: not told
};

/// Nodes that Slurm gives no work, and why, as `sinfo --list-reasons` has them.
struct IdleNodes {
  std::string state, nodes, reason;
};

/// The rows of `squeue -O` in our columns; nothing when a line has another form: the answer is not to be trusted then.
std::optional<std::vector<QueueRow>> queue_rows(const std::string& text);

/// An array to be submitted.
struct ArraySpec {
  std::string name;       // unique
  std::size_t count = 1;  // elements 0 to count - 1
  int threads = 1;
  std::uint64_t memory = 0;  // of an element
  double seconds = 0;        // time limit of an element
  std::string folder;        // for logs: <folder>/<index>.log
  std::string script;        // file to run
};

/// Submissions that failed: whether trying again can help.
struct SubmitFault {
  bool passing = false;
  std::string text;  // Slurm's own words
};

class SlurmClient {
 public:
  explicit SlurmClient(std::function<bool()> give_up = {}) : give_up_(std::move(give_up)) {}

  /// Number of the array; a fault otherwise. A passing one may hide that the job was taken: look its name up first.
  std::optional<std::string> submit(const ArraySpec& spec, const ClusterKeys& keys, SubmitFault& fault) const;
  /// All elements of arrays of these names, ended ones too as long as Slurm remembers them (MinJobAge). One command.
  /// errors  IoFailed in Slurm's words: no answer
  Result<std::vector<QueueRow>> look(const std::vector<std::string>& names) const;
  /// Cancels all elements of arrays of this name that are in the state (all when empty), or just get this signal.
  Result<void> cancel(const std::string& name, const std::string& state, const std::string& signal) const;
  /// One element.
  Result<void> cancel_element(const std::string& job, std::size_t index) const;
  /// A job that never starts, and its number: the next one gets a higher one. Nothing when Slurm does not take it.
  std::optional<std::uint64_t> take_number(const std::string& name, const ClusterKeys& keys) const;
  /// Nodes that are drained, down or failing; empty when Slurm does not say.
  std::vector<IdleNodes> idle_nodes(const std::string& partition) const;
  /// Memory of the largest node in bytes; nothing when Slurm does not say.
  std::optional<std::uint64_t> largest_node(const std::string& partition) const;
  /// A value of `scontrol show config`.
  std::optional<std::uint64_t> setting(const std::string& key) const;

 private:
  std::function<bool()> give_up_;
};

/// Whether sbatch's complaint may pass: the controller does not answer, is starting, or a limit on jobs is reached.
bool is_passing(const std::string& complaint);
/// A text as a word for a shell.
std::string shell_word(const std::string& text);

}  // namespace scanmill::runner
