// SPDX-License-Identifier: Apache-2.0
#include "runner/task_result.hpp"

#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>

#include "runner/machine.hpp"
#include "store/files.hpp"

namespace scanmill::runner {

using document::Node;

namespace {

constexpr std::uint64_t kLargestResult = 64ull << 20;

std::string text_in(const Node& tree, const char* key) {
  const Node* value = tree.find(key);
  return value && value->is_string() ? value->as_string() : "";
}
double number_in(const Node& tree, const char* key) {
  const Node* value = tree.find(key);
  return value && value->is_number() && value->as_number() > 0 ? value->as_number() : 0;
}
bool flag_in(const Node& tree, const char* key) {
  const Node* value = tree.find(key);
  return value && value->is_bool() && value->as_bool();
}

std::optional<Node> read_tree(const std::string& path) {
  const auto source = store::open_file(path, path);
  if (!source) return std::nullopt;
  const auto text = read_all(**source, kLargestResult);
  if (!text) return std::nullopt;
  auto tree = document::parse_json(*text, path);
  if (!tree || !tree->is_map()) return std::nullopt;
  return *std::move(tree);
}

/// The number at the front of `text`, which loses it.
std::optional<std::size_t> take_number(std::string_view& text) {
  std::size_t number = 0;
  const auto [rest, bad] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (bad != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(rest - text.data()));
  return number;
}

}  // namespace

Node to_document(const TaskResult& result) {
  const Ended& ended = result.ended;
  Node tree = Node::map();
  tree.set("scanmill_result", 1);
  tree.set("scan", result.scan);
  tree.set("host", result.host);
  tree.set("engine", result.engine);
  tree.set("seconds", ended.seconds);
  tree.set("cpu_seconds", ended.cpu_seconds);
  tree.set("peak_memory_bytes", ended.peak_memory);
  tree.set("stage", ended.stage);
  if (ended.attempt) {
    tree.set("attempt", to_document(*ended.attempt));
  } else {
    Node death = Node::map();
    death.set("text", ended.death);
    death.set("killed_by_system", ended.killed_by_system);
    death.set("over_time", ended.over_time);
    tree.set("death", std::move(death));
  }
  return tree;
}

Result<TaskResult> task_result_from(const Node& tree) {
  const Node *version = tree.find("scanmill_result"), *attempt = tree.find("attempt"), *death = tree.find("death");
  if (!version || !version->is_integer() || version->as_integer() != 1 || (!attempt && !death))
    return fail(Code::Internal, "is no record of a task's result");
  TaskResult result;
  result.scan = text_in(tree, "scan");
  result.host = text_in(tree, "host");
  result.engine = text_in(tree, "engine");
  result.ended.seconds = number_in(tree, "seconds");
  result.ended.cpu_seconds = number_in(tree, "cpu_seconds");
  result.ended.peak_memory = static_cast<std::uint64_t>(number_in(tree, "peak_memory_bytes"));
  result.ended.stage = text_in(tree, "stage");
  if (attempt) {
    TRY_ASSIGN(result.ended.attempt, attempt_from(*attempt));
  } else {
    result.ended.death = text_in(*death, "text");
    result.ended.killed_by_system = flag_in(*death, "killed_by_system");
    result.ended.over_time = flag_in(*death, "over_time");
  }
  return result;
}

std::string result_path(const std::string& folder, std::size_t index, std::size_t item) {
  return folder + "/" + std::to_string(index) + "-" + std::to_string(item) + ".json";
}

std::optional<std::pair<std::size_t, std::size_t>> result_numbers(const std::string& name) {
  std::string_view text = name;
  const auto index = take_number(text);
  if (!index || !text.starts_with('-')) return std::nullopt;
  text.remove_prefix(1);
  const auto item = take_number(text);
  if (!item || text != ".json") return std::nullopt;
  return std::pair(*index, *item);
}

bool is_final(const TaskResult& result) {
  if (!result.ended.attempt) return false;
  const ScanEntry& entry = result.ended.attempt->entry;
  return entry.failure == FailureClass::None || entry.failure == FailureClass::BadInput ||
         entry.fate == ScanFate::Quarantined;
}

Result<bool> save_result(const std::string& folder, std::size_t index, std::size_t item, const TaskResult& result) {
  const std::string path = result_path(folder, index, item);
  const std::string whole = path + ".whole-" + host_name() + "-" + std::to_string(getpid());
  TRY(store::write_text(whole, document::to_json(to_document(result)) + "\n"));
  const auto earlier = load_result(path);
  bool first = true;
  // A link, unlike a rename, never replaces: of two copies of a task the first one's record stays.
  if ((earlier && !is_final(*earlier)) || (link(whole.c_str(), path.c_str()) != 0 && errno != EEXIST)) {
    if (std::rename(whole.c_str(), path.c_str()) != 0) {
      const int reason = errno;
      (void)unlink(whole.c_str());
      return fail(Code::IoFailed, std::string("cannot be written: ") + std::strerror(reason), path);
    }
  } else {
    first = !earlier;
    (void)unlink(whole.c_str());
  }
  TRY(store::sync_folder(folder));
  return first;
}

std::optional<TaskResult> load_result(const std::string& path) {
  const auto tree = read_tree(path);
  if (!tree) return std::nullopt;
  auto result = task_result_from(*tree);
  if (!result) return std::nullopt;
  return *std::move(result);
}

std::string heartbeat_name(std::size_t index, const std::string& host, int pid) {
  return std::to_string(index) + "." + host + "." + std::to_string(pid) + ".alive";
}

std::optional<std::size_t> heartbeat_index(const std::string& name) {
  std::string_view text = name;
  const auto index = take_number(text);
  if (!index || !text.starts_with('.') || !text.ends_with(".alive")) return std::nullopt;
  return index;
}

void beat(const std::string& path, const Heartbeat& heartbeat) {
  Node tree = Node::map();
  tree.set("host", heartbeat.host);
  tree.set("engine", heartbeat.engine);
  tree.set("pid", heartbeat.pid);
  tree.set("item", static_cast<std::uint64_t>(heartbeat.item));
  tree.set("stage", heartbeat.stage);
  tree.set("done", heartbeat.done);
  tree.set("total", heartbeat.total);
  tree.set("space", heartbeat.space);
  tree.set("began", heartbeat.began);
  (void)store::write_scratch(path, document::to_json(tree) + "\n");
}

std::optional<Heartbeat> load_heartbeat(const std::string& path) {
  const auto tree = read_tree(path);
  if (!tree) return std::nullopt;
  Heartbeat beat;
  beat.host = text_in(*tree, "host");
  beat.engine = text_in(*tree, "engine");
  beat.pid = static_cast<int>(number_in(*tree, "pid"));
  beat.item = static_cast<std::size_t>(number_in(*tree, "item"));
  beat.stage = text_in(*tree, "stage");
  beat.done = static_cast<std::uint64_t>(number_in(*tree, "done"));
  beat.total = static_cast<std::uint64_t>(number_in(*tree, "total"));
  beat.space = text_in(*tree, "space");
  beat.began = static_cast<std::uint64_t>(number_in(*tree, "began"));
  return beat;
}

}  // namespace scanmill::runner
