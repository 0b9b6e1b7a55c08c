// SPDX-License-Identifier: Apache-2.0
// Other programs, started from a process that may have threads.
#pragma once
#include <spawn.h>
#include <sys/types.h>

#include <string>
#include <vector>

namespace scanmill {

/// A program about to be started: without input, with no signal blocked or ignored.
class Spawn {
 public:
  /// In a group of its own Ctrl-C does not hit it, and a time-out can hit all that it starts.
  enum class Group { Own, Ours };
  explicit Spawn(Group group = Group::Own);
  ~Spawn();
  Spawn(const Spawn&) = delete;
  Spawn& operator=(const Spawn&) = delete;

  void append_to(const std::string& file, int stream);
  void send_to(int from, int stream);
  void run_in(const std::string& folder);

  /// Starts `words[0]`, looked for on the PATH, with `variables` (NAME=VALUE) as its whole environment. 0, or errno.
  int start(std::vector<std::string> words, std::vector<std::string> variables, pid_t& pid);

 private:
  posix_spawn_file_actions_t files_;
  posix_spawnattr_t attributes_;
};

}  // namespace scanmill
