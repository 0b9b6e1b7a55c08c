// SPDX-License-Identifier: Apache-2.0
#include "runner/task_file.hpp"

#include <cstdio>
#include <filesystem>
#include <random>

#include "base/text.hpp"
#include "runner/output_tree.hpp"
#include "store/files.hpp"

namespace scanmill::runner {

using document::Node;

namespace {

constexpr std::uint64_t kLargestTask = 256ull << 20;

/// Reads keys of one map; the first that is not as it should be is remembered.
class Reader {
 public:
  Reader(const Node& map, std::string place, std::string& problem)
      : map_(map), place_(std::move(place)), problem_(problem) {}

  void text(const char* key, std::string& to) const {
    if (const Node* value = wanted(key, &Node::is_string, "a text")) to = value->as_string();
  }
  void flag(const char* key, bool& to) const {
    if (const Node* value = wanted(key, &Node::is_bool, "true or false")) to = value->as_bool();
  }
  void number(const char* key, double& to) const {
    const Node* value = wanted(key, &Node::is_number, "a number of 0 or more");
    if (value && value->as_number() >= 0)
      to = value->as_number();
    else if (value)
      complain(key, "a number of 0 or more");
  }
  template <class Integer>
  void count(const char* key, Integer& to) const {
    const Node* value = wanted(key, &Node::is_integer, "a whole number of 0 or more");
    if (value && value->as_integer() >= 0)
      to = static_cast<Integer>(value->as_integer());
    else if (value)
      complain(key, "a whole number of 0 or more");
  }
  const Node* list(const char* key) const { return wanted(key, &Node::is_sequence, "a list"); }
  const Node* map(const char* key) const { return wanted(key, &Node::is_map, "a map"); }

 private:
  const Node* wanted(const char* key, bool (Node::*is)() const, const char* what) const {
    const Node* value = map_.find(key);
    if (value && (value->*is)()) return value;
    complain(key, what);
    return nullptr;
  }
  void complain(const char* key, const char* what) const {
    if (problem_.empty()) problem_ = place_ + key + ": wanted " + what;
  }
  const Node& map_;
  std::string place_;
  std::string& problem_;
};

Node to_document(const Task& task) {
  Node row = Node::map();
  row.set("kind", "scans");
  row.set("wave", task.wave);
  row.set("threads", task.threads);
  row.set("memory_bytes", task.memory);
  Node items = Node::sequence();
  for (const TaskItem& item : task.items) {
    Node entry = Node::map();
    entry.set("scan", item.scan);
    entry.set("keys", static_cast<std::uint64_t>(item.keys));
    entry.set("bytes", item.bytes);
    if (!item.part.empty()) entry.set("part", item.part);
    items.push(std::move(entry));
  }
  row.set("items", std::move(items));
  return row;
}

Task task_from(const Node& row, const std::string& place, std::size_t keys, std::string& problem) {
  Task task;
  const Reader reader(row, place + ".", problem);
  std::string kind;
  reader.text("kind", kind);
  if (kind != "scans" && problem.empty())
    problem = place + ".kind: found '" + kind + "', which this version cannot run";
  reader.count("wave", task.wave);
  reader.count("threads", task.threads);
  if (task.threads < 1 && problem.empty()) problem = place + ".threads: wanted 1 or more";
  reader.count("memory_bytes", task.memory);
  const Node* items = reader.list("items");
  for (std::size_t i = 0; items && i < items->items().size(); ++i) {
    TaskItem item;
    const std::string at = place + ".items[" + std::to_string(i) + "].";
    const Reader entry(items->items()[i], at, problem);
    entry.text("scan", item.scan);
    entry.count("keys", item.keys);
    entry.count("bytes", item.bytes);
    if (items->items()[i].find("part")) entry.text("part", item.part);
    if (item.keys >= keys && problem.empty()) problem = at + "keys: found no entry of that number";
    if (!is_inside(item.scan) && problem.empty()) problem = at + "scan: found a name that leads out of the output";
    task.items.push_back(std::move(item));
  }
  return task;
}

}  // namespace

Node to_document(const TaskFile& file) {
  Node tree = Node::map();
  tree.set("scanmill_tasks", 1);
  tree.set("version", file.version);
  tree.set("token", file.token);
  tree.set("out", file.out);
  Node job = Node::map();
  job.set("path", file.job_path);
  job.set("shown", file.job_shown);
  job.set("text", file.job_text);
  Node sets = Node::sequence();
  for (const std::string& set : file.sets) sets.push(set);
  job.set("set", std::move(sets));
  tree.set("job", std::move(job));
  tree.set("forced", file.forced);
  tree.set("memory_cap_bytes", file.memory_cap);
  tree.set("time_limit_s", file.time_limit_s);
  tree.set("lease_s", file.lease_s);
  Node keys = Node::sequence(), tasks = Node::sequence();
  for (const Node& entry : file.keys) keys.push(entry);
  for (const Task& task : file.tasks) tasks.push(to_document(task));
  tree.set("keys", std::move(keys));
  tree.set("tasks", std::move(tasks));
  return tree;
}

Result<TaskFile> task_file_from(const Node& tree, const std::string& path) {
  TaskFile file;
  std::string problem;
  const Reader reader(tree, "", problem);
  int version = 0;
  reader.count("scanmill_tasks", version);
  if (version != 1 && problem.empty()) problem = "scanmill_tasks: wanted 1";
  reader.text("version", file.version);
  reader.text("token", file.token);
  reader.text("out", file.out);
  if (const Node* job = reader.map("job")) {
    const Reader inner(*job, "job.", problem);
    inner.text("path", file.job_path);
    inner.text("shown", file.job_shown);
    inner.text("text", file.job_text);
    const Node* sets = inner.list("set");
    for (std::size_t i = 0; sets && i < sets->items().size(); ++i) {
      if (sets->items()[i].is_string())
        file.sets.push_back(sets->items()[i].as_string());
      else if (problem.empty())
        problem = "job.set: wanted texts";
    }
  }
  reader.flag("forced", file.forced);
  reader.count("memory_cap_bytes", file.memory_cap);
  reader.number("time_limit_s", file.time_limit_s);
  reader.number("lease_s", file.lease_s);
  if (const Node* keys = reader.list("keys")) file.keys = keys->items();
  for (const Node& entry : file.keys)
    if (!entry.is_map() && problem.empty()) problem = "keys: wanted maps";
  const Node* tasks = reader.list("tasks");
  for (std::size_t i = 0; tasks && i < tasks->items().size(); ++i)
    file.tasks.push_back(task_from(tasks->items()[i], "tasks[" + std::to_string(i) + "]", file.keys.size(), problem));
  if (!problem.empty())
    return fail(Code::BadInput, problem + "; wanted a worklist as scanmill run and scanmill worklist write it", path);
  return file;
}

Result<TaskFile> load_task_file(const std::string& path) {
  // OUT/work/<folder>/tasks.json
  const auto out = std::filesystem::absolute(path).lexically_normal().parent_path().parent_path().parent_path();
  if (!store::exists(path) && store::is_folder(OutputTree(out.string()).journal()))
    return fail(
        Code::BadUsage,
        "found no worklist; a run, a cancel or another worklist of this output takes it back, and keeps what its "
        "tasks made; scanmill worklist writes one of what is left",
        path);
  TRY_ASSIGN(const auto source, store::open_file(path, path));
  TRY_ASSIGN(const std::string text, read_all(*source, kLargestTask));
  auto tree = document::parse_json(text, path);
  if (!tree) return fail(Code::BadInput, "is no worklist: " + tree.error().message, path);
  return task_file_from(*tree, path);
}

std::string new_token() {
  std::random_device device;
  char text[9];
  std::snprintf(text, sizeof text, "%08x", static_cast<unsigned>(device()));
  return text;
}

}  // namespace scanmill::runner
