// SPDX-License-Identifier: Apache-2.0
#include "runner/forecast.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "runner/journal.hpp"
#include "runner/machine.hpp"

namespace scanmill::runner {

using document::Node;

namespace {

constexpr std::size_t kEpochs = 3;

std::string quoted(const std::string& text) {
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
    tasks.push(std::move(row));
  }
  tree.set("tasks", std::move(tasks));
  return tree;
}

std::string to_dot(const Forecast& forecast) {
  std::string text = "digraph scanmill {\n  rankdir=LR;\n  node [shape=box];\n";
  for (const ForecastTask& task : forecast.tasks) {
    const bool runs = task.verb == "run";
    text += "  " + quoted("in " + task.scan) + " [shape=folder, label=" + quoted(bytes_text(task.bytes)) + "];\n";
    text += "  " + quoted(task.scan) + " [label=" + quoted(task.scan + ": " + task.verb) +
            (runs ? "" : ", style=dashed") + "];\n";
    text += "  " + quoted("in " + task.scan) + " -> " + quoted(task.scan) + (runs ? "" : " [style=dashed]") + ";\n";
  }
  return text + "}\n";
}

}  // namespace scanmill::runner
