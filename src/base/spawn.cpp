// SPDX-License-Identifier: Apache-2.0
#include "base/spawn.hpp"

#include <fcntl.h>

#include <csignal>

namespace scanmill {
namespace {

std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

}  // namespace

Spawn::Spawn(Group group) {
  posix_spawn_file_actions_init(&files_);
  posix_spawnattr_init(&attributes_);
  posix_spawn_file_actions_addopen(&files_, 0, "/dev/null", O_RDONLY, 0);
  sigset_t none, defaults;
  sigemptyset(&none);
  sigemptyset(&defaults);
  for (const int signal : {SIGINT, SIGTERM, SIGPIPE, SIGXFSZ, SIGUSR1}) sigaddset(&defaults, signal);
  posix_spawnattr_setsigmask(&attributes_, &none);
  posix_spawnattr_setsigdefault(&attributes_, &defaults);
  short flags = POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF;
  if (group == Group::Own) {
    posix_spawnattr_setpgroup(&attributes_, 0);
    flags |= POSIX_SPAWN_SETPGROUP;
  }
  posix_spawnattr_setflags(&attributes_, flags);
}

Spawn::~Spawn() {
  posix_spawn_file_actions_destroy(&files_);
  posix_spawnattr_destroy(&attributes_);
}

void Spawn::append_to(const std::string& file, int stream) {
  posix_spawn_file_actions_addopen(&files_, stream, file.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
}

void Spawn::send_to(int from, int stream) { posix_spawn_file_actions_adddup2(&files_, from, stream); }

void Spawn::run_in(const std::string& folder) { posix_spawn_file_actions_addchdir_np(&files_, folder.c_str()); }

int Spawn::start(std::vector<std::string> words, std::vector<std::string> variables, pid_t& pid) {
  const std::vector<char*> arguments = pointers_to(words), environment = pointers_to(variables);
  return posix_spawnp(&pid, arguments[0], &files_, &attributes_, arguments.data(), environment.data());
}

}  // namespace scanmill
