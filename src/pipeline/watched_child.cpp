// SPDX-License-Identifier: Apache-2.0
#include "pipeline/watched_child.hpp"

#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <sstream>
#include <thread>

#include "base/spawn.hpp"

extern char** environ;

namespace scanmill::pipeline {
namespace {

using Clock = std::chrono::steady_clock;
constexpr long kSaid = 1 << 20;

double seconds_of(const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); }

/// The process and those below it. A process that ended between two looks at it is left out.
void add_tree(pid_t pid, std::vector<pid_t>& out) {
  out.push_back(pid);
  const std::string name = std::to_string(pid);
  std::ifstream file("/proc/" + name + "/task/" + name + "/children");
  for (pid_t child = 0; file >> child;) add_tree(child, out);
}

/// Processor seconds of a process and of the children it has waited for.
double cpu_of(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  std::getline(file, text);
  const std::size_t name_end = text.rfind(')');
  if (name_end == std::string::npos) return 0;
  std::istringstream words(text.substr(name_end + 1));
  std::string word;
  for (int field = 3; field < 14; ++field) words >> word;
  double ticks = 0, sum = 0;
  for (int field = 14; field < 18 && words >> ticks; ++field) sum += ticks;  // utime stime cutime cstime
  return sum / static_cast<double>(sysconf(_SC_CLK_TCK));
}

/// Anonymous and shared memory, and all that is resident.
void add_memory_of(pid_t pid, TreeSample& sample) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("VmRSS:") && !line.starts_with("RssAnon:") && !line.starts_with("RssShmem:")) continue;
    const std::uint64_t bytes = std::strtoull(line.c_str() + line.find(':') + 1, nullptr, 10) * 1024;
    (line[0] == 'V' ? sample.resident_bytes : sample.held_bytes) += bytes;
  }
}

TreeSample look_at(pid_t root, Clock::time_point start) {
  TreeSample sample;
  std::vector<pid_t> tree;
  add_tree(root, tree);
  for (const pid_t pid : tree) {
    sample.cpu_s += cpu_of(pid);
    add_memory_of(pid, sample);
  }
  sample.wall_s = std::chrono::duration<double>(Clock::now() - start).count();
  return sample;
}

std::string end_of(std::FILE* file, std::uint64_t& before) {
  std::fseek(file, 0, SEEK_END);
  const long size = std::ftell(file), from = std::max(0L, size - kSaid);
  std::fseek(file, from, SEEK_SET);
  before = static_cast<std::uint64_t>(from);
  std::string text(static_cast<std::size_t>(size - from), '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file));
  return text;
}

}  // namespace

Result<ChildRun> run_watched(const std::vector<std::string>& words, int interval_ms, const Context& context) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> output(std::tmpfile(), std::fclose);
  if (!output) return fail(Code::IoFailed, "no temporary file can be made", "TMPDIR");
  Spawn spawn(Spawn::Group::Ours);
  spawn.send_to(fileno(output.get()), 1);
  spawn.send_to(fileno(output.get()), 2);
  std::vector<std::string> variables;
  for (char** variable = environ; *variable; ++variable) variables.emplace_back(*variable);
  const auto start = Clock::now();
  pid_t pid = 0;
  const int refused = spawn.start(words, std::move(variables), pid);
  if (refused != 0) return fail(Code::IoFailed, std::string("cannot be started: ") + std::strerror(refused), words[0]);

  ChildRun run;
  bool asked = false;
  int status = 0;
  rusage use{};
  for (;;) {
    run.samples.push_back(look_at(pid, start));
    struct stat about {};
    if (fstat(fileno(output.get()), &about) == 0)
      run.samples.back().said_bytes = static_cast<std::uint64_t>(about.st_size);
    const pid_t ended = wait4(pid, &status, WNOHANG, &use);
    if (ended == pid || (ended < 0 && errno != EINTR)) break;
    if (context.cancel.is_set() && !asked) {
      kill(pid, SIGTERM);
      asked = true;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(interval_ms));
  }
  run.wall_s = std::chrono::duration<double>(Clock::now() - start).count();
  run.cpu_s = seconds_of(use.ru_utime) + seconds_of(use.ru_stime);
  run.exit_code = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  run.said = end_of(output.get(), run.said_from);
  for (const TreeSample& sample : run.samples) {
    run.peak_held = std::max(run.peak_held, sample.held_bytes);
    run.peak_resident = std::max(run.peak_resident, sample.resident_bytes);
  }
  if (asked) return fail(Code::Cancelled, "stopped on request");
  return run;
}

}  // namespace scanmill::pipeline
