// SPDX-License-Identifier: Apache-2.0
#include "runner/notify.hpp"

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <thread>

#include "base/spawn.hpp"
#include "base/text.hpp"
#include "base/utf8.hpp"
#include "runner/advice.hpp"
#include "runner/last_words.hpp"

extern char** environ;

namespace scanmill::runner {

using document::Node;

namespace {

constexpr std::string_view kWords[] = {"always", "failure", "success"};
constexpr std::string_view kOwnKeys[] = {"run"};
constexpr std::chrono::milliseconds kGrace{2000};  // between asking a command to end and ending it

std::span<const Field> rule_fields() {
  static const Field kTable[] = {
      field<NotifyRule, &NotifyRule::on>("on", "",
                                         "After which runs: every one, those with another exit code than 0, or those "
                                         "with 0.",
                                         {}, kWords),
  };
  return kTable;
}

std::string absolute(const std::string& path) {
  std::error_code error;
  const auto whole = std::filesystem::absolute(path, error);
  return error ? path : whole.lexically_normal().string();
}

/// Ours in front of what the process has; none of ours from outside.
std::vector<std::string> environment_of(const RunReport& report, const OutputTree& tree) {
  std::vector<std::string> variables{"SCANMILL_RUN=" + (report.written ? absolute(tree.run_file()) : std::string()),
                                     "SCANMILL_EXIT=" + std::to_string(report.exit_code),
                                     "SCANMILL_OUT=" + absolute(tree.root()), "SCANMILL_SUMMARY=" + last_line(report),
                                     "SCANMILL_VERDICT=" + verdict_of(report)};
  const std::size_t ours = variables.size();
  for (char** at = environ; *at; ++at) {
    const std::string_view variable(*at);
    const auto same_name = [&](const std::string& own) {
      return variable.substr(0, variable.find('=')) == std::string_view(own).substr(0, own.find('='));
    };
    if (std::none_of(variables.begin(), variables.begin() + static_cast<std::ptrdiff_t>(ours), same_name))
      variables.emplace_back(variable);
  }
  return variables;
}

/// A shell that appends what it prints to `log`.
std::optional<std::string> start(const std::string& command, const std::string& folder, const std::string& log,
                                 const std::vector<std::string>& variables, pid_t& pid) {
  Spawn spawn;
  spawn.append_to(log, 1);
  spawn.send_to(1, 2);
  spawn.run_in(folder);
  if (const int error = spawn.start({"/bin/sh", "-c", command}, variables, pid))
    return std::string(std::strerror(error));
  rlimit limit;  // the run's memory cap is not the command's
  if (prlimit(pid, RLIMIT_DATA, nullptr, &limit) == 0) {
    limit.rlim_cur = limit.rlim_max;
    prlimit(pid, RLIMIT_DATA, &limit, nullptr);
  }
  return std::nullopt;
}

/// True when the process ended in time; its status then.
bool ended_within(pid_t pid, std::chrono::milliseconds limit, int& status) {
  const auto until = std::chrono::steady_clock::now() + limit;
  auto pause = std::chrono::milliseconds(1);
  for (;;) {
    const pid_t found = waitpid(pid, &status, WNOHANG);
    if (found == pid) return true;
    if (found < 0 && errno != EINTR) {
      status = 0;  // somebody else has taken its status
      return true;
    }
    const auto left = until - std::chrono::steady_clock::now();
    if (left <= std::chrono::milliseconds(0)) return false;
    std::this_thread::sleep_for(std::min<std::chrono::nanoseconds>(pause, left));
    pause = std::min(pause * 2, std::chrono::milliseconds(50));
  }
}

std::string seconds_text(std::chrono::milliseconds time) {
  return number_text(static_cast<double>(time.count()) / 1000) + " s";
}

/// What went wrong, or nothing.
std::optional<std::string> run_one(const NotifyRule& rule, const std::string& folder, const std::string& log,
                                   const std::vector<std::string>& variables, std::chrono::milliseconds limit) {
  pid_t pid = 0;
  if (const auto error = start(rule.run, folder, log, variables, pid)) return "could not be started: " + *error;
  int status = 0;
  if (!ended_within(pid, limit, status)) {
    kill(-pid, SIGTERM);
    if (!ended_within(pid, kGrace, status)) {
      kill(-pid, SIGKILL);
      (void)ended_within(pid, kGrace, status);
    } else {
      kill(-pid, SIGKILL);  // what it started and left
    }
    return "was ended after " + seconds_text(limit);
  }
  if (WIFSIGNALED(status)) return "ended by signal " + std::to_string(WTERMSIG(status));
  if (WEXITSTATUS(status) != 0) return "ended with exit code " + std::to_string(WEXITSTATUS(status));
  return std::nullopt;
}

bool is_wanted(NotifyOn on, int exit_code) {
  return on == NotifyOn::Always || (on == NotifyOn::Success) == (exit_code == 0);
}

}  // namespace

void read_notify(const Node& value, std::vector<NotifyRule>& rules, document::Problems& problems) {
  if (!value.is_sequence())
    return problems.add(value.mark, "notify",
                        "found " + document::shown(value) + "; allowed a list of {on: always, run: COMMAND}");
  for (const Node& item : value.items()) {
    if (!item.is_map()) {
      problems.add(item.mark, "notify", "found " + document::shown(item) + "; allowed a map of on and run");
      continue;
    }
    NotifyRule rule;
    Node known = item;
    std::erase_if(known.entries(), [](const Node::Entry& entry) { return entry.key == "webhook"; });
    document::read_fields(known, "notify", rule_fields(), &rule, kOwnKeys, problems);
    if (const Node* webhook = item.find("webhook"))
      problems.add(webhook->mark, "notify.webhook",
                   "a run opens no network connection of its own; allowed run: with a command, such as "
                   "run: curl -fsS --data-binary @\"$SCANMILL_RUN\" URL");
    else if (const Node* run = item.find("run"); !run)
      problems.add(item.mark, "notify", "found an entry without run; add run: with a command for /bin/sh");
    else if (!run->is_string() || words_of(run->as_string()).empty() ||
             run->as_string().find('\0') != std::string::npos)
      problems.add(run->mark, "notify.run", "found " + document::shown(*run) + "; allowed a command for /bin/sh");
    else
      rule.run = run->as_string();
    rules.push_back(std::move(rule));
  }
}

Node notify_schema() {
  const NotifyRule defaults;
  Node rule = document::fields_schema(rule_fields(), &defaults, "A command and when to run it.");
  Node run = Node::map();
  run.set("description",
          "For /bin/sh, in the job file's folder, within 60 s, with SCANMILL_RUN (path of run.json), SCANMILL_EXIT, "
          "SCANMILL_OUT, SCANMILL_SUMMARY and SCANMILL_VERDICT in its environment.");
  run.set("type", "string");
  run.set("pattern", "\\S");
  rule.find("properties")->set("run", std::move(run));
  Node required = Node::sequence();
  required.push("run");
  rule.set("required", std::move(required));
  Node schema = Node::map();
  schema.set("description", "Commands to run when a run has ended; one that fails is a note and changes no exit code.");
  schema.set("type", "array");
  schema.set("items", std::move(rule));
  return schema;
}

std::vector<std::string> notify(const std::vector<NotifyRule>& rules, const RunReport& report, const OutputTree& tree,
                                std::chrono::milliseconds limit) {
  std::vector<std::string> notes;
  const std::string job_folder = std::filesystem::path(absolute(report.job_path)).parent_path().string();
  const std::vector<std::string> variables = environment_of(report, tree);
  const std::string log = report.written ? absolute(tree.root()) + "/journal/notify.log" : "/dev/null";
  if (report.written) std::ofstream(log, std::ios::trunc);
  for (const NotifyRule& rule : rules) {
    if (!is_wanted(rule.on, report.exit_code)) continue;
    if (report.written) std::ofstream(log, std::ios::app) << "$ " << rule.run << "\n";
    std::error_code unknown;
    const auto printed = report.written ? std::filesystem::file_size(log, unknown) : 0;
    const auto problem = run_one(rule, job_folder, log, variables, limit);
    if (!problem) continue;
    std::string note = "notify: " + printable(rule.run) + ": " + *problem;
    if (const std::string words = report.written && !unknown ? last_words(log, printed, 1) : ""; !words.empty())
      note += ": " + words;
    notes.push_back(note + "; the run itself is not touched by it");
  }
  return notes;
}

}  // namespace scanmill::runner
