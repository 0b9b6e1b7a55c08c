// SPDX-License-Identifier: Apache-2.0
#include "runner/ro_crate.hpp"

#include <string_view>

#include "base/text.hpp"

namespace scanmill::runner {
namespace {

using document::Node;

constexpr const char* kProfile = "https://w3id.org/ro/wfrun/process/0.5";

/// A path as the path of a URI: everything but letters, digits, "-._~" and '/' by number.
std::string uri_of(std::string_view path) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string text;
  for (const char c : path) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       std::string_view("-._~/").find(c) != std::string_view::npos;
    if (plain) {
      text += c;
    } else {
      text += '%';
      text += kDigits[byte >> 4];
      text += kDigits[byte & 15];
    }
  }
  return text;
}

std::string media_type_of(std::string_view name) {
  for (const auto& [suffix, type] :
       {std::pair(".stl", "model/stl"), std::pair(".ply", "model/x-ply"), std::pair(".obj", "model/obj"),
        std::pair(".igs", "model/iges"), std::pair(".dxf", "image/vnd.dxf"), std::pair(".3mf", "model/3mf"),
        std::pair(".h5", "application/x-hdf5"), std::pair(".html", "text/html"), std::pair(".png", "image/png"),
        std::pair(".svg", "image/svg+xml"), std::pair(".json", "application/json")})
    if (name.ends_with(suffix)) return type;
  return "application/octet-stream";
}

Node reference(const std::string& id) {
  Node node = Node::map();
  node.set("@id", id);
  return node;
}

Node entity(const std::string& id, const char* type) {
  Node node = reference(id);
  node.set("@type", type);
  return node;
}

Node file_entity(const std::string& id, const char* type, const std::string& name, std::uint64_t bytes,
                 const std::string& sha256) {
  Node node = entity(id, type);
  node.set("name", name);
  node.set("encodingFormat", media_type_of(name));
  node.set("contentSize", std::to_string(bytes));
  node.set("sha256", sha256);
  return node;
}

constexpr std::size_t kPiece = 1 << 16;  // bytes written at once

/// The entities of the graph, a line each. The first failure of the sink stays.
class Graph {
 public:
  Graph(ByteSink& sink, std::string head) : sink_(sink), text_(std::move(head)) {}
  void push(const Node& entity) { push_text(document::to_json(entity)); }
  void push_text(std::string_view entity) {
    text_ += first_ ? "\n" : ",\n";
    text_ += entity;
    first_ = false;
    if (text_.size() >= kPiece) flush();
  }
  Result<void> finish(std::string_view tail) {
    text_ += tail;
    flush();
    return std::move(written_);
  }

 private:
  void flush() {
    if (written_.ok()) written_ = sink_.write(std::string_view(text_));
    text_.clear();
  }

  ByteSink& sink_;
  std::string text_;
  Result<void> written_;
  bool first_ = true;
};

/// A list of references as JSON text: as nodes it would take ten times the memory.
class References {
 public:
  void push(const std::string& id) {
    text_ += text_.empty() ? "" : ",";
    text_ += document::to_json(reference(id));
  }
  std::string text() const { return "[" + text_ + "]"; }

 private:
  std::string text_;
};

/// The action of a scan; its files go to the graph and, where they lie in the tree, to the parts of the whole.
Node action_of(const RunReport& report, const CrateScan& scan, Graph& graph, References& parts) {
  Node action = entity("#scan/" + uri_of(scan.name), "CreateAction");
  action.set("name", "mesh and record of scan " + scan.name);
  action.set("instrument", reference("#scanmill"));
  action.set("actionStatus", "http://schema.org/CompletedActionStatus");
  if (scan.made_now) {
    action.set("startTime", report.started);
    action.set("endTime", report.ended);
  }
  action.set("identifier", scan.state.record_identity);
  Node objects = Node::sequence(), results = Node::sequence();
  for (const InputFile& input : scan.state.fingerprint.inputs) {
    if (input.sha256.empty()) continue;  // missing
    const std::string id = "#input/" + uri_of(scan.name) + "/" + uri_of(input.path);
    objects.push(reference(id));
    graph.push(file_entity(id, "MediaObject", input.path, input.bytes, input.sha256));
  }
  for (const OutputFile& output : scan.state.outputs) {
    const std::string id = uri_of("scans/" + scan.name + "/" + output.name);
    results.push(reference(id));
    parts.push(id);
    graph.push(file_entity(id, "File", output.name, output.bytes, output.sha256));
  }
  action.set("object", std::move(objects));
  action.set("result", std::move(results));
  return action;
}

}  // namespace

Result<void> write_ro_crate(const RunReport& report, ResultOf result_of, const std::vector<std::string>& files_of_run,
                            ByteSink& sink) {
  Node own = Node::map();
  own.set("sha256", "https://schema.org/sha256");
  Node context = Node::sequence();
  context.push("https://w3id.org/ro/crate/1.1/context");
  context.push(std::move(own));
  Graph graph(sink, "{\"@context\": " + document::to_json(context) + ",\n\"@graph\": [");
  References parts, actions;
  Node metadata = entity("ro-crate-metadata.json", "CreativeWork");
  metadata.set("about", reference("./"));
  metadata.set("conformsTo", reference("https://w3id.org/ro/crate/1.1"));
  graph.push(std::move(metadata));
  Node profile = entity(kProfile, "CreativeWork");
  profile.set("name", "Process Run Crate");
  profile.set("version", "0.5");
  graph.push(std::move(profile));
  Node tool = entity("#scanmill", "SoftwareApplication");
  tool.set("name", "scanmill");
  tool.set("softwareVersion", report.version);
  graph.push(std::move(tool));
  for (const std::string& name : files_of_run) {
    parts.push(uri_of(name));
    Node file = entity(uri_of(name), "File");
    file.set("name", name);
    file.set("encodingFormat", media_type_of(name));
    graph.push(std::move(file));
  }
  std::uint64_t scans = 0;
  for (const ScanEntry& entry : report.scans) {
    const auto scan = result_of(entry);
    if (!scan) continue;
    ++scans;
    Node action = action_of(report, *scan, graph, parts);
    actions.push("#scan/" + uri_of(scan->name));
    graph.push(action);
  }
  Node root = entity("./", "Dataset");
  root.set("name", "scanmill run of " + report.job_path);
  root.set("description", counted(scans, "scan") + " with mesh, record and report");
  root.set("datePublished", report.ended);
  root.set("license", "not stated: the files belong to whoever made the scans");
  root.set("conformsTo", reference(kProfile));
  std::string text = document::to_json(root);
  text.pop_back();  // its brace
  graph.push_text(text + ",\"hasPart\":" + parts.text() + ",\"mentions\":" + actions.text() + "}");
  return graph.finish("\n]}\n");
}

}  // namespace scanmill::runner
