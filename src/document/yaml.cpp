// SPDX-License-Identifier: Apache-2.0
// The wall around yaml-cpp: its events become our tree, so marks, quoting and duplicate keys are ours to judge.
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <charconv>
#include <sstream>

#include "base/text.hpp"
#include "document/document.hpp"

namespace scanmill::document {
namespace {

constexpr std::size_t kMaxDepth = 64;
constexpr std::size_t kMaxNodes = 1000000;

struct Refused {
  std::string message;
  Mark mark;
};

Mark mark_of(const YAML::Mark& mark) { return {mark.line + 1, mark.column + 1}; }

Node plain_scalar(const std::string& text) {
  if (text.empty() || text == "~" || text == "null") return {};
  if (text == "true") return Node(true);
  if (text == "false") return Node(false);
  std::int64_t whole = 0;
  const char* begin = text.data() + (text.size() > 1 && text[0] == '+' && text[1] != '-' ? 1 : 0);
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), whole);
  if (error == std::errc{} && end == text.data() + text.size()) return Node(whole);
  const char first = text.front();
  if ((first >= '0' && first <= '9') || first == '-' || first == '+' || first == '.')
    if (const auto value = parse_number(text)) return Node(*value);
  return Node(text);
}

class Builder final : public YAML::EventHandler {
 public:
  Node root;

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    refuse_anchor(mark, anchor);
    add(Node(), mark, {});
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    throw Refused{"aliases (*name) are not used in scanmill files; write the value out", mark_of(mark)};
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    refuse_anchor(mark, anchor);
    add(tag == "!" ? Node(value) : plain_scalar(value), mark, value);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    refuse_anchor(mark, anchor);
    open(Node::sequence(), mark);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    refuse_anchor(mark, anchor);
    open(Node::map(), mark);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Level {
    Node node;
    std::string key;
    Mark key_mark;
    bool has_key = false;
  };
  std::vector<Level> stack_;
  std::size_t nodes_ = 0;

  static void refuse_anchor(const YAML::Mark& mark, YAML::anchor_t anchor) {
    if (anchor != 0)
      throw Refused{"anchors (&name) are not used in scanmill files; write the value out", mark_of(mark)};
  }
  void count(const Mark& mark) {
    if (++nodes_ > kMaxNodes) throw Refused{"more than a million values; this is not a job or plan", mark};
  }
  void open(Node node, const YAML::Mark& mark) {
    count(mark_of(mark));
    if (stack_.size() >= kMaxDepth) throw Refused{"nested deeper than 64 levels", mark_of(mark)};
    if (!stack_.empty() && stack_.back().node.is_map() && !stack_.back().has_key)
      throw Refused{"a key must be a plain word", mark_of(mark)};
    node.mark = mark_of(mark);
    stack_.push_back({std::move(node), {}, {}, false});
  }
  void close() {
    Node node = std::move(stack_.back().node);
    stack_.pop_back();
    place_node(std::move(node));
  }
  void add(Node node, const YAML::Mark& mark, const std::string& text) {
    count(mark_of(mark));
    if (!stack_.empty() && stack_.back().node.is_map() && !stack_.back().has_key) {
      Level& level = stack_.back();
      for (const Node::Entry& entry : level.node.entries())
        if (entry.key == text)
          throw Refused{"the key '" + text + "' stands here a second time (first in line " +
                            std::to_string(entry.mark.line) + "); remove one",
                        mark_of(mark)};
      level.key = text;
      level.key_mark = mark_of(mark);
      level.has_key = true;
      return;
    }
    node.mark = mark_of(mark);
    node.text = text;
    place_node(std::move(node));
  }
  void place_node(Node node) {
    if (stack_.empty()) {
      root = std::move(node);
      return;
    }
    Level& level = stack_.back();
    if (level.node.is_map()) {
      level.node.entries().push_back({std::move(level.key), level.key_mark, std::move(node)});
      level.has_key = false;
    } else {
      level.node.push(std::move(node));
    }
  }
};

}  // namespace

Result<Node> parse_yaml(std::string_view text, const std::string& name) {
  try {
    std::istringstream stream{std::string(text)};
    YAML::Parser parser(stream);
    Builder builder;
    if (!parser.HandleNextDocument(builder)) return Node::map();
    Builder second;
    if (parser.HandleNextDocument(second) && !second.root.is_null())
      return fail(Code::BadParameter, "a second document begins after '---'; one file holds one document",
                  place(name, second.root.mark));
    return std::move(builder.root);
  } catch (const Refused& refused) {
    return fail(Code::BadParameter, refused.message, place(name, refused.mark));
  } catch (const YAML::Exception& error) {
    return fail(Code::BadParameter, "not readable as YAML: " + error.msg, place(name, mark_of(error.mark)));
  }
}

}  // namespace scanmill::document
