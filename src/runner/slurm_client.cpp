// SPDX-License-Identifier: Apache-2.0
#include "runner/slurm_client.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "base/text.hpp"

namespace scanmill::runner {
namespace {

constexpr auto kLookLimit = std::chrono::seconds(15);
constexpr auto kSubmitLimit = std::chrono::seconds(60);
constexpr auto kCancelLimit = std::chrono::seconds(15);
constexpr std::uint64_t kMiB = 1ull << 20;
constexpr std::size_t kLongestElement = 40, kLongestState = 24, kLongestStatus = 12, kLongestName = 100;
constexpr std::size_t kLongestReason = 100, kLongestNode = 60;
constexpr const char* kColumns = "JobArrayID:40,State:24,exit_code:12,Name:100,Reason:100,NodeList:60,RestartCnt:8";

std::string trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r"), end = text.find_last_not_of(" \t\r");
  return begin == std::string_view::npos ? std::string() : std::string(text.substr(begin, end - begin + 1));
}

template <class Integer>
std::optional<Integer> whole(std::string_view text) {
  Integer value = 0;
  const auto [rest, bad] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (bad != std::errc() || rest != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Of sbatch's reply: "123" or "123;cluster", after whatever a site's plug-ins print.
std::optional<std::uint64_t> number_in(const std::string& reply) {
  for (const std::string& line : lines_of(reply))
    if (const auto number = whole<std::uint64_t>(trimmed(line).substr(0, trimmed(line).find(';')))) return number;
  return std::nullopt;
}

std::optional<QueueRow> row_of(std::string_view line) {
  std::string columns[5];
  constexpr std::size_t kWidths[] = {kLongestElement, kLongestState, kLongestStatus, kLongestName};
  for (std::size_t i = 0; i < 4; ++i) {
    if (line.size() < kWidths[i]) return std::nullopt;
    columns[i] = trimmed(line.substr(0, kWidths[i]));
    line.remove_prefix(kWidths[i]);
  }
  // The last ones are for people, and versions differ in them.
  columns[4] = trimmed(line.substr(0, kLongestReason));
  line.remove_prefix(std::min(line.size(), kLongestReason));
  const std::string node = trimmed(line.substr(0, kLongestNode));
  line.remove_prefix(std::min(line.size(), kLongestNode));
  // "12_3"; what of an array never began and was cancelled is "12", what waits may be "12_[4-9%2]".
  const auto bar = columns[0].find('_');
  const std::string job = columns[0].substr(0, bar);
  const std::string number = bar == std::string::npos ? "" : columns[0].substr(bar + 1);
  const bool is_rest = number.empty() || number.front() == '[';
  const auto index = is_rest ? std::size_t{0} : whole<std::size_t>(number);
  const auto status = whole<int>(columns[2]);
  if (!whole<std::uint64_t>(job) || !index || !status || columns[1].empty() || columns[3].empty()) return std::nullopt;
  return QueueRow{
      columns[3], job, *index, is_rest, columns[1], *status, columns[4], node, whole<int>(trimmed(line)).value_or(-1)};
}

}  // namespace

std::optional<std::vector<QueueRow>> queue_rows(const std::string& text) {
  std::vector<QueueRow> rows;
  for (const std::string& line : lines_of(text)) {
    if (trimmed(line).empty()) continue;
    auto row = row_of(line);
    if (!row) return std::nullopt;
    rows.push_back(*std::move(row));
  }
  return rows;
}

bool is_passing(const std::string& complaint) {
  static constexpr std::string_view kPassing[] = {"unable to contact",
                                                  "connection refused",
                                                  "connection timed out",
                                                  "socket timed out",
                                                  "timed out",
                                                  "temporarily",
                                                  "try again",
                                                  "in standby mode",
                                                  "zero bytes",
                                                  "communication",
                                                  "unexpected message",
                                                  "still being",
                                                  "slurm_load",
                                                  "job submit limit",
                                                  "maxsubmit",
                                                  "maxjobcount",
                                                  "transport",
                                                  "no route to host",
                                                  "network is",
                                                  "not responding",
                                                  "protocol authentication",
                                                  "unable to connect",
                                                  "resource temporarily",
                                                  "no answer in time"};
  std::string lower = complaint;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return std::any_of(std::begin(kPassing), std::end(kPassing),
                     [&](std::string_view words) { return lower.find(words) != std::string::npos; });
}

std::string shell_word(const std::string& text) {
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? "'\\''" : std::string(1, c);
  return word + "'";
}

std::optional<std::string> SlurmClient::submit(const ArraySpec& spec, const ClusterKeys& keys,
                                               SubmitFault& fault) const {
  const auto minutes = static_cast<std::uint64_t>(std::ceil(std::max(60.0, spec.seconds) / 60));
  std::vector<std::string> words = {"sbatch",
                                    "--parsable",
                                    "--no-requeue",
                                    "--open-mode=append",
                                    "--job-name=" + spec.name,
                                    "--array=0-" + std::to_string(spec.count - 1),
                                    "--nodes=1",
                                    "--ntasks=1",
                                    "--cpus-per-task=" + std::to_string(spec.threads),
                                    "--mem=" + std::to_string((spec.memory + kMiB - 1) / kMiB) + "M",
                                    "--time=" + std::to_string(minutes),
                                    "--output=" + spec.folder + "/%a.log"};
  if (!keys.partition.empty()) words.push_back("--partition=" + keys.partition);
  if (!keys.account.empty()) words.push_back("--account=" + keys.account);
  if (!keys.qos.empty()) words.push_back("--qos=" + keys.qos);
  words.insert(words.end(), keys.extra.begin(), keys.extra.end());
  words.push_back(spec.script);
  const CommandReply reply = run_command(words, kSubmitLimit, give_up_);
  if (reply.ok()) {
    if (const auto number = number_in(reply.out)) return std::to_string(*number);
    fault = {true, "sbatch said '" + trimmed(reply.out).substr(0, 200) + "' instead of a job's number"};
    return std::nullopt;
  }
  fault.text = reply.problem();
  // One that was killed may have been on its way; one that is not there never comes.
  fault.passing = reply.started && (reply.timed_out || reply.signal != 0 || is_passing(fault.text));
  return std::nullopt;
}

Result<std::vector<QueueRow>> SlurmClient::look(const std::vector<std::string>& names) const {
  if (names.empty()) return std::vector<QueueRow>();
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ",") + name;
  const CommandReply reply = run_command(
      {"squeue", "--noheader", "--array", "--states=all", "--name=" + list, "-O", kColumns}, kLookLimit, give_up_);
  if (!reply.ok()) return fail(Code::IoFailed, "squeue: " + reply.problem());
  auto rows = queue_rows(reply.out);
  if (!rows) return fail(Code::IoFailed, "squeue: an answer of another form: " + trimmed(reply.out).substr(0, 120));
  std::erase_if(*rows,
                [&](const QueueRow& row) { return std::find(names.begin(), names.end(), row.name) == names.end(); });
  return *std::move(rows);
}

Result<void> SlurmClient::cancel(const std::string& name, const std::string& state, const std::string& signal) const {
  std::vector<std::string> words = {"scancel", "--quiet", "--name=" + name};
  if (!state.empty()) words.push_back("--state=" + state);
  if (!signal.empty()) words.insert(words.end(), {"--full", "--signal=" + signal});
  const CommandReply reply = run_command(words, kCancelLimit);
  if (!reply.ok()) return fail(Code::IoFailed, "scancel: " + reply.problem());
  return {};
}

Result<void> SlurmClient::cancel_element(const std::string& job, std::size_t index) const {
  const CommandReply reply = run_command({"scancel", "--quiet", job + "_" + std::to_string(index)}, kCancelLimit);
  if (!reply.ok()) return fail(Code::IoFailed, "scancel: " + reply.problem());
  return {};
}

std::optional<std::uint64_t> SlurmClient::take_number(const std::string& name, const ClusterKeys& keys) const {
  std::vector<std::string> words = {"sbatch"};
  words.insert(words.end(), keys.extra.begin(), keys.extra.end());
  words.insert(words.end(), {"--parsable", "--hold", "--job-name=" + name, "--nodes=1", "--mem=1M", "--time=1",
                             "--output=/dev/null"});
  if (!keys.partition.empty()) words.push_back("--partition=" + keys.partition);
  if (!keys.account.empty()) words.push_back("--account=" + keys.account);
  if (!keys.qos.empty()) words.push_back("--qos=" + keys.qos);
  words.push_back("--wrap=:");
  const CommandReply reply = run_command(words, kSubmitLimit, give_up_);
  if (!reply.ok()) return std::nullopt;
  return number_in(reply.out);
}

std::vector<IdleNodes> SlurmClient::idle_nodes(const std::string& partition) const {
  std::vector<std::string> words = {"sinfo", "--noheader", "--list-reasons", "-o", "%T|%N|%E"};
  if (!partition.empty()) words.push_back("--partition=" + partition);
  const CommandReply reply = run_command(words, kLookLimit, give_up_);
  std::vector<IdleNodes> found;
  if (!reply.ok()) return found;
  for (const std::string& line : lines_of(reply.out)) {
    const auto first = line.find('|'), second = first == std::string::npos ? first : line.find('|', first + 1);
    if (second == std::string::npos) continue;
    const std::string_view text = line;
    found.push_back({trimmed(text.substr(0, first)), trimmed(text.substr(first + 1, second - first - 1)),
                     trimmed(text.substr(second + 1))});
    std::string& state = found.back().state;  // "drained*": the node does not answer
    while (!state.empty() && !std::isalpha(static_cast<unsigned char>(state.back()))) state.pop_back();
  }
  return found;
}

std::optional<std::uint64_t> SlurmClient::largest_node(const std::string& partition) const {
  std::vector<std::string> words = {"sinfo", "--noheader", "--exact", "-o", "%m"};
  if (!partition.empty()) words.push_back("--partition=" + partition);
  const CommandReply reply = run_command(words, kLookLimit, give_up_);
  std::optional<std::uint64_t> most;
  if (!reply.ok()) return most;
  for (const std::string& line : lines_of(reply.out))
    if (const auto megabytes = whole<std::uint64_t>(trimmed(line).substr(0, trimmed(line).find('+'))))
      most = std::max(most.value_or(0), *megabytes * kMiB);
  return most;
}

std::optional<std::uint64_t> SlurmClient::setting(const std::string& key) const {
  const CommandReply reply = run_command({"scontrol", "show", "config"}, kLookLimit, give_up_);
  if (!reply.ok()) return std::nullopt;
  for (const std::string& line : lines_of(reply.out)) {
    const auto equals = line.find('=');
    if (equals == std::string::npos || trimmed(std::string_view(line).substr(0, equals)) != key) continue;
    const std::string value = trimmed(std::string_view(line).substr(equals + 1));
    return whole<std::uint64_t>(value.substr(0, value.find(' ')));
  }
  return std::nullopt;
}

}  // namespace scanmill::runner
