// SPDX-License-Identifier: Apache-2.0
#include "runner/forecast.hpp"

#include <algorithm>
#include <cstdio>

#include "base/text.hpp"
#include "runner/journal.hpp"
#include "runner/machine.hpp"
#include "runner/worklist.hpp"

namespace scanmill::runner {

using document::Node;

namespace {

constexpr std::size_t kEpochs = 3;

std::string in_quotes(const std::string& text) {
  std::string all = "\"";
  for (const char c : text) all += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return all + "\"";
}

}  // namespace

std::uint64_t Forecast::count(const std::string& verb) const {
  return static_cast<std::uint64_t>(
      std::count_if(tasks.begin(), tasks.end(), [&](const ForecastTask& task) { return task.verb == verb; }));
}

std::uint64_t Forecast::bytes() const {
  std::uint64_t sum = 0;
  for (const ForecastTask& task : tasks)
    if (task.verb == "run") sum += task.bytes;
  return sum;
}

std::uint64_t Forecast::memory() const {
  std::uint64_t most = 0;
  for (const ForecastTask& task : tasks)
    if (task.verb == "run") most = std::max(most, task.memory);
  return most;
}

double Forecast::seconds() const {
  return bytes_per_core_second > 0 ? static_cast<double>(bytes()) / bytes_per_core_second / cores : 0;
}

double Forecast::cpu_seconds(const ForecastTask& task, const ForecastWave& wave) const {
  return bytes_per_core_second > 0 ? wave.cpu * static_cast<double>(task.bytes) / bytes_per_core_second : 0;
}

std::uint64_t ForecastTask::disk() const {
  std::uint64_t most = 0;
  for (const ForecastWave& wave : waves) most = std::max(most, wave.disk);
  return most;
}

std::string kind_of_part(const std::string& part) { return part.substr(0, part.find(' ')); }

std::vector<ForecastWave> waves_of(const CutParts& parts, const CutForecast& forecast, std::uint64_t bytes) {
  std::vector<ForecastWave> waves;
  for (std::size_t n = 0; n <= parts.waves.size() && n < forecast.disk.size() && n < forecast.cpu.size(); ++n) {
    const bool is_last = n == parts.waves.size();
    const std::uint64_t tasks = is_last ? 1 : parts.waves[n].size();
    const bool is_whole = is_last || parts.whole[n];
    waves.push_back({is_last ? "the scan itself" : kind_of_part(parts.waves[n].front()), tasks,
                     memory_guess(is_whole ? bytes : std::max<std::uint64_t>(1, bytes / tasks)), forecast.disk[n],
                     forecast.cpu[n]});
  }
  return waves;
}

Node to_document(const CutForecast& forecast) {
  Node tree = Node::map(), disk = Node::sequence(), cpu = Node::sequence();
  for (const std::uint64_t bytes : forecast.disk) disk.push(bytes);
  for (const double share : forecast.cpu) cpu.push(share);
  tree.set("disk_bytes", std::move(disk));
  tree.set("cpu", std::move(cpu));
  tree.set("memory_bytes", forecast.memory);
  tree.set("bins", forecast.bins);
  return tree;
}

CutForecast cut_forecast_from(const Node& tree) {
  CutForecast forecast;
  const auto number = [](const Node* value) { return value && value->is_number() ? value->as_number() : 0; };
  if (const Node* disk = tree.find("disk_bytes"); disk && disk->is_sequence())
    for (const Node& bytes : disk->items()) forecast.disk.push_back(static_cast<std::uint64_t>(number(&bytes)));
  if (const Node* cpu = tree.find("cpu"); cpu && cpu->is_sequence())
    for (const Node& share : cpu->items()) forecast.cpu.push_back(number(&share));
  forecast.memory = static_cast<std::uint64_t>(number(tree.find("memory_bytes")));
  forecast.bins = static_cast<std::uint64_t>(number(tree.find("bins")));
  return forecast;
}

double speed_of(const std::string& journal_folder) {
  const auto epochs = epochs_in(journal_folder);
  double bytes = 0, seconds = 0;
  for (std::size_t k = epochs.size() - std::min(epochs.size(), kEpochs); k < epochs.size(); ++k)
    for (const Node& event : load_journal(journal_folder, epochs[k])) {
      const Node *state = event.find("state"), *input = event.find("bytes"), *spent = event.find("core_seconds");
      if (!state || !input || !spent || !state->is_string() || state->as_string() != "done") continue;
      bytes += input->as_number();
      seconds += spent->as_number();
    }
  return seconds > 0 ? bytes / seconds : 0;
}

std::string line_of(const Forecast& forecast) {
  std::string line = "would run " + counted(forecast.count("run"), "scan") + " of " +
                     std::to_string(forecast.tasks.size()) + ": " + bytes_text(forecast.bytes()) + " of input, up to " +
                     bytes_text(forecast.memory()) + " of memory for one";
  line += forecast.seconds() > 0 ? ", about " + clock_text(forecast.seconds()) + " h at the speed of the last runs"
                                 : std::string(", time not known before a first run");
  return line;
}

std::string table_of(const Forecast& forecast, const ForecastTask& task) {
  if (task.waves.empty()) return {};
  std::uint64_t parts = 0;
  for (const ForecastWave& wave : task.waves) parts += wave.tasks;
  std::string text = task.scan + ": " + counted(parts - 1, "part") + " in " + counted(task.waves.size() - 1, "wave") +
                     ", then the scan itself; up to " + bytes_text(task.disk()) + " of disk for parts and results";
  char line[160];
  std::snprintf(line, sizeof line, "\n  %-16s %6s %14s %14s %12s", "wave", "tasks", "memory each", "disk then",
                "CPU s");
  text += line;
  for (const ForecastWave& wave : task.waves) {
    const double seconds = forecast.cpu_seconds(task, wave);
    char cpu[24] = "not known";
    if (seconds > 0) std::snprintf(cpu, sizeof cpu, "%.1f", seconds);
    std::snprintf(line, sizeof line, "\n  %-16s %6llu %14s %14s %12s", wave.kind.c_str(),
                  static_cast<unsigned long long>(wave.tasks), bytes_text(wave.memory).c_str(),
                  bytes_text(wave.disk).c_str(), cpu);
    text += line;
  }
  return text;
}

namespace {

Node to_document(const Forecast& forecast, const ForecastTask& task, const ForecastWave& wave) {
  Node row = Node::map();
  row.set("kind", wave.kind);
  row.set("tasks", wave.tasks);
  row.set("memory_bytes", wave.memory);
  row.set("disk_bytes", wave.disk);
  const double seconds = forecast.cpu_seconds(task, wave);
  row.set("cpu_seconds", seconds > 0 ? Node(seconds) : Node());
  return row;
}

}  // namespace

Node to_document(const Forecast& forecast) {
  Node tree = Node::map();
  tree.set("type", "worklist");
  tree.set("scanmill_worklist", 1);
  tree.set("cores", forecast.cores);
  tree.set("bytes", forecast.bytes());
  tree.set("memory_bytes", forecast.memory());
  tree.set("seconds", forecast.seconds() > 0 ? Node(forecast.seconds()) : Node());
  Node tasks = Node::sequence();
  for (const ForecastTask& task : forecast.tasks) {
    Node row = Node::map();
    row.set("scan", task.scan);
    row.set("verb", task.verb);
    Node why = Node::sequence();
    for (const std::string& reason : task.why) why.push(reason);
    row.set("why", std::move(why));
    row.set("bytes", task.bytes);
    row.set("memory_bytes", task.memory);
    if (!task.waves.empty()) {
      row.set("disk_bytes", task.disk());
      Node waves = Node::sequence();
      for (const ForecastWave& wave : task.waves) waves.push(to_document(forecast, task, wave));
      row.set("waves", std::move(waves));
    }
    tasks.push(std::move(row));
  }
  tree.set("tasks", std::move(tasks));
  return tree;
}

std::string to_dot(const Forecast& forecast) {
  std::string text = "digraph scanmill {\n  rankdir=LR;\n  node [shape=box];\n";
  for (const ForecastTask& task : forecast.tasks) {
    const bool runs = task.verb == "run";
    text += "  " + in_quotes("in " + task.scan) + " [shape=folder, label=" + in_quotes(bytes_text(task.bytes)) + "];\n";
    text += "  " + in_quotes(task.scan) + " [label=" + in_quotes(task.scan + ": " + task.verb) +
            (runs ? "" : ", style=dashed") + "];\n";
    std::string from = "in " + task.scan;
    for (std::size_t n = 0; n + 1 < task.waves.size(); ++n) {
      const ForecastWave& wave = task.waves[n];
      const std::string node = wave.kind + " of " + task.scan;
      text += "  " + in_quotes(node) + " [label=" + in_quotes(std::to_string(wave.tasks) + " " + wave.kind) + "];\n";
      text += "  " + in_quotes(from) + " -> " + in_quotes(node) + ";\n";
      from = node;
    }
    text += "  " + in_quotes(from) + " -> " + in_quotes(task.scan) + (runs ? "" : " [style=dashed]") + ";\n";
  }
  return text + "}\n";
}

}  // namespace scanmill::runner
