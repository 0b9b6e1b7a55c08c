// SPDX-License-Identifier: Apache-2.0
#include "runner/scan_state.hpp"

#include <algorithm>

#include "base/digest.hpp"
#include "store/files.hpp"

namespace scanmill::runner {
namespace {

using document::Node;

constexpr std::uint64_t kStateLimit = 64ull << 20;

std::string text_of(const Node& map, std::string_view key) {
  const Node* node = map.find(key);
  return node && node->is_string() ? node->as_string() : std::string();
}
std::uint64_t count_of(const Node& map, std::string_view key) {
  const Node* node = map.find(key);
  return node && node->is_integer() ? static_cast<std::uint64_t>(node->as_integer()) : 0;
}

Node to_document(const ScanState& state) {
  Node tree = Node::map();
  tree.set("scanmill_state", 1);
  tree.set("fingerprint", state.fingerprint.value);
  tree.set("mesh_fingerprint", state.fingerprint.mesh);
  tree.set("record", state.record_identity);
  tree.set("what", state.what);
  tree.set("counts", state.counts);
  if (!state.failed_gates.empty()) {
    Node gates = Node::sequence();
    for (const std::string& gate : state.failed_gates) gates.push(gate);
    tree.set("failed_gates", std::move(gates));
  }
  Node versions = Node::map();
  for (const auto& [stage, version] : state.fingerprint.versions) versions.set(stage, version);
  tree.set("versions", std::move(versions));
  Node inputs = Node::sequence();
  for (const InputFile& input : state.fingerprint.inputs) {
    Node row = Node::map();
    row.set("path", input.path);
    row.set("sha256", input.sha256);
    row.set("bytes", input.bytes);
    inputs.push(std::move(row));
  }
  tree.set("inputs", std::move(inputs));
  Node outputs = Node::sequence();
  for (const OutputFile& output : state.outputs) {
    Node row = Node::map();
    row.set("name", output.name);
    row.set("sha256", output.sha256);
    row.set("bytes", output.bytes);
    outputs.push(std::move(row));
  }
  tree.set("outputs", std::move(outputs));
  return tree;
}

/// "reduce.min_neighbour_distance 0.6 -> 0.5" for every leaf that differs.
void differences(const Node& before, const Node& now, const std::string& path, std::vector<std::string>& out) {
  if (before.is_map() && now.is_map()) {
    for (const Node::Entry& entry : now.entries()) {
      const Node* old = before.find(entry.key);
      differences(old ? *old : Node(), entry.value, path.empty() ? entry.key : path + "." + entry.key, out);
    }
    for (const Node::Entry& entry : before.entries())
      if (!now.find(entry.key))
        differences(entry.value, Node(), path.empty() ? entry.key : path + "." + entry.key, out);
    return;
  }
  const auto word = [](const Node& node) {
    return node.is_null()     ? std::string("off")
           : node.is_string() ? node.as_string()
                              : document::to_canonical_json(node);
  };
  if (document::to_canonical_json(before) != document::to_canonical_json(now))
    out.push_back(path + " " + word(before) + " -> " + word(now));
}

void input_changes(const std::vector<InputFile>& before, const std::vector<InputFile>& now,
                   std::vector<std::string>& out) {
  const auto in = [](const std::vector<InputFile>& list, const std::string& path) {
    return std::find_if(list.begin(), list.end(), [&](const InputFile& input) { return input.path == path; });
  };
  for (const InputFile& input : now) {
    const auto old = in(before, input.path);
    if (old == before.end())
      out.push_back("input " + input.path + " is new");
    else if (old->sha256 != input.sha256)
      out.push_back("input " + input.path +
                    (input.sha256.empty()  ? " is gone"
                     : old->sha256.empty() ? " is there now"
                                           : " changed"));
  }
  for (const InputFile& old : before)
    if (in(now, old.path) == now.end()) out.push_back("input " + old.path + " no longer belongs to the scan");
}

void version_changes(const Fingerprint& before, const Fingerprint& now, std::vector<std::string>& out) {
  for (const auto& [stage, version] : now.versions) {
    const auto old = std::find_if(before.versions.begin(), before.versions.end(),
                                  [&](const auto& row) { return row.first == stage; });
    if (old == before.versions.end() || old->second != version)
      out.push_back("stage " + stage + " " + (old == before.versions.end() ? "none" : old->second) + " -> " + version);
  }
}

}  // namespace

std::optional<ScanState> load_state(const std::string& folder) {
  const std::string path = folder + "/" + kStateFile;
  if (!store::exists(path)) return std::nullopt;
  const auto source = store::open_file(path, path);
  if (!source) return std::nullopt;
  const auto text = read_all(**source, kStateLimit);
  if (!text) return std::nullopt;
  const auto tree = document::parse_json(*text, path);
  if (!tree || count_of(*tree, "scanmill_state") != 1) return std::nullopt;
  ScanState state;
  state.fingerprint.value = text_of(*tree, "fingerprint");
  state.fingerprint.mesh = text_of(*tree, "mesh_fingerprint");
  state.record_identity = text_of(*tree, "record");
  if (const Node* what = tree->find("what")) state.what = *what;
  if (const Node* counts = tree->find("counts")) state.counts = *counts;
  if (const Node* gates = tree->find("failed_gates"); gates && gates->is_sequence())
    for (const Node& gate : gates->items())
      if (gate.is_string()) state.failed_gates.push_back(gate.as_string());
  if (const Node* versions = tree->find("versions"); versions && versions->is_map())
    for (const Node::Entry& entry : versions->entries())
      state.fingerprint.versions.emplace_back(entry.key, text_of(*versions, entry.key));
  if (const Node* inputs = tree->find("inputs"); inputs && inputs->is_sequence())
    for (const Node& row : inputs->items())
      state.fingerprint.inputs.push_back({text_of(row, "path"), text_of(row, "sha256"), count_of(row, "bytes")});
  if (const Node* outputs = tree->find("outputs"); outputs && outputs->is_sequence())
    for (const Node& row : outputs->items())
      state.outputs.push_back({text_of(row, "name"), count_of(row, "bytes"), text_of(row, "sha256")});
  return state;
}

Result<void> save_state(ScanState& state, const std::string& folder) {
  TRY_ASSIGN(const std::vector<std::string> names, store::list_files(folder));
  state.outputs.clear();
  for (const std::string& name : names) {
    const std::string path = folder + "/" + name;
    TRY_ASSIGN(const auto source, store::open_file(path, path));
    TRY_ASSIGN(std::string sha256, sha256_of(*source));
    state.outputs.push_back({name, source->size(), std::move(sha256)});
  }
  return store::write_text(folder + "/" + kStateFile, document::to_json(to_document(state), 1) + "\n");
}

std::vector<std::string> reasons_to_run(const std::optional<ScanState>& state, const std::string& folder,
                                        const Fingerprint& fingerprint, const Node& what) {
  if (!state) return {"new"};
  std::vector<std::string> reasons;
  if (state->fingerprint.value != fingerprint.value) {
    input_changes(state->fingerprint.inputs, fingerprint.inputs, reasons);
    differences(state->what, what, "", reasons);
    version_changes(state->fingerprint, fingerprint, reasons);
    if (reasons.empty()) reasons.push_back("the fingerprint differs");
  }
  for (const OutputFile& output : state->outputs) {
    const std::string path = folder + "/" + output.name;
    const auto stamp = store::stamp_of(path);
    if (!store::exists(path) || !stamp)
      reasons.push_back(output.name + " is missing");
    else if (stamp->size != output.bytes)
      reasons.push_back(output.name + " has " + std::to_string(stamp->size) + " bytes, not " +
                        std::to_string(output.bytes));
  }
  return reasons;
}

bool mesh_stands(const std::optional<ScanState>& state, const Fingerprint& fingerprint) {
  return state && !fingerprint.mesh.empty() && state->fingerprint.mesh == fingerprint.mesh;
}

}  // namespace scanmill::runner
