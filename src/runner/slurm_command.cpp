// SPDX-License-Identifier: Apache-2.0
#include "runner/slurm_command.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string_view>
#include <thread>

#include "base/spawn.hpp"
#include "base/text.hpp"

extern char** environ;

namespace scanmill::runner {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kTick = std::chrono::milliseconds(100);
constexpr int kLastSignal = 31;
constexpr std::size_t kMostText = 64u << 20;  // of a reply; 1,200 jobs take 0.3 MB

std::vector<std::string> environment() {
  static constexpr std::string_view kTaken[] = {"SLURM_", "SBATCH_", "SQUEUE_", "SCANCEL_",
                                                "SINFO_", "SALLOC_", "SRUN_"};
  std::vector<std::string> kept;
  for (char** one = environ; *one; ++one) {
    const std::string_view variable = *one;
    const bool taken = std::any_of(std::begin(kTaken), std::end(kTaken),
                                   [&](std::string_view prefix) { return variable.starts_with(prefix); });
    if (!taken || variable.starts_with("SLURM_CONF=")) kept.emplace_back(variable);
  }
  kept.emplace_back("SLURM_TIME_FORMAT=standard");
  return kept;
}

struct Pipe {
  int ends[2] = {-1, -1};
  ~Pipe() {
    for (const int end : ends)
      if (end >= 0) close(end);
  }
  void close_end(int which) {
    close(ends[which]);
    ends[which] = -1;
  }
};

/// True while there may be more.
bool receive(int file, std::string& text) {
  char buffer[1 << 16];
  const ssize_t n = read(file, buffer, sizeof buffer);
  if (n < 0) return errno == EINTR || errno == EAGAIN;
  if (text.size() < kMostText) text.append(buffer, static_cast<std::size_t>(n));
  return n > 0;
}

}  // namespace

std::string CommandReply::problem() const {
  if (!started) return err;
  if (timed_out) return "no answer in time";
  std::string line;
  for (const std::string& one : lines_of(err.empty() ? out : err))
    if (!words_of(one).empty()) line += (line.empty() ? "" : "; ") + one;
  return line.empty() ? "exit code " + std::to_string(status) : line.substr(0, 500);
}

CommandReply run_command(const std::vector<std::string>& words, std::chrono::milliseconds limit,
                         const std::function<bool()>& give_up) {
  CommandReply reply;
  Pipe out, err;
  if (pipe2(out.ends, O_CLOEXEC) != 0 || pipe2(err.ends, O_CLOEXEC) != 0) {
    reply.err = std::string("no pipe for ") + words[0] + ": " + std::strerror(errno);
    return reply;
  }
  Spawn spawn;
  spawn.send_to(out.ends[1], 1);
  spawn.send_to(err.ends[1], 2);
  pid_t pid = 0;
  if (const int error = spawn.start(words, environment(), pid)) {
    reply.err = words[0] + " could not be started: " + std::strerror(error) +
                "; wanted Slurm's commands on the PATH, as on a login node";
    return reply;
  }
  reply.started = true;
  out.close_end(1);
  err.close_end(1);
  const auto until = Clock::now() + limit;
  bool more_out = true, more_err = true;
  while (more_out || more_err) {
    if (Clock::now() >= until || (give_up && give_up())) {
      reply.timed_out = true;
      kill(-pid, SIGKILL);
      break;
    }
    pollfd polled[] = {{more_out ? out.ends[0] : -1, POLLIN, 0}, {more_err ? err.ends[0] : -1, POLLIN, 0}};
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now());
    if (poll(polled, 2, static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, kTick.count()))) <= 0) continue;
    if (polled[0].revents != 0) more_out = receive(out.ends[0], reply.out);
    if (polled[1].revents != 0) more_err = receive(err.ends[0], reply.err);
  }
  // Both pipes are closed, so it is about to end; one that closed them and lives on is not waited for.
  int status = 0;
  for (;;) {
    const pid_t found = waitpid(pid, &status, WNOHANG);
    if (found == pid || (found < 0 && errno != EINTR)) break;
    if (Clock::now() >= until && !reply.timed_out) {
      reply.timed_out = true;
      kill(-pid, SIGKILL);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  reply.status = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  // A site's wrapper of the command tells of a signal as shells do. 255 is sbatch's own word for a wrong option.
  if (reply.status > 128 && reply.status <= 128 + kLastSignal) reply.signal = reply.status - 128;
  return reply;
}

}  // namespace scanmill::runner
